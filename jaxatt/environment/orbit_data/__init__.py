"""Orbits as files and perturbed elements give them, on the host."""

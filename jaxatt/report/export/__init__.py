"""Attitude and orbit files, for other tools, of results that were saved."""

"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

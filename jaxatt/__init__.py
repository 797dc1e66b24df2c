"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

import lazy_loader

# Names are loaded when they are first used; what they are stands in `__init__.pyi`.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

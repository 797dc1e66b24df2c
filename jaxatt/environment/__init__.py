"""Orbit, orbit frame and disturbing torques."""

import lazy_loader

# Names are loaded when they are first used; what they are stands in `__init__.pyi`.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

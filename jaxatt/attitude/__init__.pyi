from . import errors, euler, mrp, quaternion, vectors

__all__ = ["errors", "euler", "mrp", "quaternion", "vectors"]

"""Attitude representations and errors: quaternions, MRP, Euler angles."""

from jaxatt.attitude import errors, euler, mrp, quaternion, vectors

__all__ = ["errors", "euler", "mrp", "quaternion", "vectors"]

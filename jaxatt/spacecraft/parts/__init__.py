"""Parts of a spacecraft as checked numbers, without JAX, which is not needed to refuse a file.

The modules of the same names beside this folder make them pytrees and compute with them.
"""

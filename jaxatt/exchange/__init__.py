"""Attitudes and orbits in the files of other tools: CCSDS, STK, tables of numbers."""

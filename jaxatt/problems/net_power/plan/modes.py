"""Modes of operation of a task."""

HARVEST, IMAGE, COMMUNICATE, IDLE = "harvest", "image", "communicate", "idle"
MODES = (HARVEST, IMAGE, COMMUNICATE, IDLE)
"""Earn energy on the way to the next task, turn over a target while taking an image, point at a
ground station, and wait."""

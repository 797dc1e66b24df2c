"""Speeds that reaction wheels avoid: around zero, where bearings suffer, or at a resonance.

A band is one of magnitudes, so that it stands for both senses of rotation; from 0 rad/s it is a
band around zero.
"""

from __future__ import annotations

from jaxatt.spacecraft.parts.speed_bands import NO_BANDS as NO_BANDS
from jaxatt.spacecraft.parts.speed_bands import speed_bands as speed_bands
from jaxatt.spacecraft.pytrees import SpeedBands as SpeedBands

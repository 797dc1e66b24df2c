"""Write an orbit as a CCSDS Orbit Ephemeris Message (OEM) of keywords and values, version 2."""

from __future__ import annotations

from jaxatt.exchange.aem import header
from jaxatt.exchange.moments import instants, written
from jaxatt.exchange.motion import FRAME, Named, OrbitHistory

_DEGREE = 7


def oem_text(history: OrbitHistory, named: Named) -> str:
    """OEM of one span of time, in kilometres."""
    stamps = written(instants(history.epoch, history.time))
    pairs = (
        ("OBJECT_NAME", named.name),
        ("OBJECT_ID", named.designator),
        ("CENTER_NAME", "EARTH"),
        ("REF_FRAME", FRAME),
        ("TIME_SYSTEM", "UTC"),
        ("START_TIME", stamps[0]),
        ("STOP_TIME", stamps[-1]),
        ("INTERPOLATION", "HERMITE"),
        ("INTERPOLATION_DEGREE", str(_DEGREE)),
    )
    lines = ["CCSDS_OEM_VERS = 2.0", *header(named), "", "META_START"]
    lines += [f"{key:<20} = {value}" for key, value in pairs]
    lines += ["META_STOP", ""]
    for stamp, place, speed in zip(stamps, history.position, history.velocity, strict=True):
        numbers = [f"{1e-3 * x: .12f}" for x in (*place, *speed)]
        lines.append(f"{stamp} {' '.join(numbers)}")
    return "\n".join(lines) + "\n"

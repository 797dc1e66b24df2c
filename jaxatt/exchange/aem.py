"""Write attitudes as a CCSDS Attitude Ephemeris Message (AEM) of keywords and values (KVN).

The attitude is the turn of REF_FRAME_A, inertial axes, into REF_FRAME_B, those of the body, with
the scalar last: the components of q_ib, the scalar behind the others.
"""

from __future__ import annotations

import datetime as dt

import numpy as np

from jaxatt.exchange.moments import instants, written
from jaxatt.exchange.motion import FRAME, AttitudeHistory, Named
from jaxatt.runtime.arrays import Floats

BODY = "SC_BODY_1"


def aem_text(histories: list[AttitudeHistory], named: Named, version: int = 2) -> str:
    """AEM of one or more spans of time; nobody is to interpolate from one to the next.

    version : 2 of CCSDS 504.0-B-2 (2024), with the rates; 1 of 504.0-B-1 (2008), attitudes only,
    with keywords for the scalar's place and the direction.
    """
    lines = [f"CCSDS_AEM_VERS = {version}.0", *header(named)]
    for history in histories:
        stamps = written(instants(history.epoch, history.time))
        lines += ["", "META_START"]
        lines += [f"{key:<20} = {value}" for key, value in metadata(stamps, named, version)]
        lines += ["META_STOP", "", "DATA_START"]
        numbers = scalar_last(history.q_ib)
        texts = [" ".join(f"{x: .15f}" for x in row) for row in numbers]
        if version == 2:
            rates = np.degrees(history.omega_ib)
            texts = [
                f"{text} {' '.join(f'{x: .15e}' for x in row)}"
                for text, row in zip(texts, rates, strict=True)
            ]
        lines += [f"{stamp} {text}" for stamp, text in zip(stamps, texts, strict=True)]
        lines.append("DATA_STOP")
    return "\n".join(lines) + "\n"


def header(named: Named) -> list[str]:
    """Lines that tell when a message was made, and by whom."""
    now = dt.datetime.now(dt.UTC).strftime("%Y-%m-%dT%H:%M:%S")
    return [f"CREATION_DATE = {now}", f"ORIGINATOR = {named.originator}"]


def metadata(stamps: list[str], named: Named, version: int) -> list[tuple[str, str]]:
    """Keywords and values of a span, in the order that the standard asks for."""
    pairs = [
        ("OBJECT_NAME", named.name),
        ("OBJECT_ID", named.designator),
        ("CENTER_NAME", "EARTH"),
        ("REF_FRAME_A", FRAME),
        ("REF_FRAME_B", BODY),
    ]
    if version == 1:
        pairs.append(("ATTITUDE_DIR", "A2B"))
    pairs += [
        ("TIME_SYSTEM", "UTC"),
        ("START_TIME", stamps[0]),
        ("STOP_TIME", stamps[-1]),
        ("ATTITUDE_TYPE", "QUATERNION" if version == 1 else "QUATERNION/ANGVEL"),
        ("QUATERNION_TYPE", "LAST") if version == 1 else ("ANGVEL_FRAME", BODY),
        ("INTERPOLATION_METHOD", "LINEAR"),
        ("INTERPOLATION_DEGREE", "1"),
    ]
    return pairs


def scalar_last(q: Floats) -> Floats:
    """Quaternions (n, 4) with the scalar behind, of continuous sign."""
    same = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0.0, -1.0, 1.0)
    q = q * np.concatenate([[1.0], np.cumprod(same)])[:, None]
    return np.concatenate([q[:, 1:], q[:, :1]], axis=1)

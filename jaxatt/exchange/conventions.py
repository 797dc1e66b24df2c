"""One attitude in the conventions of several standards and tools."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from jaxatt.attitude.host_turns import conjugate, turn_of
from jaxatt.runtime.arrays import Floats


class Written(NamedTuple):
    """An attitude as one convention writes it: whose, in which form, and the numbers.

    degrees : whether the numbers are angles in degrees.
    """

    whose: str
    form: str
    numbers: Floats
    degrees: bool = False


def conventions(q_ib: Floats) -> list[Written]:
    """The attitude q_ib (4,), a unit quaternion, in every convention of the page on them.

    It turns components in body axes into inertial ones; equally, it is the turn of the inertial
    axes into those of the body.
    """
    q = q_ib if q_ib[0] >= 0.0 else -q_ib
    back = conjugate(q)
    last = np.roll(q, -1)
    sigma = q[1:] / (1.0 + q[0])
    squared = float(sigma @ sigma)
    # At no turn at all the shadow set is at infinity.
    shadow = -sigma / squared if squared > 0.0 else np.full(3, np.inf)
    turn = Rotation.from_quat(q, scalar_first=True)
    r_ib = turn.as_matrix()
    rows = [
        Written("jaxatt", "quaternion q_ib, scalar first", q),
        Written("jaxatt", "rotation vector", np.degrees(turn_of(q)), True),
        Written("jaxatt", "MRP", sigma),
        Written("Basilisk", "sigma_BN", sigma),
        Written("Basilisk", "sigma_BN, shadow set", shadow),
        Written("Basilisk", "EP beta_BN, scalar first", q),
        Written("CCSDS", "AEM, EME2000 to SC_BODY_1: Q1 Q2 Q3 QC", last),
        Written("STK", ".a file, J2000: q1 q2 q3 q4", last),
        Written("42", "qn of a body, scalar last", last),
        Written("SciPy", "Rotation.as_quat(), body to inertial", last),
        Written("Orekit", "Rotation of an Attitude, q0 q1 q2 q3", q),
        Written("inverse", "quaternion q_bi, scalar first", back),
        Written("SPICE", "m2q of a C-matrix, J2000 to body", back),
        Written("inverse", "quaternion q_bi, scalar last", np.roll(back, -1)),
    ]
    for sequence, whose, names in (
        ("ZYX", "3-2-1", "yaw, pitch, roll"),
        ("ZXZ", "3-1-3", "first, second, third"),
        ("XYZ", "1-2-3", "first, second, third"),
        ("YXZ", "2-1-3", "first, second, third"),
    ):
        angles = _angles(turn, sequence)
        rows.append(Written(f"Euler {whose}", f"EULER_ROT_SEQ = {sequence}: {names}", angles, True))
    angles = _angles(turn, "ZYX")[::-1]
    rows.append(Written("jaxatt", "attitude_deg: phi, theta, psi", angles, True))
    rows += [Written("matrix R_ib", f"row {k + 1}, body to inertial", r_ib[k]) for k in range(3)]
    rows += [Written("matrix [BN]", f"row {k + 1}, inertial to body", r_ib.T[k]) for k in range(3)]
    return rows


def _angles(turn: Rotation, sequence: str) -> Floats:
    """Angles [deg] about the body's own axes in order; the last is 0 where it may be any."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(turn.as_euler(sequence, degrees=True))

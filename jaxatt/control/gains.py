"""Checks of a law's gains on the host, before anything is traced."""

from __future__ import annotations

import dataclasses
from typing import Any

from jaxatt.control.krstic_tsiotras import KrsticTsiotras
from jaxatt.control.latched_min_norm import LatchedMinNorm
from jaxatt.control.min_norm import GainScheduledMinNorm, MinNorm
from jaxatt.control.proportional_derivative import ProportionalDerivative
from jaxatt.control.sliding_mode import SlidingMode
from jaxatt.control.super_twisting import SuperTwisting
from jaxatt.control.tracking import Tracking
from jaxatt.spacecraft.checks import FieldError, finite_array

_SHAPES: dict[type, dict[str, tuple[int, ...]]] = {
    ProportionalDerivative: {"inertia": (3, 3), "proportional": (), "derivative": ()},
    SlidingMode: {"gain": (3,), "slope": ()},
    SuperTwisting: {"first": (3,), "second": (3,), "beta": (), "slope": ()},
    MinNorm: {"inertia": (3, 3), "proportional": (), "derivative": (), "coupling": ()},
    GainScheduledMinNorm: {
        "inertia": (3, 3),
        "proportional": (2,),
        "derivative": (2,),
        "coupling": (),
        "threshold": (),
    },
    LatchedMinNorm: {
        "inertia": (3, 3),
        "proportional": (2,),
        "derivative": (2,),
        "coupling": (),
    },
    KrsticTsiotras: {"inertia": (3, 3), "first": (), "second": (), "factor": ()},
}
_MAY_VANISH = ("proportional", "derivative", "slope", "coupling")


def check_gains(law: Any) -> None:
    """Raise an error for gains of the wrong shape or sign; a user's own laws are not checked.

    Raises `FieldError`, a `ValueError` that names the gain.
    """
    if isinstance(law, Tracking):
        check_gains(law.feedback)
        return
    for name, shape in _SHAPES.get(type(law), {}).items():
        value = finite_array(name, getattr(law, name))
        title = type(law).__name__
        if value.shape != shape:
            wanted = "one number" if shape == () else f"numbers of shape {shape}"
            raise FieldError(name, f"has shape {value.shape} in {title}; give {wanted}")
        if name == "inertia":
            continue
        least = 0.0 if name in _MAY_VANISH else None
        if (value < 0.0).any() or (least is None and not (value > 0.0).all()):
            allowed = "at least 0" if least == 0.0 else "greater than 0"
            raise FieldError(
                name,
                f"holds {value.min():g} in {title}, which would push away from the reference; "
                f"it must be {allowed}",
            )
    if _SHAPES.get(type(law)) is None and not dataclasses.is_dataclass(law) and not callable(law):
        raise FieldError("law", f"{law!r} is no law; give one of jaxatt.control or your own")

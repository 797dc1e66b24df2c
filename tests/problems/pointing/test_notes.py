"""Notes on what a search took stricter than it is."""

import dataclasses

import handmade_results
import numpy as np

from jaxatt.problems.pointing.notes import constraint_margin_notes
from jaxatt.records.pointing import Extreme, PointingRecord


def test_notes_name_the_cones_that_were_taken_stricter():
    phase = handmade_results.handmade().phases[0]
    extremes = tuple(
        Extreme(name, kind, 1.0, 0.5, 0.0, True)
        for name, kind in (("sun", "keep-out"), ("nadir", "keep-in"), ("body rate", "body-rate"))
    )
    empty = np.zeros((1, 2, 3))
    record = PointingRecord(
        time=np.zeros(1),
        angles=np.zeros((1, 2)),
        boresights=empty,
        directions=empty,
        extremes=extremes,
        constraint_margin=np.array([0.0, np.radians(0.25)]),
    )
    (note,) = constraint_margin_notes(dataclasses.replace(phase, pointing=record))
    assert note.startswith("keep-in nadir was taken 0.25 deg stricter")
    assert constraint_margin_notes(phase) == ()

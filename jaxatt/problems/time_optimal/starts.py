"""Starts of a search for a reorientation."""

from __future__ import annotations

from jaxatt.problems.time_optimal.moving_paths import moving_paths
from jaxatt.problems.time_optimal.paths import Paths
from jaxatt.problems.time_optimal.random_paths import random_paths
from jaxatt.problems.time_optimal.task import ReorientationTask


def starts_of(task: ReorientationTask, count: int, seed: int) -> Paths:
    """Draw starts of a task, of a body at rest or in motion; start i depends on seed and i only."""
    return (moving_paths if task.in_motion else random_paths)(task, count, seed)

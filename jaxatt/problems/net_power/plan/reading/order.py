"""Check that tasks follow one another without gap, overlap or a jump of attitude."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from jaxatt.problems.net_power.plan.clock import clock_text
from jaxatt.problems.net_power.plan.task import Task
from jaxatt.problems.net_power.pose import Pose, angle_between
from jaxatt.problems.reading.fields import Table

_SAME = 1e-6
"""[s], within which one task begins at the end of the one before."""


def check_times(
    table: Table, task: Task, before: float, horizon: float | None, days: float | None
) -> None:
    """Refuse a task that overlaps the one before, leaves a gap, or leaves the horizon.

    before : [s], end of the task before.  horizon : [s], length of the plan; None where the tasks
    make it.
    """
    began = "start" if "start" in table else "start_s"
    ended = next((key for key in ("end", "end_s") if key in table), "duration_s")
    at, until = clock_text(task.start, days), clock_text(before, days)
    first = "the task before ends" if before > 0.0 else "the plan begins"
    if task.start < before - _SAME:
        table.fail(
            began,
            f"overlaps: it begins at {at}, {before - task.start:g} s before {until}, when {first}",
            "begin later, or shorten the task before",
        )
    if task.start > before + _SAME:
        table.fail(
            began,
            f"leaves a gap of {task.start - before:g} s: {first} at {until}",
            'begin then, or add a task of mode "harvest" or "idle" between',
        )
    if horizon is not None and task.end > horizon + _SAME:
        table.fail(
            ended,
            f"leaves the horizon: it ends at {clock_text(task.end, days)}, "
            f"{task.end - horizon:g} s after the plan at {clock_text(horizon, days)}",
            "end earlier, or raise [horizon] horizon_s",
        )


def check_jumps(tables: Sequence[Table], tasks: Sequence[Task], initial: Pose | None) -> None:
    """Refuse a task of given attitude that begins elsewhere than the one before it ends.

    Only a harvest turns from one attitude to another.  initial : pose at the start of the plan.
    """
    now, before = initial, "the plan begins"
    for index, (table, task) in enumerate(zip(tables, tasks, strict=True)):
        if task.searched:
            now = None if index + 1 == len(tasks) else tasks[index + 1].pose
            if now is None and index + 1 < len(tasks):
                tables[index + 1].fail(
                    "attitude_quaternion",
                    "missing: the harvest before has to end in some attitude",
                    "add the attitude to wait in",
                )
            continue
        wanted = task.pose
        if now is None:
            now = wanted
        if wanted is None and now is not None:
            wanted = Pose(now.q_ib, np.zeros(3))
        if now is not None and wanted is not None:
            _check_jump(table, task, now, wanted, before)
            now = wanted.after(task.duration)
        before = f'"{task.name}" ends'


def _check_jump(table: Table, task: Task, now: Pose, wanted: Pose, before: str) -> None:
    turn = angle_between(now.q_ib, wanted.q_ib)
    change = float(np.linalg.norm(now.omega_ib - wanted.omega_ib))
    if turn <= task.attitude_tolerance and change <= task.rate_tolerance:
        return
    table.fail(
        "start",
        f"cannot be reached: {before} {math.degrees(turn):.4g} deg and "
        f"{math.degrees(change):.4g} deg/s away from its attitude and rate, and no harvest lies "
        "between",
        'add a task of mode "harvest" before it',
    )

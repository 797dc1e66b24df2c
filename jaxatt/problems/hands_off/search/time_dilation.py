"""Least final time of a support by time dilation."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.augmented_lagrangian.outer import Schedule
from jaxatt.optimize.augmented_lagrangian.solver import AugmentedLagrangian
from jaxatt.optimize.solution import Solution
from jaxatt.optimize.solver import solve
from jaxatt.problems.hands_off.least_time_program import controls_of, least_time_program, log_ratio
from jaxatt.problems.hands_off.search.candidates import evaluate, support_of
from jaxatt.problems.hands_off.search.polish import SLACK
from jaxatt.problems.hands_off.search.time_cost import Ledger, Offer, Rebuild
from jaxatt.problems.hands_off.sparse_program import SparseArguments, SparseSystem
from jaxatt.runtime.settings import QUICK_TO_COMPILE

_ROUNDS = 6
_SETTLED = 1e-8
"""Relative change of the final time at which the tables need not be made again."""


@functools.partial(jax.jit, static_argnames=("system",), compiler_options=QUICK_TO_COMPILE)
def _least_time(
    system: SparseSystem, x: Array, args: SparseArguments, sign: Array, schedule: Schedule
) -> Solution:
    placed = replace(args, plant=system.turned(args.plant, sign))
    found: Solution = solve(AugmentedLagrangian(schedule), least_time_program(system), x, placed)
    return found


def dilate_time(offer: Offer, rebuild: Rebuild, ledger: Ledger) -> Offer | None:
    """The support at its least final time; None where that was not found or is forbidden.

    The programme is solved again, with tables of the final time found, until that stays.
    """
    task, answer = offer.task, offer.answer
    support = support_of(task, answer.controls[0])
    free = np.broadcast_to(support, answer.controls[0].shape) * np.asarray(task.arguments.free)
    u = task.from_controls(answer.controls[0])
    for _ in range(_ROUNDS):
        args = replace(task.arguments, free=jnp.asarray(free))
        x = jnp.asarray(np.concatenate([u, np.zeros((len(u), 1))], axis=1))
        found = _least_time(task.system, x, args, jnp.asarray(answer.sign[0]), SLACK)
        ratio = math.exp(float(log_ratio(found.x)))
        u = np.asarray(controls_of(found.x))
        if not (np.isfinite(u).all() and ratio * task.final_time >= ledger.pricing.lowest):
            return None
        task = rebuild(offer.task, ratio * task.final_time)
        if abs(ratio - 1.0) <= _SETTLED:
            break
    status, steps = np.array([int(found.status)]), np.array([int(found.iterations)])
    ended = evaluate(task, u[None], status, steps, answer.sign)
    return ledger.offer(task, ended, "least time", exact=True)

"""Printed cost on a frozen support as a small programme in standard form.

On the support every part of the cost is smooth but the largest torque of an interval, which the
relaxed complementarity vector divides by and the L1 cost sums up.  It is a variable of its own,
no less than any torque of the interval; or that of one actuator, where those that are largest are
held by limits of their own, beside which such a variable would be one limit too many.

Sources: Schaanning (2021), eqs. (5.3), (5.5), (5.7), (5.14) and (5.15); Kristiansen and Gravdahl
(2023), eq. 11.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from jaxatt.optimize.dense.functions import Functions
from jaxatt.problems.hands_off.limit_names import bound_names, margin_names
from jaxatt.problems.hands_off.small_programme import SmallProgramme
from jaxatt.problems.hands_off.sparse_program import SparseSystem
from jaxatt.problems.hands_off.support import Support, margins_on
from jaxatt.problems.hands_off.task import SparseTask
from jaxatt.runtime.arrays import Floats

_TIED = 1e-6
"""Share of the largest torque up to which another one equals it, and of a limit up to it."""
_NEAR = 1e-3
"""Relative excess over epsilon up to which a torque is at it."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class CostArguments:
    """What the printed cost depends on.

    plant : the system's own parameters.  row_weight : (m,), of the rows at the end.
    weight : (N,), h_k of active intervals.  scale : (b,) [N m], controls of a unit of the scaled
    ones.  epsilon : () [N m].  sparsity, on_off : (), the weights k3 and k4.
    """

    plant: object
    row_weight: Array
    weight: Array
    scale: Array
    epsilon: Array
    sparsity: Array
    on_off: Array


@dataclass(frozen=True)
class Group:
    """Controls that count together: those of an interval, or one of them.

    stage : interval.  places : of the controls in the support.  leader : the one among them whose
    torque is the largest, and its sign; None where the largest is a variable.
    """

    stage: int
    places: tuple[int, ...]
    leader: tuple[int, float] | None


@dataclass(frozen=True)
class CostForm:
    """Terms of the printed cost that are compiled in.

    counts : whether active intervals are counted, or their largest torques summed.
    offset : count that the design adds.  valves : columns of the thrusters whose partly open valves
    cost.  valves_idle : whether that term has xi as its factor, as printed, or 1 - xi.
    unit : column whose unit is that of the largest torques.
    """

    counts: bool
    offset: float
    valves: tuple[int, ...]
    valves_idle: bool
    unit: int
    groups: tuple[Group, ...]

    @property
    def variables(self) -> tuple[Group, ...]:
        """The groups whose largest torque is a variable."""
        return tuple(group for group in self.groups if group.leader is None)

    @property
    def divides(self) -> bool:
        """Whether the largest torques are divided by, so that none may fall below epsilon."""
        return self.counts or bool(self.valves)


def cost_form(task: SparseTask, support: Support, u: Floats) -> CostForm:
    """Form of a task's printed cost near scaled controls u (N, b)."""
    goal, scale = task.goal, np.asarray(task.control_unit)
    counts = goal.kind != "l1"
    torque, free = support.free_of(u * scale), support.free_of(u)
    held = np.zeros(support.size, bool)
    if task.system.bounds is not None:
        columns = [j for _, j in support.places]
        lower, upper = (np.asarray(b)[columns] for b in task.system.bounds(task.arguments.plant))
        held = np.minimum(free - lower, upper - free) <= _TIED
    groups = []
    for places in _groups(support, task.shared):
        size = np.abs(torque[list(places)])
        tied = size >= (1.0 - _TIED) * size.max()
        alone = len(places) == 1 and counts
        first = places[int(np.argmax(size))]
        leads = alone or bool(held[list(places)][tied].all())
        leader = (first, float(np.sign(torque[first]))) if leads else None
        groups.append(Group(support.places[places[0]][0], places, leader))
    valves = np.flatnonzero(task.one_sided) if goal.weights.on_off > 0.0 else np.zeros(0, int)
    return CostForm(
        counts,
        -2.0 * support.intervals if counts and goal.design == 3 else 0.0,
        tuple(int(j) for j in valves),
        goal.weights.on_off_idle,
        int(scale.argmax()),
        tuple(groups),
    )


def _groups(support: Support, shared: bool) -> list[tuple[int, ...]]:
    if not shared:
        return [(i,) for i in range(support.size)]
    at = [k for k, _ in support.places]
    return [tuple(int(i) for i in np.flatnonzero(np.equal(at, k))) for k in support.stages]


@functools.cache
def cost_functions(system: SparseSystem, support: Support, form: CostForm) -> Functions:
    """Printed cost and limits, of free controls and then largest torques."""
    stages = np.array([group.stage for group in form.groups], int)
    columns = np.array([j for _, j in support.places], int)
    valves = np.array(form.valves, int)
    size = support.size
    # (variable, place) for every torque that a variable is no less than.
    pairs = [(g, i) for g, group in enumerate(form.variables) for i in group.places]
    above, below = np.array(pairs, int).reshape(-1, 2).T

    def torques(x: Array, args: CostArguments) -> Array:
        return x[:size] * (args.scale / args.scale[form.unit])[columns]

    def largest(x: Array, args: CostArguments) -> Array:
        own, rest, entries = torques(x, args), iter(range(size, len(x))), []
        for group in form.groups:
            leader = group.leader
            entries.append(x[next(rest)] if leader is None else leader[1] * own[leader[0]])
        return jnp.stack(entries)

    def objective(x: Array, args: CostArguments) -> Array:
        u, most, unit = support.spread(x), largest(x, args), args.scale[form.unit]
        total = 0.5 * jnp.sum(args.row_weight * system.rows(u, args.plant) ** 2)
        xi = args.epsilon / (most * unit)
        if form.counts:
            count = jnp.sum(args.weight[stages] * (1.0 - xi)) + form.offset
        else:
            count = jnp.sum(most) * unit
        total = total + args.sparsity * count
        if form.valves:
            limit = args.scale[valves]
            thrust = u[stages][:, valves] * limit[None]
            partly = jnp.sum(thrust * (limit[None] - thrust), axis=1)
            factor = xi if form.valves_idle else 1.0 - xi
            total = total + args.on_off * jnp.sum(factor * partly)
        return total

    def inequality(x: Array, args: CostArguments) -> Array:
        torque = torques(x, args)[below]
        most = x[size:][above]
        own = margins_on(system, support, support.spread(x), args.plant)
        parts = [most - torque, most + torque, own]
        if form.divides:
            parts.append(largest(x, args) - args.epsilon / args.scale[form.unit])
        return jnp.concatenate(parts)

    return Functions(objective, None, inequality)


def cost_arguments(task: SparseTask, plant: object) -> CostArguments:
    """Arguments of a task's printed cost."""
    goal = task.goal
    return CostArguments(
        plant,
        jnp.asarray(task.arguments.row_weight),
        jnp.asarray(task.arguments.weight),
        jnp.asarray(task.control_unit),
        *(
            jnp.asarray(float(value))
            for value in (goal.epsilon, goal.weights.sparsity, goal.weights.on_off)
        ),
    )


def cost_programme(task: SparseTask, support: Support, form: CostForm, u: Floats) -> SmallProgramme:
    """Printed cost of a task on a support, from scaled controls u (N, b)."""
    size = _sizes(task, support, form, support.free_of(u))
    most = [size[list(group.places)].max() for group in form.variables]
    pairs = [(group.stage, support.places[i][1]) for group in form.variables for i in group.places]
    signs = ("", "-")
    names = [
        f"largest torque >= {sign}torque {j}, interval {k}" for sign in signs for k, j in pairs
    ]
    names += margin_names(task, support)
    if form.divides:
        names += [f"largest torque >= epsilon, interval {group.stage}" for group in form.groups]
    names += bound_names(task, support, len(most))
    return SmallProgramme(
        cost_functions(task.system, support, form),
        cost_arguments,
        np.concatenate([support.free_of(u), most]),
        tuple(names),
        "printed cost",
        "",
    )


def _sizes(task: SparseTask, support: Support, form: CostForm, free: Floats) -> Floats:
    """Torques of free scaled controls, in units of the largest torques."""
    scale = np.asarray(task.control_unit)
    columns = [j for _, j in support.places]
    return np.asarray(np.abs(free) * scale[columns] / scale[form.unit])


def without_leaders(task: SparseTask, support: Support, form: CostForm, x: Floats) -> CostForm:
    """The form with variables for the groups in which another torque than the leader's is largest.

    x : (n,), variables of an answer.
    """
    size = _sizes(task, support, form, x[: support.size])

    def kept(group: Group) -> Group:
        largest = size[list(group.places)].max()
        led = group.leader is None or size[group.leader[0]] >= (1.0 - _TIED) * largest
        return group if led else replace(group, leader=None)

    return replace(form, groups=tuple(kept(group) for group in form.groups))


def stages_at_epsilon(
    task: SparseTask, support: Support, form: CostForm, x: Floats
) -> tuple[int, ...]:
    """Intervals whose largest torque has come down to epsilon, where the cost has a corner."""
    if not form.divides:
        return ()
    size = _sizes(task, support, form, x[: support.size])
    least = task.goal.epsilon / np.asarray(task.control_unit)[form.unit]
    at = [g.stage for g in form.groups if size[list(g.places)].max() <= (1.0 + _NEAR) * least]
    return tuple(sorted(set(at)))

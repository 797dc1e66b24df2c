"""Wheel torques that change the bias of the wheels and leave the body alone.

They are added to an answer after its search: in the intervals that it uses anyway, with the least
squared torque there, and in others only where the torque limits leave too little room.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from jaxatt.runtime.arrays import Flags, Floats

_TINY = 1e-12
_WHOLE = 1.0 - 1e-9


@dataclass(frozen=True, eq=False)
class NullTorque:
    """Torques on the wheels that cancel in the body.

    torque : (N, n) [N m].  added : (N,), intervals that have no other torque.
    share : of the change that is asked for; less than 1 where all intervals have too little room.
    """

    torque: Floats
    added: Flags
    share: float


def null_torque(
    basis: Floats, impulse: Floats, held: Floats, limit: Floats, step: float, order: list[int]
) -> NullTorque:
    """Find torques in the null space with a given impulse.

    basis : (n, m), orthonormal torques that cancel.  impulse : (m,) [N m s], along it.
    held : (N, n) [N m], what the wheels do already.  limit : (n,) [N m].
    order : idle intervals that may be used, the best first.
    """
    unit = float(limit.max())
    room, wanted = limit / unit, impulse / (unit * step)
    torque, added = np.zeros_like(held), np.zeros(len(held), bool)
    if np.abs(wanted).max(initial=0.0) <= _TINY:
        return NullTorque(torque, added, 1.0)
    active = np.flatnonzero(np.any(held != 0.0, axis=1)).tolist()

    def share(count: int) -> float:
        return _share(basis, wanted, held[[*active, *order[:count]]] / unit, room)

    few, many = -1, len(order)
    reached = share(many)
    if reached >= _WHOLE:
        while many - few > 1:  # the least number of idle intervals that is enough
            middle = (few + many) // 2
            few, many = (few, middle) if share(middle) >= _WHOLE else (middle, many)
    used = [*active, *order[:many]]
    if not used:
        return NullTorque(torque, added, 0.0)
    part = min(reached, 1.0)
    torque[used] = unit * _least(basis, part * wanted, held[used] / unit, room) @ basis.T
    added[order[:many]] = True
    return NullTorque(torque, added, part if part < _WHOLE else 1.0)


def _rows(basis: Floats, held: Floats, room: Floats) -> tuple[Floats, Floats]:
    """Torque limits as rows G z <= g on the torques z (K, m) along the basis."""
    rows = np.kron(np.eye(len(held)), basis)
    return np.vstack([rows, -rows]), np.concatenate([(room - held).ravel(), (room + held).ravel()])


def _share(basis: Floats, wanted: Floats, held: Floats, room: Floats) -> float:
    """Largest share, up to 1, of an impulse that the limits allow in these intervals."""
    if not len(held):
        return 0.0
    rows, most = _rows(basis, held, room)
    size = basis.shape[1]
    summed = np.hstack([np.tile(np.eye(size), len(held)), -wanted[:, None]])
    found = scipy.optimize.linprog(
        np.r_[np.zeros(rows.shape[1]), -1.0],
        A_ub=np.hstack([rows, np.zeros((len(rows), 1))]),
        b_ub=most,
        A_eq=summed,
        b_eq=np.zeros(size),
        bounds=[(None, None)] * rows.shape[1] + [(0.0, 1.0)],
    )
    return float(found.x[-1]) if found.success else 0.0


def _least(basis: Floats, wanted: Floats, held: Floats, room: Floats) -> Floats:
    """Torques (K, m) with a given sum whose total with `held` has the least square.

    A least-distance problem: Lawson and Hanson (1974), Solving Least Squares Problems, chapter 23.
    """
    count, size = len(held), basis.shape[1]
    along = held @ basis
    rows, most = _rows(basis, held - along @ basis.T, room)
    mean = np.tile((wanted + along.sum(axis=0)) / count, (count, 1))
    if count == 1:
        return np.asarray(mean - along)
    # Changes that keep the sum; totals of least square are the mean and the least change of it.
    free = np.kron(scipy.linalg.null_space(np.ones((1, count))), np.eye(size))
    least, short = -rows @ free, rows @ mean.ravel() - most
    if (short <= 0.0).all():
        return np.asarray(mean - along)
    goal = np.zeros(free.shape[1] + 1)
    goal[-1] = 1.0
    matrix = np.vstack([least.T, short])
    weights, _ = scipy.optimize.nnls(matrix, goal, maxiter=30 * matrix.shape[1])
    left = matrix @ weights - goal
    change = np.asarray(-left[:-1] / left[-1])
    return np.asarray((mean.ravel() + free @ change).reshape(count, size) - along)

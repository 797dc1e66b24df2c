"""Actuators as bounded controls: each wheel alone, thrusters of one torque together.

Thrusters with the same torque column and limit are one control, which opens all of them alike: no
other share of a torque takes less effort.  Two such groups of exactly opposite torques are one
control, too: its positive part opens the first, its negative part the second.  The two alone would
leave open by how much both push against each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jaxatt.runtime.arrays import Floats
from jaxatt.spacecraft.vehicle import Spacecraft

_ALIKE = 1e-9


@dataclass(frozen=True, eq=False)
class Actuation:
    """Maps and limits of b scaled controls, all on the host.

    scale : (b,) [N m], whose product with a control, squared, is that of its actuators summed up.
    lower, upper : (b,), limits of the scaled controls.
    to_body : (3, b) [N m], torque on the wheels in body axes of a unit of each scaled control.
    to_external : (3, b) [N m], the same of the thrusters.  to_wheels : (n, b) [N m].
    forth, back : (n + m, b) [N m], torques of the actuators of a unit of a control's positive and
        negative part.
    """

    scale: Floats
    lower: Floats
    upper: Floats
    to_body: Floats
    to_external: Floats
    to_wheels: Floats
    forth: Floats
    back: Floats

    @property
    def size(self) -> int:
        """Number of controls."""
        return len(self.scale)

    def torques(self, u: Floats) -> Floats:
        """Torques of wheels and thrusters, (..., n + m) [N m], of scaled controls (..., b)."""
        bounded = np.clip(u, self.lower, self.upper)
        return np.asarray(
            np.maximum(bounded, 0.0) @ self.forth.T + np.maximum(-bounded, 0.0) @ self.back.T
        )


def actuation(craft: Spacecraft) -> Actuation:
    """Controls of a vehicle."""
    wheels, thrusters = craft.wheels, craft.thrusters
    n, m = wheels.count, thrusters.count
    limit = np.concatenate([np.asarray(wheels.torque_limit), np.asarray(thrusters.torque_limit)])
    push = np.asarray(thrusters.distribution)
    unit = np.eye(n + m) * limit
    forth, back = [unit[i] for i in range(n)], [-unit[i] for i in range(n)]
    lower = [-1.0] * n
    groups = _groups(push, limit[n:])
    while groups:
        first = groups.pop(0)
        against = next((group for group in groups if _opposed(push, first, group)), None)
        opened = unit[[n + i for i in first]].sum(axis=0)
        forth.append(opened)
        if against is None:
            back.append(-opened)
            lower.append(0.0)
            continue
        groups.remove(against)
        share = limit[n + against[0]] / limit[n + first[0]]
        back.append(unit[[n + i for i in against]].sum(axis=0) / share)
        lower.append(-share)
    to_all = np.stack(forth, axis=1)
    scale = np.linalg.norm(to_all, axis=0)
    return Actuation(
        scale=scale,
        lower=np.array(lower),
        upper=np.ones(len(scale)),
        to_body=np.asarray(wheels.axes) @ to_all[:n],
        to_external=push @ to_all[n:],
        to_wheels=to_all[:n],
        forth=to_all,
        back=np.stack(back, axis=1),
    )


def _groups(push: Floats, limit: Floats) -> list[list[int]]:
    """Thrusters of the same torque column (3, m) and limit (m,), in the order of the first ones."""
    groups: list[list[int]] = []
    for i in range(len(limit)):
        for group in groups:
            alike = np.abs(push[:, i] - push[:, group[0]]).max() <= _ALIKE
            if alike and abs(limit[i] - limit[group[0]]) <= _ALIKE * limit[i]:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _opposed(push: Floats, first: list[int], second: list[int]) -> bool:
    against = np.abs(push[:, first[0]] + push[:, second[0]]).max() <= _ALIKE
    return bool(against) and len(first) == len(second)

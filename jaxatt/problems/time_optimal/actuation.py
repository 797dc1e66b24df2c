"""Actuators as bounded controls: each wheel alone, opposed thrusters as a pair.

Two thrusters of exactly opposite torques are one control: its positive part opens the first, its
negative part the second.  The pair alone would leave open by how much both push against each other.
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

    scale : (b,) [N m].  lower, upper : (b,), limits of the scaled controls.
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
    taken: set[int] = set()
    for i in range(m):
        if i in taken:
            continue
        against = [
            j
            for j in range(i + 1, m)
            if j not in taken and np.abs(push[:, i] + push[:, j]).max() <= _ALIKE
        ]
        forth.append(unit[n + i])
        if against:
            taken.add(against[0])
            share = limit[n + against[0]] / limit[n + i]
            back.append(unit[n + against[0]] / share)
            lower.append(-share)
        else:
            back.append(-unit[n + i])
            lower.append(0.0)
    to_all = np.stack(forth, axis=1)
    scale = to_all.max(axis=0)
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

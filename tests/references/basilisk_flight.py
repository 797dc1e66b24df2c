"""An open-loop flight by Basilisk (package `bsk`): body, balanced wheels, orbit, gravity gradient.

Its hub inertia is that of the whole spacecraft, the wheels' spin inertia included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Case:
    """inertia (3, 3), axes (3, n), spin inertia, start q_ib (4,), omega (3,), speeds (n,), position
    and velocity (3,), mu, torque on the wheels (n,); step and duration [s]."""

    inertia: Floats
    axes: Floats
    spin: float
    q_ib: Floats
    omega: Floats
    speeds: Floats
    position: Floats
    velocity: Floats
    mu: float
    torque: Floats
    step: float
    duration: float


def prepare(case: Case) -> tuple[Any, Any, Any]:
    """The simulation, ready to run; its recorder; and what must be kept alive."""
    from Basilisk.architecture import messaging
    from Basilisk.simulation import (
        GravityGradientEffector,
        reactionWheelStateEffector,
        spacecraft,
    )
    from Basilisk.utilities import (
        RigidBodyKinematics,
        SimulationBaseClass,
        macros,
        simIncludeGravBody,
        simIncludeRW,
    )

    sim = SimulationBaseClass.SimBaseClass()
    process = sim.CreateNewProcess("process")
    process.addTask(sim.CreateNewTask("task", macros.sec2nano(case.step)))
    craft = spacecraft.Spacecraft()
    craft.ModelTag = "craft"
    craft.hub.mHub = 7.0
    craft.hub.r_BcB_B = [[0.0], [0.0], [0.0]]
    craft.hub.IHubPntBc_B = case.inertia.tolist()
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createEarth()
    earth.isCentralBody = True
    earth.mu = case.mu
    bodies.addBodiesTo(craft)
    craft.hub.r_CN_NInit = case.position
    craft.hub.v_CN_NInit = case.velocity
    craft.hub.sigma_BNInit = [[x] for x in RigidBodyKinematics.EP2MRP(case.q_ib)]
    craft.hub.omega_BN_BInit = [[x] for x in case.omega]
    factory = simIncludeRW.rwFactory()
    for k, speed in enumerate(case.speeds):
        wheel = factory.create(
            "custom",
            case.axes[:, k],
            Omega=0.0,
            Js=case.spin,
            u_max=1.0,
            RWModel=messaging.BalancedWheels,
            useRWfriction=False,
            Omega_max=1e6,
        )
        wheel.Omega = speed
    wheels = reactionWheelStateEffector.ReactionWheelStateEffector()
    factory.addToSpacecraft("craft", wheels, craft)
    payload = messaging.ArrayMotorTorqueMsgPayload()
    payload.motorTorque = case.torque.tolist()
    message = messaging.ArrayMotorTorqueMsg()
    message.write(payload)
    wheels.rwMotorCmdInMsg.subscribeTo(message)
    tidal = GravityGradientEffector.GravityGradientEffector()
    tidal.addPlanetName(earth.planetName)
    craft.addDynamicEffector(tidal)
    for model in (craft, wheels, tidal):
        sim.AddModelToTask("task", model)
    sim.InitializeSimulation()
    sim.ConfigureStopTime(macros.sec2nano(case.duration))
    return sim, craft, (process, bodies, earth, factory, wheels, payload, message, tidal)


def fly(case: Case) -> tuple[Floats, Floats]:
    """q_ib (4,) and omega (3,) at the end."""
    from Basilisk.utilities import RigidBodyKinematics

    sim, craft, kept = prepare(case)
    sim.ExecuteSimulation()
    state = craft.scStateOutMsg.read()
    del kept
    q = np.asarray(RigidBodyKinematics.MRP2EP(state.sigma_BN)).ravel()
    return q, np.asarray(state.omega_BN_B)

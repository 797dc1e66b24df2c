"""Basilisk's tracking law (package `bsk`) flying an attitude file, which is read here by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def rows_of(path: Path) -> tuple[Floats, Floats, Floats]:
    """Seconds (n,), quaternions (n, 4) with the scalar last, and rates (n, 3) [deg/s] of an AEM."""
    lines = path.read_text().partition("DATA_START")[2].partition("DATA_STOP")[0]
    rows = [line.split() for line in lines.splitlines() if line.strip()]
    moments = np.array([row[0] for row in rows], "datetime64[ns]")
    numbers = np.array([row[1:] for row in rows], float)
    return (moments - moments[0]) / np.timedelta64(1, "s"), numbers[:, :4], numbers[:, 4:]


def fly(path: Path, inertia: Floats, step: float, gain: float, damping: float) -> Floats:
    """Quaternion of the body (4,) at the file's end, scalar last, as Basilisk has flown it."""
    from Basilisk.architecture import messaging
    from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback
    from Basilisk.simulation import extForceTorque, simpleNav, spacecraft
    from Basilisk.utilities import RigidBodyKinematics, SimulationBaseClass, macros

    time, last, rates = rows_of(path)
    sigma = np.array([RigidBodyKinematics.EP2MRP(q) for q in np.roll(last, 1, axis=1)])
    dcm = np.array([RigidBodyKinematics.MRP2C(s) for s in sigma])  # [BN]
    omega_b = np.radians(rates)
    omega_n = np.einsum("kij,ki->kj", dcm, omega_b)
    slope_n = np.gradient(omega_n, time, axis=0)

    sim = SimulationBaseClass.SimBaseClass()
    process = sim.CreateNewProcess("process")
    process.addTask(sim.CreateNewTask("task", macros.sec2nano(step)))
    craft = spacecraft.Spacecraft()
    craft.hub.mHub = 7.0
    craft.hub.IHubPntBc_B = inertia.tolist()
    craft.hub.sigma_BNInit = [[x] for x in sigma[0]]
    craft.hub.omega_BN_BInit = [[x] for x in omega_b[0]]
    torque = extForceTorque.ExtForceTorque()
    craft.addDynamicEffector(torque)
    navigation = simpleNav.SimpleNav()
    navigation.scStateInMsg.subscribeTo(craft.scStateOutMsg)
    asked = messaging.AttRefMsg()
    error = attTrackingError.attTrackingError()
    error.attNavInMsg.subscribeTo(navigation.attOutMsg)
    error.attRefInMsg.subscribeTo(asked)
    vehicle = messaging.VehicleConfigMsg()
    vehicle.write(messaging.VehicleConfigMsgPayload(ISCPntB_B=inertia.ravel().tolist()))
    law = mrpFeedback.mrpFeedback()
    law.K, law.Ki, law.P = gain, -1.0, damping
    law.guidInMsg.subscribeTo(error.attGuidOutMsg)
    law.vehConfigInMsg.subscribeTo(vehicle)
    torque.cmdTorqueInMsg.subscribeTo(law.cmdTorqueOutMsg)
    for model in (craft, navigation, error, law, torque):
        sim.AddModelToTask("task", model)

    def ask(t: float) -> None:
        row = int(np.clip(np.searchsorted(time, t + 1e-6) - 1, 0, len(time) - 2))
        x = (t - time[row]) / (time[row + 1] - time[row])
        between = [(1.0 - x) * part[row] + x * part[row + 1] for part in (last, omega_n, slope_n)]
        q = np.roll(between[0] / np.linalg.norm(between[0]), 1)
        payload = messaging.AttRefMsgPayload()
        payload.sigma_RN = np.asarray(RigidBodyKinematics.EP2MRP(q)).ravel().tolist()
        payload.omega_RN_N, payload.domega_RN_N = between[1].tolist(), between[2].tolist()
        asked.write(payload)

    ask(0.0)
    sim.InitializeSimulation()
    count = int(np.floor(time[-1] / step + 1e-9))
    for k in range(count + 1):
        ask(k * step)
        sim.ConfigureStopTime(macros.sec2nano(k * step))
        sim.ExecuteSimulation()
    state = craft.scStateOutMsg.read()
    return np.roll(np.asarray(RigidBodyKinematics.MRP2EP(state.sigma_BN)).ravel(), -1)

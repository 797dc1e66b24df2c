"""Exported attitudes flown by Basilisk; skipped where the package bsk is not installed."""

import datetime as dt
import math

import numpy as np
import pytest
from references import basilisk_tracking
from scipy.spatial.transform import Rotation

from jaxatt import scenarios, solve
from jaxatt.exchange.conventions import conventions
from jaxatt.report.archive import write_archive
from jaxatt.report.export.export import export
from jaxatt.report.export.saved_motion import saved_motion

pytest.importorskip("Basilisk", reason="Basilisk (package bsk) is not installed")

pytestmark = [
    pytest.mark.basilisk,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


def test_basilisk_flies_the_file_of_an_answer_to_its_end(tmp_path) -> None:
    result = solve("hypso1-90-45-15", starts=8)
    write_archive(result, tmp_path / "result.nc")
    epoch = dt.datetime(2026, 6, 21, 12, tzinfo=dt.UTC)
    motion = saved_motion(tmp_path)
    (file,) = export(tmp_path, epoch=epoch)
    inertia = np.asarray(scenarios.load("hypso1-90-45-15").vehicle.inertia)
    q = basilisk_tracking.fly(file.path, inertia, 0.1, 0.1, 0.2)
    asked = Rotation.from_quat(motion.paths[0].q, scalar_first=True)
    assert math.degrees((asked[-1].inv() * Rotation.from_quat(q)).magnitude()) < 0.01
    assert math.degrees((asked[0].inv() * asked[-1]).magnitude()) > 60.0


@pytest.mark.parametrize("seed", range(5))
def test_sigma_bn_is_basilisk_s(seed) -> None:
    from Basilisk.utilities import RigidBodyKinematics

    turn = Rotation.random(random_state=seed)
    rows = {
        (row.whose, row.form): row.numbers for row in conventions(turn.as_quat(scalar_first=True))
    }
    sigma = rows["Basilisk", "sigma_BN"]
    # [BN] takes inertial components to those in the body.
    dcm = np.asarray(RigidBodyKinematics.MRP2C(sigma))
    np.testing.assert_allclose(dcm, turn.inv().as_matrix(), atol=1e-12)
    np.testing.assert_allclose(
        np.asarray(
            RigidBodyKinematics.EP2MRP(rows["Basilisk", "EP beta_BN, scalar first"])
        ).ravel(),
        sigma,
        atol=1e-12,
    )
    other = np.asarray(RigidBodyKinematics.MRPswitch(sigma, 0.0)).ravel()
    np.testing.assert_allclose(other, rows["Basilisk", "sigma_BN, shadow set"], rtol=1e-10)
    angles = rows["Euler 3-2-1", "EULER_ROT_SEQ = ZYX: yaw, pitch, roll"]
    found = np.asarray(RigidBodyKinematics.MRP2Euler321(sigma)).ravel()
    np.testing.assert_allclose(np.degrees(found), angles, atol=1e-9)

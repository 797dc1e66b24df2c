"""A flight follows an attitude file, and its own file is the same motion again."""

import numpy as np
import pytest
from references import short_flights
from references.attitude_histories import EPOCH, turning
from scipy.spatial.transform import Rotation

from jaxatt.attitude.attitude_path import AttitudePath
from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.aem_reading import read_aem
from jaxatt.exchange.moments import seconds_after
from jaxatt.exchange.motion import Named
from jaxatt.report.export.export import export
from jaxatt.report.export.saved_motion import saved_motion
from jaxatt.report.flight_dataset import flight_dataset
from jaxatt.report.flight_record import FlightRecord
from jaxatt.scenarios import ScenarioError
from jaxatt.scenarios.flight_build import build_flight
from jaxatt.simulation.campaign import fly_runs

DURATION = 60.0


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """What is to be flown, and the folder of the flight."""
    folder = tmp_path_factory.mktemp("follow")
    history = turning(8, count=140, step=0.5, size=0.1)
    path = folder / "asked.aem"
    path.write_text(aem_text([history], Named("A")), encoding="utf-8")
    flight = short_flights.flight(
        environment={"epoch": EPOCH.isoformat(), "gravity_gradient": True},
        initial={
            "attitude_deg": None,
            "rate_rad_s": None,
            "aem_file": str(path),
            "wheel_speed_rad_s": [100.0, -50.0, 30.0, 20.0],
        },
        reference={"attitude_deg": None, "aem_file": str(path)},
        simulation={"duration_s": DURATION, "sampling_s": 0.1, "records": 120},
        laws={
            "pd": None,
            "tracking": {"kind": "tracking", "proportional_1_s2": 0.5, "derivative_1_s": 1.2},
        },
    )
    shared, start = build_flight(flight)
    result = FlightRecord(
        scenario=flight,
        law="tracking",
        flown=fly_runs(shared, start, flight.laws["tracking"], 1, 0),
        reference=np.asarray(shared.ends[1].attitude.array),
        spread=None,
        seed=0,
        time={},
        device="cpu",
        versions={},
    )
    flight_dataset(result).to_netcdf(folder / "flight.nc", engine="h5netcdf")
    return history, result, folder


def test_the_law_follows_the_file_closely(flown) -> None:
    history, result, _ = flown
    assert result.sound.all()
    error = 2.0 * np.degrees(np.linalg.norm(result.flown.recorded.error[0], axis=1))
    assert error.max() < 3e-3
    turned = Rotation.from_quat(history.q_ib, scalar_first=True)
    assert np.degrees((turned[0].inv() * turned).magnitude().max()) > 10.0


def test_the_file_of_the_flight_is_the_file_that_was_followed(flown, tmp_path) -> None:
    history, _, folder = flown
    motion = saved_motion(folder)
    assert motion.epoch == EPOCH
    (file,) = export(folder, tmp_path)
    (segment,) = read_aem(file.path)
    times = seconds_after(np.datetime64(EPOCH.replace(tzinfo=None), "ns"), segment.moments)
    wanted, rate = AttitudePath(history.time, history.q_ib, history.omega_ib).at(times)
    turns = Rotation.from_quat(wanted, scalar_first=True).inv() * Rotation.from_quat(
        segment.q_ib, scalar_first=True
    )
    assert np.degrees(turns.magnitude().max()) < 3e-3
    np.testing.assert_allclose(segment.omega_ib, rate, atol=1e-4)
    assert times[-1] == pytest.approx(DURATION)
    with pytest.raises(ScenarioError, match="run 1: there are 1"):
        saved_motion(folder, 1)

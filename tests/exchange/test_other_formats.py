"""STK's attitude files, tables and orbits, read back by what is not the package's."""

import csv
import datetime as dt
import io

import numpy as np
from ccsds_ndm.ndm_io import NdmIo
from references.attitude_histories import EPOCH, scipy_turn, turning
from scipy.spatial.transform import Rotation

from jaxatt.exchange.motion import Named, OrbitHistory
from jaxatt.exchange.oem import oem_text
from jaxatt.exchange.stk import stk_text
from jaxatt.exchange.table import csv_text


def test_stk_has_the_scalar_last_and_rates_in_degrees() -> None:
    history = turning(1)
    lines = [line for line in stk_text(history).splitlines() if line]
    assert lines[0].startswith("stk.v.") and lines[1] == "BEGIN Attitude"
    assert lines[-1] == "END Attitude"
    start = lines.index("AttitudeTimeQuatAngVels")
    keywords = dict(line.split(maxsplit=1) for line in lines[2:start])
    assert keywords["NumberOfAttitudePoints"] == str(len(history.time))
    assert (keywords["CoordinateAxes"], keywords["CentralBody"]) == ("J2000", "Earth")
    moment = dt.datetime.strptime(keywords["ScenarioEpoch"], "%d %b %Y %H:%M:%S.%f")
    assert moment.replace(tzinfo=dt.UTC) == EPOCH
    rows = np.array([line.split() for line in lines[start + 1 : -1]], float)
    np.testing.assert_allclose(rows[:, 0], history.time, atol=1e-9)
    turns = scipy_turn(history).inv() * Rotation.from_quat(rows[:, 1:5])
    assert turns.magnitude().max() < 1e-12
    np.testing.assert_allclose(np.radians(rows[:, 5:]), history.omega_ib, atol=1e-14)
    # Interpolated number by number, as STK does, the quaternion must not change its sign.
    assert (np.sum(rows[1:, 1:5] * rows[:-1, 1:5], axis=1) > 0.0).all()


def test_a_table_has_the_scalar_first_and_radians() -> None:
    history = turning(2)
    rows = list(csv.DictReader(io.StringIO(csv_text(history))))
    assert len(rows) == len(history.time)
    q = np.array([[row[f"q_ib_{part}"] for part in "wxyz"] for row in rows], float)
    np.testing.assert_allclose(q, history.q_ib, atol=1e-15)
    omega = [[row[f"omega_ib_{axis}_rad_s"] for axis in "xyz"] for row in rows]
    np.testing.assert_allclose(np.array(omega, float), history.omega_ib, atol=1e-15)
    moments = [dt.datetime.fromisoformat(row["utc"][:26] + "Z") for row in rows]
    seconds = [(moment - EPOCH).total_seconds() for moment in moments]
    np.testing.assert_allclose(seconds, history.time, atol=1e-6)


def test_ccsds_ndm_reads_the_orbit_in_kilometres(tmp_path) -> None:
    drawn = np.random.default_rng(5)
    time = np.linspace(0.0, 100.0, 9)
    history = OrbitHistory(
        EPOCH, time, 7e6 * drawn.normal(size=(9, 3)), 7e3 * drawn.normal(size=(9, 3))
    )
    path = tmp_path / "file.oem"
    path.write_text(oem_text(history, Named("A", "2022-002B")), encoding="utf-8")
    segment = NdmIo().from_path(path).body.segment[0]
    assert (segment.metadata.ref_frame, segment.metadata.object_id) == ("EME2000", "2022-002B")
    states = segment.data.state_vector
    place = np.array([[s.x.value, s.y.value, s.z.value] for s in states])
    speed = np.array([[s.x_dot.value, s.y_dot.value, s.z_dot.value] for s in states])
    np.testing.assert_allclose(1e3 * place, history.position, atol=1e-8)
    np.testing.assert_allclose(1e3 * speed, history.velocity, atol=1e-8)
    first = np.datetime64(EPOCH.replace(tzinfo=None), "ns")
    epochs = np.array([s.epoch for s in states], "datetime64[ns]")
    np.testing.assert_allclose((epochs - first) / np.timedelta64(1, "s"), time, atol=1e-9)

"""Attitude Ephemeris Messages, beside ccsds-ndm, and read back however they are written."""

import numpy as np
import pytest
from ccsds_ndm.mapping import NDMFileFormats
from ccsds_ndm.ndm_io import NdmIo
from references.attitude_histories import EPOCH, scipy_turn, turning
from scipy.spatial.transform import Rotation

from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.aem_reading import read_aem
from jaxatt.exchange.aem_xml import aem_xml
from jaxatt.exchange.moments import instants, seconds_after
from jaxatt.exchange.motion import AttitudeHistory, Named

SOMEBODY = Named("HYPSO-1 <&>", "2022-002B")


def written(tmp_path, text, ending="aem"):
    path = tmp_path / f"file.{ending}"
    path.write_text(text, encoding="utf-8")
    return path


def same(segment, history, rates=1e-12):
    zero = np.datetime64(EPOCH.replace(tzinfo=None), "ns")
    np.testing.assert_allclose(seconds_after(zero, segment.moments), history.time, atol=1e-9)
    turns = scipy_turn(history).inv() * Rotation.from_quat(segment.q_ib, scalar_first=True)
    assert turns.magnitude().max() < 1e-12
    np.testing.assert_allclose(segment.omega_ib, history.omega_ib, atol=rates)
    assert np.abs(history.omega_ib).max() > 0.01


def test_ccsds_ndm_reads_the_xml_as_it_was(tmp_path) -> None:
    history = turning(3)
    found = NdmIo().from_path(written(tmp_path, aem_xml([history], SOMEBODY), "xml"))
    segment = found.body.segment[0]
    meta = segment.metadata
    assert (meta.object_name, meta.object_id) == ("HYPSO-1 <&>", "2022-002B")
    assert (meta.ref_frame_a, meta.ref_frame_b) == ("EME2000", "SC_BODY_1")
    states = [state.quaternion_ang_vel for state in segment.data.attitude_state]
    q = np.array(
        [[s.quaternion.q1, s.quaternion.q2, s.quaternion.q3, s.quaternion.qc] for s in states]
    )
    # The standard's quaternion turns the frame A into B: SciPy's turns what it acts on alike.
    turns = scipy_turn(history).inv() * Rotation.from_quat(q)
    assert turns.magnitude().max() < 1e-12
    rates = np.array(
        [[getattr(s.ang_vel, f"angvel_{axis}").value for axis in "xyz"] for s in states]
    )
    np.testing.assert_allclose(rates, np.degrees(history.omega_ib), atol=1e-12)
    assert {s.ang_vel.angvel_x.units.value for s in states} == {"deg/s"}
    epochs = np.array([state.epoch for state in states], "datetime64[ns]")
    assert (epochs == instants(EPOCH, history.time)).all()


@pytest.mark.parametrize("form", [NDMFileFormats.KVN, NDMFileFormats.XML])
def test_ccsds_ndm_reads_version_1_as_it_was_and_writes_it_again(tmp_path, form) -> None:
    history = turning(4)
    path = written(tmp_path, aem_text([history, later(history)], SOMEBODY, 1))
    found = NdmIo().from_path(path)
    assert len(found.body.segment) == 2
    segment = found.body.segment[0]
    states = [state.quaternion_state.quaternion for state in segment.data.attitude_state]
    q = np.array([[s.q1, s.q2, s.q3, s.qc] for s in states])
    assert (scipy_turn(history).inv() * Rotation.from_quat(q)).magnitude().max() < 1e-12
    again = tmp_path / "again.aem"
    NdmIo().to_file(found, form, again)
    segments = read_aem(again)
    same(segments[0], history, 1e-10)
    assert len(segments) == 2


def later(history, seconds=60.0):
    return AttitudeHistory(EPOCH, history.time + seconds, history.q_ib, history.omega_ib)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("form", ["2", "1", "xml"])
def test_what_is_written_is_read(tmp_path, form, seed) -> None:
    histories = [turning(seed), later(turning(seed + 10))]
    if form == "xml":
        text = aem_xml(histories, SOMEBODY)
    else:
        text = aem_text(histories, SOMEBODY, int(form))
    found = read_aem(written(tmp_path, text))
    same(found[0], histories[0], 1e-10 if form == "1" else 1e-15)
    assert len(found) == 2
    np.testing.assert_array_equal(found[1].moments, instants(EPOCH, histories[1].time))


def by_hand(history, *, version, a, b, forward, first=False, kind="QUATERNION", frame=""):
    """An AEM in any of the ways that the standards allow, with SciPy's arithmetic."""
    turn, rate = scipy_turn(history), np.degrees(history.omega_ib)
    inertial = turn.apply(rate)
    if not forward:
        turn, rate, inertial = turn.inv(), -inertial, -rate  # of the inertial axes, in these
    q = turn.as_quat(scalar_first=first)
    rows = [q]
    if kind == "QUATERNION/DERIVATIVE":
        w = np.radians(rate)
        x, s = turn.as_quat()[:, :3], turn.as_quat()[:, 3:]
        parts = [0.5 * (s * w + np.cross(x, w)), -0.5 * np.sum(x * w, 1, keepdims=True)]
        rows += parts[::-1] if first else parts
    if kind == "QUATERNION/ANGVEL":
        rows.append(inertial if frame == a else rate)
    lines = [
        f"CCSDS_AEM_VERS = {version}",
        "COMMENT by hand",
        "CREATION_DATE = 2026-001T00:00:00",
        "ORIGINATOR = X",
        "META_START",
        f"REF_FRAME_A = {a}",
        f"REF_FRAME_B = {b}",
        "TIME_SYSTEM = UTC",
        f"ATTITUDE_TYPE = {kind}",
    ]
    if version == "1.0":
        lines.append(f"QUATERNION_TYPE = {'FIRST' if first else 'LAST'}")
        straight = forward == a.startswith("EME")
        lines.append(f"ATTITUDE_DIR = {'A2B' if straight else 'B2A'}")
    if frame:
        lines.append(f"ANGVEL_FRAME = {frame}")
    lines += ["META_STOP", "DATA_START"]
    for moment, row in zip(instants(EPOCH, history.time), np.column_stack(rows), strict=True):
        day = moment.astype("datetime64[D]")
        number = int((day - day.astype("datetime64[Y]")) / np.timedelta64(1, "D")) + 1
        clock = str(moment).partition("T")[2]
        numbers = "  ".join(f"{x:.16e}" for x in row)
        lines.append(f"{str(day)[:4]}-{number:03d}T{clock}Z {numbers}")
    return "\n".join([*lines, "DATA_STOP"]) + "\n"


BODY, SPACE = "SC_BODY_1", "EME2000"
WAYS = [
    {"version": "1.0", "a": SPACE, "b": BODY, "forward": True},
    {"version": "1.0", "a": SPACE, "b": BODY, "forward": False},
    {"version": "1.0", "a": BODY, "b": SPACE, "forward": True, "first": True},
    {"version": "1.0", "a": BODY, "b": SPACE, "forward": False, "first": True},
    {"version": "2.0", "a": SPACE, "b": BODY, "forward": True},
    {"version": "2.0", "a": BODY, "b": "GCRF", "forward": False},
    {
        "version": "1.0",
        "a": SPACE,
        "b": BODY,
        "forward": True,
        "first": True,
        "kind": "QUATERNION/DERIVATIVE",
    },
    {"version": "2.0", "a": SPACE, "b": BODY, "forward": True, "kind": "QUATERNION/DERIVATIVE"},
    {
        "version": "2.0",
        "a": SPACE,
        "b": BODY,
        "forward": True,
        "kind": "QUATERNION/ANGVEL",
        "frame": BODY,
    },
    {
        "version": "2.0",
        "a": SPACE,
        "b": BODY,
        "forward": True,
        "kind": "QUATERNION/ANGVEL",
        "frame": SPACE,
    },
    {
        "version": "2.0",
        "a": BODY,
        "b": SPACE,
        "forward": False,
        "kind": "QUATERNION/ANGVEL",
        "frame": BODY,
    },
    {
        "version": "2.0",
        "a": BODY,
        "b": SPACE,
        "forward": False,
        "kind": "QUATERNION/ANGVEL",
        "frame": SPACE,
    },
]


@pytest.mark.parametrize("way", WAYS, ids=lambda way: "-".join(map(str, way.values())))
def test_every_way_of_writing_an_attitude_is_the_same_attitude(tmp_path, way) -> None:
    history = turning(7, count=121, step=0.1)
    found = read_aem(written(tmp_path, by_hand(history, **way)))
    same(found[0], history, 1e-12 if "kind" in way else 1e-9)

"""Attitude files that cannot be used say where, why and what to do."""

import datetime as dt
import re

import numpy as np
import pytest
from references.attitude_histories import EPOCH, turning

from jaxatt.exchange.aem import aem_text
from jaxatt.exchange.aem_reading import read_aem
from jaxatt.exchange.aem_xml import aem_xml
from jaxatt.exchange.attitude_file import path_of
from jaxatt.exchange.motion import AttitudeHistory, FileFormatError, Named

HISTORY = turning(0, count=121, step=0.5)
TEXT = {1: aem_text([HISTORY], Named("A"), 1), 2: aem_text([HISTORY], Named("A"), 2)}


def refused(tmp_path, text, read=read_aem):
    path = tmp_path / "file.aem"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileFormatError) as found:
        read(path)
    message = str(found.value)
    assert message.startswith(str(path)) and "; " in message
    return message


def rows_turned(text, change):
    """The text with the four numbers of each quaternion changed."""

    def turned(found):
        numbers = [float(x) for x in found.group(2).split()]
        changed = [*change(numbers[:4]), *numbers[4:]]
        return f"{found.group(1)} {' '.join(f'{x:.15e}' for x in changed)}"

    return re.sub(r"^(20\S+)\s+(.*)$", turned, text, flags=re.M)


SCALAR_FIRST = "the scalar at the other end"
OPPOSITE = "the turn in the opposite direction"


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda q: [q[3], *q[:3]], SCALAR_FIRST),
        (lambda q: [-q[0], -q[1], -q[2], q[3]], OPPOSITE),
        (lambda q: [q[3], -q[0], -q[1], -q[2]], f"{SCALAR_FIRST} and {OPPOSITE}"),
    ],
)
def test_motion_shows_the_other_scalar_and_the_other_direction(tmp_path, change, words) -> None:
    assert f"they would with {words}: correct" in refused(tmp_path, rows_turned(TEXT[2], change))


def test_motion_shows_wrong_units_without_a_remedy(tmp_path) -> None:
    rates = np.degrees(HISTORY.omega_ib)
    text = aem_text([AttitudeHistory(EPOCH, HISTORY.time, HISTORY.q_ib, rates)], Named("A"))
    assert "check the frame and the unit of the rates" in refused(tmp_path, text)


def test_without_motion_nothing_shows(tmp_path) -> None:
    held = AttitudeHistory(EPOCH, HISTORY.time, HISTORY.q_ib[[3] * 121], np.zeros((121, 3)))
    path = tmp_path / "file.aem"
    path.write_text(rows_turned(aem_text([held], Named("A")), lambda q: [q[3], *q[:3]]))
    np.testing.assert_allclose(read_aem(path)[0].omega_ib, 0.0)


@pytest.mark.parametrize("version", [1, 2])
def test_the_norm_shows_other_columns(tmp_path, version) -> None:
    message = refused(tmp_path, rows_turned(TEXT[version], lambda q: [q[0], q[1], 0.9, q[3]]))
    assert "has norm" in message and "2026-06-21T11:59:58" in message


@pytest.mark.parametrize(
    "version, old, new, words",
    [
        (2, "= EME2000", "= TEME", "REF_FRAME_A = TEME"),
        (2, "= EME2000", "= LVLH", "known are attitudes between"),
        (1, "REF_FRAME_B          = SC_BODY_1", "REF_FRAME_B = IMU_1", "REF_FRAME_B = IMU_1"),
        (2, "ANGVEL_FRAME         = SC_BODY_1", "ANGVEL_FRAME = LVLH", "ANGVEL_FRAME = LVLH"),
        (2, "= UTC", "= TAI", "only UTC is read"),
        (1, "QUATERNION_TYPE      = LAST\n", "", "QUATERNION_TYPE is missing"),
        (1, "ATTITUDE_DIR         = A2B\n", "", "ATTITUDE_DIR is missing"),
        (2, "META_STOP", "QUATERNION_TYPE = FIRST\nMETA_STOP", "whose scalar is the last"),
        (1, "= QUATERNION\n", "= EULER_ANGLE\n", "only quaternions are read"),
        (2, "VERS = 2.0", "VERS = 3.0", "versions 1 and 2 are read"),
        (2, "CCSDS_AEM_VERS", "CCSDS_OEM_VERS", "an AEM begins with CCSDS_AEM_VERS"),
        (1, "= LAST", "= MIDDLE", "QUATERNION_TYPE is missing"),
        (2, "12:00:00.250000000 ", "12:00:00.250000000 1.0 ", "has 8 numbers behind its epoch"),
        (2, "\nDATA_STOP", "x\nDATA_STOP", "is no number; correct"),
        (2, "T12:00:00.250000000 ", "T25:00:00.250000000 ", "is no moment"),
        (2, "T12:00:00.250000000 ", "T11:00:00.250000000 ", "its epochs must increase"),
        (2, "DATA_STOP\n", "", "ends within a block of rows"),
        (2, "META_STOP", "META_STOP\n0.1 0.2", "has no place in an AEM"),
    ],
)
def test_contradictions_are_named(tmp_path, version, old, new, words) -> None:
    assert old in TEXT[version]
    assert words in refused(tmp_path, TEXT[version].replace(old, new, 1))


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda text: text.replace("</aem>", ""), "no valid XML"),
        (lambda text: text.replace("<aem ", "<!DOCTYPE x><aem "), "declares entities"),
        (lambda text: text.replace("<QC>", "<QD>").replace("</QC>", "</QD>"), "lacks QC"),
        (lambda text: text.replace("aem", "oem"), "0 elements <aem>"),
        (lambda text: text.replace("EME2000", "ITRF2000"), "REF_FRAME_A = ITRF2000"),
    ],
)
def test_xml_that_cannot_be_used(tmp_path, change, words) -> None:
    assert words in refused(tmp_path, change(aem_xml([HISTORY], Named("A"))))


def test_files_that_are_none(tmp_path) -> None:
    for content, words in ((b"\xff\xfe\x00\x01\xff", "no text in UTF-8"), (b"", "no attitudes")):
        path = tmp_path / "file.aem"
        path.write_bytes(content)
        with pytest.raises(FileFormatError, match=words):
            read_aem(path)
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_aem(tmp_path / "missing.aem")


def without(history, first, last):
    kept = (history.time < first) | (history.time > last)
    return AttitudeHistory(
        history.epoch, history.time[kept], history.q_ib[kept], history.omega_ib[kept]
    )


def asked(first, last):
    return lambda path: path_of(path, EPOCH, first, last)


def test_gaps_are_refused_with_their_times(tmp_path) -> None:
    text = aem_text([without(HISTORY, 20.2, 23.8)], Named("A"))
    message = refused(tmp_path, text, asked(0.0, 60.0))
    assert "a gap of 4 s from 2026-06-21T12:00:18.250Z to 2026-06-21T12:00:22.250Z" in message
    path = tmp_path / "file.aem"
    assert len(path_of(path, EPOCH, 0.0, 20.0).time) and len(path_of(path, EPOCH, 24.0, 60.0).time)


def test_nothing_is_taken_beyond_the_ends_or_from_one_segment_to_the_next(tmp_path) -> None:
    path = tmp_path / "file.aem"
    path.write_text(TEXT[2])
    assert "2026-06-21T11:59:58.250Z to 2026-06-21T12:00:58.250Z" in refused(
        tmp_path, TEXT[2], asked(0.0, 61.0)
    )
    halves = [
        AttitudeHistory(EPOCH, HISTORY.time[k], HISTORY.q_ib[k], HISTORY.omega_ib[k])
        for k in (slice(0, 61), slice(61, 121))
    ]
    text = aem_text(halves, Named("A"))
    assert "nothing is taken across" in refused(tmp_path, text, asked(29.0, 32.0))
    halves[1] = AttitudeHistory(EPOCH, HISTORY.time[60:], HISTORY.q_ib[60:], HISTORY.omega_ib[60:])
    path.write_text(aem_text(halves, Named("A")))  # they meet in one instant with one attitude
    found, _ = path_of(path, EPOCH, 29.0, 32.0).at(np.array([30.0]))
    assert abs(found[0] @ HISTORY.q_ib[60]) == pytest.approx(1.0, abs=1e-12)


def test_usable_times_are_kept_to(tmp_path) -> None:
    usable = "USEABLE_STOP_TIME = 2026-06-21T12:00:30\nMETA_STOP"
    text = TEXT[2].replace("META_STOP", usable)
    assert "to 2026-06-21T12:00:30.000Z" in refused(tmp_path, text, asked(0.0, 59.0))


def test_one_attitude_needs_its_rate(tmp_path) -> None:
    one = AttitudeHistory(EPOCH, HISTORY.time[:1], HISTORY.q_ib[:1], HISTORY.omega_ib[:1])
    assert "a single attitude without a rate" in refused(tmp_path, aem_text([one], Named("A"), 1))
    path = tmp_path / "file.aem"
    path.write_text(aem_text([one], Named("A"), 2))
    q, omega = path_of(path, EPOCH, 0.0, 0.0).at(np.zeros(1))
    assert abs(q[0] @ HISTORY.q_ib[0]) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(omega[0], HISTORY.omega_ib[0], atol=1e-14)


def test_steps_that_turn_too_far_are_refused(tmp_path) -> None:
    time, rate = 200.0 * np.arange(20), 0.0125
    half, zero = 0.5 * rate * time, np.zeros(20)
    q = np.stack([np.cos(half), zero, zero, np.sin(half)], axis=1)
    spinning = AttitudeHistory(EPOCH, time, q, np.tile([0.0, 0.0, rate], (20, 1)))
    text = aem_text([spinning], Named("A"))
    assert "have attitudes written more often" in refused(tmp_path, text, asked(0.0, 400.0))


def test_rounded_quaternions_of_a_slow_body_are_no_contradiction(tmp_path) -> None:
    slow = turning(6, count=400, step=0.1, size=0.01)
    text = rows_turned(aem_text([slow], Named("A")), lambda q: [round(x, 6) for x in q])
    path = tmp_path / "file.aem"
    path.write_text(text)
    assert len(read_aem(path)[0].moments) == 400
    assert SCALAR_FIRST in refused(tmp_path, rows_turned(text, lambda q: [q[3], *q[:3]]))


def test_times_may_be_far_from_the_epoch_and_of_one_instant(tmp_path) -> None:
    path = tmp_path / "file.aem"
    path.write_text(TEXT[2])
    start = EPOCH + dt.timedelta(seconds=20.5)
    found, rate = path_of(path, start, 0.0, 0.0).at(np.zeros(1))
    assert abs(found[0] @ HISTORY.q_ib[41]) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(rate[0], HISTORY.omega_ib[41], atol=1e-12)

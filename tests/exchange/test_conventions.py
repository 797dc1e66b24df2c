"""One attitude in every convention, beside SciPy and products of turns; the page holds it."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from jaxatt.cli import app
from jaxatt.exchange.conventions import conventions
from jaxatt.problems.reading.attitudes import quaternion_from_angles

PAGE = Path(__file__).parents[2] / "docs" / "conventions.md"
TURNS = {
    "X": lambda a: np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]),
    "Y": lambda a: np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]]),
    "Z": lambda a: np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]),
}


@pytest.mark.parametrize("seed", range(8))
def test_every_row_is_the_same_turn(seed) -> None:
    turn = Rotation.random(random_state=seed)
    q = turn.as_quat(scalar_first=True) * (-1) ** seed
    rows = conventions(q)
    found = {(row.whose, row.form): row.numbers for row in rows}
    assert len(found) == len(rows)
    r_ib = turn.as_matrix()
    seen = 0
    for row in rows:
        if "scalar last" in row.form or row.whose in ("CCSDS", "STK", "SciPy"):
            other = Rotation.from_quat(row.numbers)
        elif len(row.numbers) == 4:
            other = Rotation.from_quat(row.numbers, scalar_first=True)
        elif "MRP" in row.form or "sigma_BN" in row.form:
            other = Rotation.from_mrp(row.numbers)
        elif row.form == "rotation vector":
            other = Rotation.from_rotvec(np.radians(row.numbers))
        else:
            continue
        if row.whose in ("inverse", "SPICE"):
            other = other.inv()
        np.testing.assert_allclose(other.as_matrix(), r_ib, atol=1e-12, err_msg=row.form)
        seen += 1
    assert seen == 14
    for row in rows:
        sequence = re.match(r"EULER_ROT_SEQ = (\w+)", row.form)
        if sequence:
            parts = [TURNS[a](x) for a, x in zip(sequence[1], np.radians(row.numbers), strict=True)]
            np.testing.assert_allclose(parts[0] @ parts[1] @ parts[2], r_ib, atol=1e-12)
    angles = np.radians(found["jaxatt", "attitude_deg: phi, theta, psi"])
    own = quaternion_from_angles(angles)
    assert abs(own @ q) == pytest.approx(1.0, abs=1e-12)
    matrix = np.array([found["matrix R_ib", f"row {k}, body to inertial"] for k in (1, 2, 3)])
    np.testing.assert_allclose(matrix, r_ib, atol=1e-12)
    back = np.array([found["matrix [BN]", f"row {k}, inertial to body"] for k in (1, 2, 3)])
    np.testing.assert_allclose(back, r_ib.T, atol=1e-12)


def test_no_turn_and_half_a_turn_are_written() -> None:
    for q in ([1.0, 0.0, 0.0, 0.0], [0.0, 0.6, 0.0, 0.8]):
        rows = conventions(np.array(q))
        shadow = next(row for row in rows if "shadow" in row.form)
        assert all(np.isfinite(row.numbers).all() for row in rows if row is not shadow)


def test_the_page_shows_what_the_command_prints() -> None:
    found = CliRunner().invoke(app, ["conventions"])
    assert found.exit_code == 0
    assert f"```text\n{found.output}```" in PAGE.read_text(encoding="utf-8")
    other = CliRunner().invoke(app, ["conventions", "--quaternion", "0.5,0.5,0.5,0.5"])
    assert re.search(r"rotation vector +69\.282032303 +69\.28", other.output)


@pytest.mark.parametrize("given", [["--quaternion", "0,0,0,0"], ["--quaternion", "1,0,0"]])
def test_no_attitude_is_refused(given) -> None:
    found = CliRunner().invoke(app, ["conventions", *given])
    assert found.exit_code == 2 and "Error" in found.output

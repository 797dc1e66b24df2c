"""The labelled dataset, and its way through a netCDF file."""

import json

import numpy as np
import pytest

from jaxatt import scenarios
from jaxatt.report.archive import open_archive, write_archive
from jaxatt.report.dataset import to_dataset


@pytest.mark.parametrize("name", ["hypso1-90-45-15", "hypso1-path-two", "double-integrator"])
def test_round_trip(make, name, tmp_path):
    result = make(name)
    write_archive(result, tmp_path / "result.nc")
    found = open_archive(tmp_path / "result.nc")
    assert found.identical(to_dataset(result))
    again = scenarios.from_mapping(json.loads(found.attrs["scenario_document"]))
    assert again.name == name
    assert found.attrs["seed"] == 7
    assert found.attrs["time_solve_s"] == 2.5


def test_labels_and_units(make):
    found = to_dataset(make())
    assert found.q_ob.dims == ("time", "quaternion")
    assert found.torque_wheels.dims == ("interval", "wheel")
    assert found.torque_body.sel(axis="x").isel(interval=20) == -2e-3
    assert found.time.attrs["units"] == "s"
    assert found.omega_bw.attrs["units"] == "rad/s"
    assert found.interval_start.values[20] == pytest.approx(28.0)
    assert found.coasting.sum() == 20
    assert all("long_name" in found[name].attrs for name in found.variables)


def test_legs_come_first(make):
    found = to_dataset(make("hypso1-path-two"))
    assert found.q_ob.dims == ("leg", "time", "quaternion")
    assert found.leg_start.values.tolist() == [0.0, 70.0]
    assert found.leg.values.tolist() == [1, 2]


def test_statuses_are_explained(make):
    status = to_dataset(make()).start_status
    meanings = dict(
        zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True)
    )
    assert [meanings[value] for value in status.values][:3] == [
        "converged",
        "feasible",
        "infeasible",
    ]


def test_the_answer_that_reaches_is_kept(resting):
    found = to_dataset(resting)
    assert not np.abs(found.active).any()
    assert np.abs(found.alternative_torque_body).max() == 2e-3

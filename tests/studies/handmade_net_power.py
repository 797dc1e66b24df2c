"""Records of net power made by hand, so that comparisons are tested without a solve."""

from __future__ import annotations

import handmade_results
import numpy as np

from jaxatt.problems.net_power.record import Energy, NetPower
from jaxatt.records.phase import Phase

TOLERANCE = {"attitude": 1e-2, "rate": 1e-3}


def phase(
    net: float,
    *,
    baseline: float | None = None,
    errors: tuple[float, float] = (1e-4, 1e-5),
    baseline_errors: tuple[float, float] | None = None,
    seconds: float = 40.0,
    task: str = "",
    mode: str = "",
    claimed: float | None = None,
    dipole: bool = False,
) -> Phase:
    """A phase of four intervals that earns `net` joules; errors [rad, rad/s] at its end."""
    nodes = np.zeros(5)
    found = dict(zip(("attitude", "rate"), errors, strict=True))
    missed = () if baseline_errors is None else zip(("attitude", "rate"), baseline_errors)  # noqa: B905
    reached = all(found[name] <= TOLERANCE[name] for name in found)
    return Phase(
        family="net-power",
        start_time=0.0,
        step=seconds / 4.0,
        controls=np.full((4, 3), 0.1 if dipole else 1e-3),
        series={"net_energy": np.linspace(0.0, net, 5), "light": nodes + 1.0},
        reference={},
        errors=found,
        tolerances=TOLERANCE,
        limit_violation=0.0,
        margin_violation=0.0,
        objective={"solar energy": -net - 10.0, "actuation": 4.0, "loads": 6.0},
        l1_effort=0.1,
        reached=reached,
        failure_reason="" if reached else "the attitude is missed",
        active=np.ones(4, bool),
        starts=handmade_results.starts_record(),
        section=NetPower(
            energy=Energy(net + 10.0, 4.0, 6.0, baseline),
            claimed=net if claimed is None else claimed,
            start_energy=np.full(6, net),
            start_score=np.full(6, net),
            share=0.5,
            minima=2,
            refined=6,
            violation=1e-9,
            stationarity=1e-7,
            shadow=(),
            baseline={},
            baseline_errors=dict(missed),
            task=task,
            mode=mode,
        ),
    )

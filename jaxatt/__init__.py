"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

from jaxatt import scenarios
from jaxatt.certificate import Certificate, certify
from jaxatt.minimization import Minimum, minimize
from jaxatt.report.archive import open_archive
from jaxatt.report.flight_result import FlightResult
from jaxatt.report.result import Leg, Result
from jaxatt.runtime import configure
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.simulating import simulate
from jaxatt.solving import solve
from jaxatt.studies.comparison import compare
from jaxatt.studies.effort_sweep import EffortSweep, sweep_effort
from jaxatt.studies.flight_comparison import FlightComparison, compare_flight
from jaxatt.studies.relative_sparsity import relative_sparsity

__all__ = [
    "Certificate",
    "EffortSweep",
    "FlightComparison",
    "FlightResult",
    "Leg",
    "Minimum",
    "Result",
    "Scenario",
    "ScenarioError",
    "certify",
    "compare",
    "compare_flight",
    "configure",
    "minimize",
    "open_archive",
    "relative_sparsity",
    "scenarios",
    "simulate",
    "solve",
    "sweep_effort",
]

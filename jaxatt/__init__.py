"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

from jaxatt import scenarios
from jaxatt.comparison import compare
from jaxatt.report.archive import open_archive
from jaxatt.report.result import Leg, Result
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.solving import solve

__all__ = [
    "Leg",
    "Result",
    "Scenario",
    "ScenarioError",
    "compare",
    "open_archive",
    "scenarios",
    "solve",
]

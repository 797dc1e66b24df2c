"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

from jaxatt import scenarios
from jaxatt.certificate import Certificate, certify
from jaxatt.comparison import compare
from jaxatt.minimization import Minimum, minimize
from jaxatt.relative_sparsity import relative_sparsity
from jaxatt.report.archive import open_archive
from jaxatt.report.result import Leg, Result
from jaxatt.runtime import configure
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.solving import solve

__all__ = [
    "Certificate",
    "Leg",
    "Minimum",
    "Result",
    "Scenario",
    "ScenarioError",
    "certify",
    "compare",
    "configure",
    "minimize",
    "open_archive",
    "relative_sparsity",
    "scenarios",
    "solve",
]

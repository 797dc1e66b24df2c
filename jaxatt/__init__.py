"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

from jaxatt import scenarios
from jaxatt.report.result import Leg, Result
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.solving import solve

__all__ = ["Leg", "Result", "Scenario", "ScenarioError", "scenarios", "solve"]

"""Differentiable spacecraft attitude simulation and batched trajectory optimisation in JAX."""

from jaxatt import scenarios
from jaxatt.multistart.differentiable import differentiable_minimum, differentiable_program
from jaxatt.multistart.minimize import Minimum, minimize
from jaxatt.multistart.programs.solution import ProgramSolution
from jaxatt.multistart.programs.solve import solve_program
from jaxatt.optimize.optimal_control import OptimalControlProgram
from jaxatt.optimize.sensitivity.optimum import Optimum
from jaxatt.optimize.sensitivity.record import Sensitivities
from jaxatt.optimize.transcription.transcribe import transcribe
from jaxatt.pipeline.certify import certify
from jaxatt.pipeline.simulate import simulate
from jaxatt.pipeline.solve import solve
from jaxatt.problems.hands_off.report.certificate import Certificate
from jaxatt.records.phase import Phase
from jaxatt.report.archive import open_archive
from jaxatt.report.export.export import export
from jaxatt.report.flight_result import FlightResult
from jaxatt.report.result import Result
from jaxatt.runtime.settings import configure
from jaxatt.scenarios import Scenario, ScenarioError
from jaxatt.studies.attitude_map.map import AttitudeMap, attitude_map
from jaxatt.studies.compare import compare
from jaxatt.studies.design.design import design
from jaxatt.studies.design.result import Design
from jaxatt.studies.flight_comparison import FlightComparison, compare_flight
from jaxatt.studies.orbit_course.result import OrbitCourse, orbit_course
from jaxatt.studies.pareto import pareto
from jaxatt.studies.pareto_front import ParetoFront
from jaxatt.studies.relative_sparsity import relative_sparsity
from jaxatt.studies.sensitivity.result import ScenarioSensitivities
from jaxatt.studies.sensitivity.sensitivities import sensitivities
from jaxatt.studies.stored import open_study
from jaxatt.studies.sweep.sweep import Sweep, sweep

Leg = Phase  # its earlier name

__all__ = [
    "AttitudeMap",
    "Certificate",
    "Design",
    "FlightComparison",
    "FlightResult",
    "Leg",
    "Minimum",
    "OptimalControlProgram",
    "Optimum",
    "OrbitCourse",
    "ParetoFront",
    "Phase",
    "ProgramSolution",
    "Result",
    "Scenario",
    "ScenarioError",
    "ScenarioSensitivities",
    "Sensitivities",
    "Sweep",
    "attitude_map",
    "certify",
    "compare",
    "compare_flight",
    "configure",
    "design",
    "differentiable_minimum",
    "differentiable_program",
    "export",
    "minimize",
    "open_archive",
    "open_study",
    "orbit_course",
    "pareto",
    "relative_sparsity",
    "scenarios",
    "sensitivities",
    "simulate",
    "solve",
    "solve_program",
    "sweep",
    "transcribe",
]

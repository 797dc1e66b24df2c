from . import scenarios
from .multistart.differentiable import differentiable_minimum, differentiable_program
from .multistart.minimize import Minimum, minimize
from .multistart.programs.solution import ProgramSolution
from .multistart.programs.solve import solve_program
from .optimize.optimal_control import OptimalControlProgram
from .optimize.sensitivity.optimum import Optimum
from .optimize.sensitivity.record import Sensitivities
from .optimize.transcription.transcribe import transcribe
from .pipeline.certify import certify
from .pipeline.simulate import simulate
from .pipeline.solve import solve
from .problems.hands_off.report.certificate import Certificate
from .records.phase import Phase
from .report.archive import open_archive
from .report.export.export import export
from .report.flight_result import FlightResult
from .report.result import Result
from .runtime.settings import configure
from .scenarios import Scenario, ScenarioError
from .studies.attitude_map.map import AttitudeMap, attitude_map
from .studies.compare import compare
from .studies.design.design import design
from .studies.design.result import Design
from .studies.flight_comparison import FlightComparison, compare_flight
from .studies.orbit_course.result import OrbitCourse, orbit_course
from .studies.pareto import pareto
from .studies.pareto_front import ParetoFront
from .studies.relative_sparsity import relative_sparsity
from .studies.sensitivity.result import ScenarioSensitivities
from .studies.sensitivity.sensitivities import sensitivities
from .studies.stored import open_study
from .studies.sweep.sweep import Sweep, sweep

__all__ = [
    "AttitudeMap",
    "Certificate",
    "Design",
    "FlightComparison",
    "FlightResult",
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

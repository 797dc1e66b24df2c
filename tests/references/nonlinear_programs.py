"""Small published programmes, each written once for any array module.

Every function takes (x, xp): x a sequence of n numbers, xp a module with exp, log, sin, cos, sqrt,
atan, array and sum.  Lists of equalities are zero and lists of inequalities non-negative when met.

Sources
HS n : Hock & Schittkowski, Test Examples for Nonlinear Programming Codes (1981), problem n.
MGH n : More, Garbow & Hillstrom, Testing Unconstrained Optimization Software (1981), problem n.
MacMPEC : Leyffer, MacMPEC, AMPL collection of MPECs, with x'y <= 0 for complementarity.
WB : Waechter & Biegler, Failure of global convergence for a class of interior point methods (2000).
BCN : Byrd, Curtis & Nocedal, Infeasibility detection and SQP methods (2010).
S n : Schittkowski, More Test Examples for Nonlinear Programming Codes (1987), problem n.
Others are textbook examples, named by what they lack.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

INF = math.inf
ROOT2, ROOT3 = math.sqrt(2.0), math.sqrt(3.0)

Function = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class NonlinearProgram:
    """One problem: optimum is the published objective, None where there is none.

    answer : "optimum", "infeasible" or "unbounded".  qualified : whether multipliers exist.
    """

    name: str
    source: str
    x0: tuple[float, ...]
    objective: Function
    optimum: float | None
    equality: Function | None = None
    inequality: Function | None = None
    lower: tuple[float, ...] | None = None
    upper: tuple[float, ...] | None = None
    answer: str = "optimum"
    qualified: bool = True


PROGRAMS: list[NonlinearProgram] = []


def _add(
    name: str,
    x0: Any,
    objective: Function,
    optimum: float | None,
    h: Function | None = None,
    g: Function | None = None,
    lower: Any = None,
    upper: Any = None,
    source: str | None = None,
    answer: str = "optimum",
    qualified: bool = True,
) -> None:
    def vector(bound: Any) -> tuple[float, ...] | None:
        if bound is None:
            return None
        return (float(bound),) * len(x0) if isinstance(bound, int | float) else tuple(bound)

    PROGRAMS.append(
        NonlinearProgram(
            name, source or name, tuple(map(float, x0)), objective, optimum, h, g,
            vector(lower), vector(upper), answer, qualified,
        )
    )  # fmt: skip


def product(x: Any) -> Any:
    result = x[0]
    for value in x[1:]:
        result = result * value
    return result


def squares(x: Any) -> Any:
    return sum(value**2 for value in x)


def rosenbrock(x: Any, xp: Any) -> Any:
    return 100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2


def wood(x: Any, xp: Any) -> Any:
    return (
        100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2 + 90 * (x[3] - x[2] ** 2) ** 2
        + (1 - x[2]) ** 2 + 10.1 * ((x[1] - 1) ** 2 + (x[3] - 1) ** 2)
        + 19.8 * (x[1] - 1) * (x[3] - 1)
    )  # fmt: skip


# --- Hock & Schittkowski --------------------------------------------------------------------

_add("HS1", (-2, 1), rosenbrock, 0.0, lower=(-INF, -1.5))
_add("HS2", (-2, 1), rosenbrock, 0.0504261879, lower=(-INF, 1.5))
_add("HS3", (10, 1), lambda x, xp: x[1] + 1e-5 * (x[1] - x[0]) ** 2, 0.0, lower=(-INF, 0))
_add("HS4", (1.125, 0.125), lambda x, xp: (x[0] + 1) ** 3 / 3 + x[1], 8 / 3, lower=(1, 0))
_add(
    "HS5", (0, 0),
    lambda x, xp: xp.sin(x[0] + x[1]) + (x[0] - x[1]) ** 2 - 1.5 * x[0] + 2.5 * x[1] + 1,
    -ROOT3 / 2 - math.pi / 3, lower=(-1.5, -3), upper=(4, 3),
)  # fmt: skip
_add("HS6", (-1.2, 1), lambda x, xp: (1 - x[0]) ** 2, 0.0, lambda x, xp: [10 * (x[1] - x[0] ** 2)])
_add(
    "HS7", (2, 2), lambda x, xp: xp.log(1 + x[0] ** 2) - x[1], -ROOT3,
    lambda x, xp: [(1 + x[0] ** 2) ** 2 + x[1] ** 2 - 4],
)  # fmt: skip
_add(
    "HS8", (2, 1), lambda x, xp: -1 + 0 * x[0], -1.0,
    lambda x, xp: [x[0] ** 2 + x[1] ** 2 - 25, x[0] * x[1] - 9],
)  # fmt: skip
_add(
    "HS9", (0, 0), lambda x, xp: xp.sin(math.pi * x[0] / 12) * xp.cos(math.pi * x[1] / 16), -0.5,
    lambda x, xp: [4 * x[0] - 3 * x[1]],
)  # fmt: skip
_add(
    "HS10", (-10, 10), lambda x, xp: x[0] - x[1], -1.0,
    g=lambda x, xp: [-3 * x[0] ** 2 + 2 * x[0] * x[1] - x[1] ** 2 + 1],
)  # fmt: skip
_add(
    "HS11", (4.9, 0.1), lambda x, xp: (x[0] - 5) ** 2 + x[1] ** 2 - 25, -8.498464223,
    g=lambda x, xp: [-(x[0] ** 2) + x[1]],
)  # fmt: skip
_add(
    "HS12", (0, 0),
    lambda x, xp: 0.5 * x[0] ** 2 + x[1] ** 2 - x[0] * x[1] - 7 * x[0] - 7 * x[1], -30.0,
    g=lambda x, xp: [25 - 4 * x[0] ** 2 - x[1] ** 2],
)  # fmt: skip
_add(
    "HS13", (-2, -2), lambda x, xp: (x[0] - 2) ** 2 + x[1] ** 2, 1.0,
    g=lambda x, xp: [(1 - x[0]) ** 3 - x[1]], lower=0, qualified=False,
)  # fmt: skip
_add(
    "HS14", (2, 2), lambda x, xp: (x[0] - 2) ** 2 + (x[1] - 1) ** 2, 9 - 2.875 * math.sqrt(7),
    lambda x, xp: [x[0] - 2 * x[1] + 1], lambda x, xp: [-0.25 * x[0] ** 2 - x[1] ** 2 + 1],
)  # fmt: skip
_add(
    "HS15", (-2, 1), rosenbrock, 306.5,
    g=lambda x, xp: [x[0] * x[1] - 1, x[0] + x[1] ** 2], upper=(0.5, INF),
)  # fmt: skip
_add(
    "HS16", (-2, 1), rosenbrock, 0.25, g=lambda x, xp: [x[0] + x[1] ** 2, x[0] ** 2 + x[1]],
    lower=(-0.5, -INF), upper=(0.5, 1),
)  # fmt: skip
_add(
    "HS17", (-2, 1), rosenbrock, 1.0, g=lambda x, xp: [x[1] ** 2 - x[0], x[0] ** 2 - x[1]],
    lower=(-0.5, -INF), upper=(0.5, 1),
)  # fmt: skip
_add(
    "HS18", (2, 2), lambda x, xp: 0.01 * x[0] ** 2 + x[1] ** 2, 5.0,
    g=lambda x, xp: [x[0] * x[1] - 25, x[0] ** 2 + x[1] ** 2 - 25], lower=(2, 0), upper=50,
)  # fmt: skip
_add(
    "HS19", (20.1, 5.84), lambda x, xp: (x[0] - 10) ** 3 + (x[1] - 20) ** 3, -6961.81381,
    g=lambda x, xp: [
        (x[0] - 5) ** 2 + (x[1] - 5) ** 2 - 100,
        -((x[1] - 5) ** 2) - (x[0] - 6) ** 2 + 82.81,
    ],
    lower=(13, 0), upper=100,
)  # fmt: skip
_add(
    "HS20", (-2, 1), rosenbrock, 81.5 - 25 * ROOT3,
    g=lambda x, xp: [x[0] + x[1] ** 2, x[0] ** 2 + x[1], x[0] ** 2 + x[1] ** 2 - 1],
    lower=(-0.5, -INF), upper=(0.5, INF),
)  # fmt: skip
_add(
    "HS21", (-1, -1), lambda x, xp: 0.01 * x[0] ** 2 + x[1] ** 2 - 100, -99.96,
    g=lambda x, xp: [10 * x[0] - x[1] - 10], lower=(2, -50), upper=50,
)  # fmt: skip
_add(
    "HS22", (2, 2), lambda x, xp: (x[0] - 2) ** 2 + (x[1] - 1) ** 2, 1.0,
    g=lambda x, xp: [-x[0] - x[1] + 2, -(x[0] ** 2) + x[1]],
)  # fmt: skip
_add(
    "HS23", (3, 1), lambda x, xp: x[0] ** 2 + x[1] ** 2, 2.0,
    g=lambda x, xp: [
        x[0] + x[1] - 1, x[0] ** 2 + x[1] ** 2 - 1, 9 * x[0] ** 2 + x[1] ** 2 - 9,
        x[0] ** 2 - x[1], x[1] ** 2 - x[0],
    ],
    lower=-50, upper=50,
)  # fmt: skip
_add(
    "HS24", (1, 0.5), lambda x, xp: ((x[0] - 3) ** 2 - 9) * x[1] ** 3 / (27 * ROOT3), -1.0,
    g=lambda x, xp: [x[0] / ROOT3 - x[1], x[0] + ROOT3 * x[1], -x[0] - ROOT3 * x[1] + 6], lower=0,
)  # fmt: skip


def _hs25(x: Any, xp: Any) -> Any:
    part = [0.01 * i for i in range(1, 100)]
    u = xp.array([25 + (-50 * math.log(p)) ** (2 / 3) for p in part])
    return xp.sum((xp.exp(-xp.exp(x[2] * xp.log(u - x[1])) / x[0]) - xp.array(part)) ** 2)


_add("HS25", (100, 12.5, 3), _hs25, 0.0, lower=(0.1, 0, 0), upper=(100, 25.6, 5))
_add(
    "HS26", (-2.6, 2, 2), lambda x, xp: (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 4, 0.0,
    lambda x, xp: [(1 + x[1] ** 2) * x[0] + x[2] ** 4 - 3],
)  # fmt: skip
_add(
    "HS27", (2, 2, 2), lambda x, xp: 0.01 * (x[0] - 1) ** 2 + (x[1] - x[0] ** 2) ** 2, 0.04,
    lambda x, xp: [x[0] + x[2] ** 2 + 1],
)  # fmt: skip
_add(
    "HS28", (-4, 1, 1), lambda x, xp: (x[0] + x[1]) ** 2 + (x[1] + x[2]) ** 2, 0.0,
    lambda x, xp: [x[0] + 2 * x[1] + 3 * x[2] - 1],
)  # fmt: skip
_add(
    "HS29", (1, 1, 1), lambda x, xp: -product(x), -16 * ROOT2,
    g=lambda x, xp: [-(x[0] ** 2) - 2 * x[1] ** 2 - 4 * x[2] ** 2 + 48],
)  # fmt: skip
_add(
    "HS30", (1, 1, 1), lambda x, xp: squares(x), 1.0, g=lambda x, xp: [x[0] ** 2 + x[1] ** 2 - 1],
    lower=(1, -10, -10), upper=10,
)  # fmt: skip
_add(
    "HS31", (1, 1, 1), lambda x, xp: 9 * x[0] ** 2 + x[1] ** 2 + 9 * x[2] ** 2, 6.0,
    g=lambda x, xp: [x[0] * x[1] - 1], lower=(-10, 1, -10), upper=(10, 10, 1),
)  # fmt: skip
_add(
    "HS32", (0.1, 0.7, 0.2), lambda x, xp: (x[0] + 3 * x[1] + x[2]) ** 2 + 4 * (x[0] - x[1]) ** 2,
    1.0, lambda x, xp: [1 - x[0] - x[1] - x[2]],
    lambda x, xp: [6 * x[1] + 4 * x[2] - x[0] ** 3 - 3], lower=0,
)  # fmt: skip
_add(
    "HS33", (0, 0, 3), lambda x, xp: (x[0] - 1) * (x[0] - 2) * (x[0] - 3) + x[2], ROOT2 - 6,
    g=lambda x, xp: [x[2] ** 2 - x[1] ** 2 - x[0] ** 2, squares(x) - 4],
    lower=0, upper=(INF, INF, 5),
)  # fmt: skip
_add(
    "HS34", (0, 1.05, 2.9), lambda x, xp: -x[0], -math.log(math.log(10)),
    g=lambda x, xp: [x[1] - xp.exp(x[0]), x[2] - xp.exp(x[1])], lower=0, upper=(100, 100, 10),
)  # fmt: skip
_add(
    "HS35", (0.5, 0.5, 0.5),
    lambda x, xp: (
        9 - 8 * x[0] - 6 * x[1] - 4 * x[2] + 2 * x[0] ** 2 + 2 * x[1] ** 2 + x[2] ** 2
        + 2 * x[0] * x[1] + 2 * x[0] * x[2]
    ),
    1 / 9, g=lambda x, xp: [3 - x[0] - x[1] - 2 * x[2]], lower=0,
)  # fmt: skip
_add(
    "HS36", (10, 10, 10), lambda x, xp: -product(x), -3300.0,
    g=lambda x, xp: [72 - x[0] - 2 * x[1] - 2 * x[2]], lower=0, upper=(20, 11, 42),
)  # fmt: skip
_add(
    "HS37", (10, 10, 10), lambda x, xp: -product(x), -3456.0,
    g=lambda x, xp: [72 - x[0] - 2 * x[1] - 2 * x[2], x[0] + 2 * x[1] + 2 * x[2]],
    lower=0, upper=42,
)  # fmt: skip
_add("HS38", (-3, -1, -3, -1), wood, 0.0, lower=-10, upper=10)
_add(
    "HS39", (2, 2, 2, 2), lambda x, xp: -x[0], -1.0,
    lambda x, xp: [x[1] - x[0] ** 3 - x[2] ** 2, x[0] ** 2 - x[1] - x[3] ** 2],
)  # fmt: skip
_add(
    "HS40", (0.8,) * 4, lambda x, xp: -product(x), -0.25,
    lambda x, xp: [x[0] ** 3 + x[1] ** 2 - 1, x[0] ** 2 * x[3] - x[2], x[3] ** 2 - x[1]],
)  # fmt: skip
_add(
    "HS41", (2, 2, 2, 2), lambda x, xp: 2 - x[0] * x[1] * x[2], 52 / 27,
    lambda x, xp: [x[0] + 2 * x[1] + 2 * x[2] - x[3]], lower=0, upper=(1, 1, 1, 2),
)  # fmt: skip
_add(
    "HS42", (1, 1, 1, 1), lambda x, xp: sum((x[i] - i - 1) ** 2 for i in range(4)),
    28 - 10 * ROOT2, lambda x, xp: [x[0] - 2, x[2] ** 2 + x[3] ** 2 - 2],
)  # fmt: skip
_add(
    "HS43", (0, 0, 0, 0),
    lambda x, xp: (
        x[0] ** 2 + x[1] ** 2 + 2 * x[2] ** 2 + x[3] ** 2 - 5 * x[0] - 5 * x[1] - 21 * x[2]
        + 7 * x[3]
    ),
    -44.0,
    g=lambda x, xp: [
        8 - squares(x) - x[0] + x[1] - x[2] + x[3],
        10 - x[0] ** 2 - 2 * x[1] ** 2 - x[2] ** 2 - 2 * x[3] ** 2 + x[0] + x[3],
        5 - 2 * x[0] ** 2 - x[1] ** 2 - x[2] ** 2 - 2 * x[0] + x[1] + x[3],
    ],
)  # fmt: skip
_add(
    "HS44", (0, 0, 0, 0),
    lambda x, xp: (
        x[0] - x[1] - x[2] - x[0] * x[2] + x[0] * x[3] + x[1] * x[2] - x[1] * x[3]
    ),
    -15.0,
    g=lambda x, xp: [
        8 - x[0] - 2 * x[1], 12 - 4 * x[0] - x[1], 12 - 3 * x[0] - 4 * x[1],
        8 - 2 * x[2] - x[3], 8 - x[2] - 2 * x[3], 5 - x[2] - x[3],
    ],
    lower=0,
)  # fmt: skip
_add("HS45", (2,) * 5, lambda x, xp: 2 - product(x) / 120, 1.0, lower=0, upper=(1, 2, 3, 4, 5))


def _hs46(x: Any, xp: Any) -> Any:
    return (x[0] - x[1]) ** 2 + (x[2] - 1) ** 2 + (x[3] - 1) ** 4 + (x[4] - 1) ** 6


_add(
    "HS46", (ROOT2 / 2, 1.75, 0.5, 2, 2), _hs46, 0.0,
    lambda x, xp: [
        x[0] ** 2 * x[3] + xp.sin(x[3] - x[4]) - 1, x[1] + x[2] ** 4 * x[3] ** 2 - 2,
    ],
)  # fmt: skip
_add(
    "HS48", (3, 5, -3, 2, -2),
    lambda x, xp: (x[0] - 1) ** 2 + (x[1] - x[2]) ** 2 + (x[3] - x[4]) ** 2, 0.0,
    lambda x, xp: [x[0] + x[1] + x[2] + x[3] + x[4] - 5, x[2] - 2 * (x[3] + x[4]) + 3],
)  # fmt: skip
_add(
    "HS49", (10, 7, 2, -3, 0.8), _hs46, 0.0,
    lambda x, xp: [x[0] + x[1] + x[2] + 4 * x[3] - 7, x[2] + 5 * x[4] - 6],
)  # fmt: skip
_add(
    "HS50", (35, -31, 11, 5, -5),
    lambda x, xp: (
        (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 2 + (x[2] - x[3]) ** 4 + (x[3] - x[4]) ** 2
    ),
    0.0,
    lambda x, xp: [x[i] + 2 * x[i + 1] + 3 * x[i + 2] - 6 for i in range(3)],
)  # fmt: skip


def _hs51(x: Any, xp: Any) -> Any:
    return (x[0] - x[1]) ** 2 + (x[1] + x[2] - 2) ** 2 + (x[3] - 1) ** 2 + (x[4] - 1) ** 2


_add(
    "HS51", (2.5, 0.5, 2, -1, 0.5), _hs51, 0.0,
    lambda x, xp: [x[0] + 3 * x[1] - 4, x[2] + x[3] - 2 * x[4], x[1] - x[4]],
)  # fmt: skip
_add(
    "HS52", (2,) * 5,
    lambda x, xp: (
        (4 * x[0] - x[1]) ** 2 + (x[1] + x[2] - 2) ** 2 + (x[3] - 1) ** 2 + (x[4] - 1) ** 2
    ),
    1859 / 349, lambda x, xp: [x[0] + 3 * x[1], x[2] + x[3] - 2 * x[4], x[1] - x[4]],
)  # fmt: skip
_add(
    "HS53", (2,) * 5, _hs51, 176 / 43,
    lambda x, xp: [x[0] + 3 * x[1], x[2] + x[3] - 2 * x[4], x[1] - x[4]], lower=-10, upper=10,
)  # fmt: skip
_add(
    "HS55", (1, 2, 0, 0, 0, 2),
    lambda x, xp: x[0] + 2 * x[1] + 4 * x[4] + xp.exp(x[0] * x[3]), 19 / 3,
    lambda x, xp: [
        x[0] + 2 * x[1] + 5 * x[4] - 6, x[0] + x[1] + x[2] - 3, x[3] + x[4] + x[5] - 2,
        x[0] + x[3] - 1, x[1] + x[4] - 2, x[2] + x[5] - 2,
    ],
    lower=0, upper=(1, INF, INF, 1, INF, INF),
)  # fmt: skip
_A, _B = math.asin(math.sqrt(1 / 4.2)), math.asin(math.sqrt(5 / 7.2))
_add(
    "HS56", (1, 1, 1, _A, _A, _A, _B), lambda x, xp: -x[0] * x[1] * x[2], -3.456,
    lambda x, xp: [
        x[0] - 4.2 * xp.sin(x[3]) ** 2, x[1] - 4.2 * xp.sin(x[4]) ** 2,
        x[2] - 4.2 * xp.sin(x[5]) ** 2, x[0] + 2 * x[1] + 2 * x[2] - 7.2 * xp.sin(x[6]) ** 2,
    ],
)  # fmt: skip
_add(
    "HS60", (2, 2, 2), lambda x, xp: (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 4,
    0.03256820025, lambda x, xp: [x[0] * (1 + x[1] ** 2) + x[2] ** 4 - 4 - 3 * ROOT2],
    lower=-10, upper=10,
)  # fmt: skip
_add(
    "HS61", (0, 0, 0),
    lambda x, xp: (
        4 * x[0] ** 2 + 2 * x[1] ** 2 + 2 * x[2] ** 2 - 33 * x[0] + 16 * x[1] - 24 * x[2]
    ),
    -143.6461422, lambda x, xp: [3 * x[0] - 2 * x[1] ** 2 - 7, 4 * x[0] - x[2] ** 2 - 11],
)  # fmt: skip
_add(
    "HS62", (0.7, 0.2, 0.1),
    lambda x, xp: -32.174 * (
        255 * xp.log((x[0] + x[1] + x[2] + 0.03) / (0.09 * x[0] + x[1] + x[2] + 0.03))
        + 280 * xp.log((x[1] + x[2] + 0.03) / (0.07 * x[1] + x[2] + 0.03))
        + 290 * xp.log((x[2] + 0.03) / (0.13 * x[2] + 0.03))
    ),
    -26272.51448, lambda x, xp: [x[0] + x[1] + x[2] - 1], lower=0, upper=1,
)  # fmt: skip
_add(
    "HS63", (2, 2, 2),
    lambda x, xp: 1000 - x[0] ** 2 - 2 * x[1] ** 2 - x[2] ** 2 - x[0] * x[1] - x[0] * x[2],
    961.7151721, lambda x, xp: [8 * x[0] + 14 * x[1] + 7 * x[2] - 56, squares(x) - 25], lower=0,
)  # fmt: skip
_add(
    "HS64", (1, 1, 1),
    lambda x, xp: (
        5 * x[0] + 50000 / x[0] + 20 * x[1] + 72000 / x[1] + 10 * x[2] + 144000 / x[2]
    ),
    6299.842428, g=lambda x, xp: [1 - 4 / x[0] - 32 / x[1] - 120 / x[2]], lower=1e-5,
)  # fmt: skip
_add(
    "HS65", (-5, 5, 0),
    lambda x, xp: (x[0] - x[1]) ** 2 + (x[0] + x[1] - 10) ** 2 / 9 + (x[2] - 5) ** 2, 0.9535288567,
    g=lambda x, xp: [48 - squares(x)], lower=(-4.5, -4.5, -5), upper=(4.5, 4.5, 5),
)  # fmt: skip
_add(
    "HS66", (0, 1.05, 2.9), lambda x, xp: 0.2 * x[2] - 0.8 * x[0], 0.5181632741,
    g=lambda x, xp: [x[1] - xp.exp(x[0]), x[2] - xp.exp(x[1])], lower=0, upper=(100, 100, 10),
)  # fmt: skip
_add(
    "HS71", (1, 5, 5, 1), lambda x, xp: x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2], 17.0140173,
    lambda x, xp: [squares(x) - 40], lambda x, xp: [product(x) - 25], lower=1, upper=5,
)  # fmt: skip
_add(
    "HS72", (1, 1, 1, 1), lambda x, xp: 1 + x[0] + x[1] + x[2] + x[3], 727.67937,
    g=lambda x, xp: [
        0.0401 - 4 / x[0] - 2.25 / x[1] - 1 / x[2] - 0.25 / x[3],
        0.010085 - 0.16 / x[0] - 0.36 / x[1] - 0.64 / x[2] - 0.64 / x[3],
    ],
    lower=0.001, upper=(4e5, 3e5, 2e5, 1e5),
)  # fmt: skip
_add(
    "HS73", (1, 1, 1, 1), lambda x, xp: 24.55 * x[0] + 26.75 * x[1] + 39 * x[2] + 40.5 * x[3],
    29.894378, lambda x, xp: [x[0] + x[1] + x[2] + x[3] - 1],
    lambda x, xp: [
        2.3 * x[0] + 5.6 * x[1] + 11.1 * x[2] + 1.3 * x[3] - 5,
        12 * x[0] + 11.9 * x[1] + 41.8 * x[2] + 52.1 * x[3] - 21
        - 1.645 * xp.sqrt(
            0.28 * x[0] ** 2 + 0.19 * x[1] ** 2 + 20.5 * x[2] ** 2 + 0.62 * x[3] ** 2
        ),
    ],
    lower=0,
)  # fmt: skip


def _hs74(x: Any, xp: Any) -> Any:
    return 3 * x[0] + 1e-6 * x[0] ** 3 + 2 * x[1] + 2e-6 / 3 * x[1] ** 3


def _hs74_rows(x: Any, xp: Any) -> Any:
    sin = xp.sin
    return [
        1000 * sin(-x[2] - 0.25) + 1000 * sin(-x[3] - 0.25) + 894.8 - x[0],
        1000 * sin(x[2] - 0.25) + 1000 * sin(x[2] - x[3] - 0.25) + 894.8 - x[1],
        1000 * sin(x[3] - 0.25) + 1000 * sin(x[3] - x[2] - 0.25) + 1294.8,
    ]


for _name, _angle, _value in (("HS74", 0.55, 5126.4981), ("HS75", 0.48, 5174.4129)):
    _add(
        _name, (0, 0, 0, 0), _hs74, _value, _hs74_rows,
        lambda x, xp, a=_angle: [x[3] - x[2] + a, x[2] - x[3] + a],
        lower=(0, 0, -_angle, -_angle), upper=(1200, 1200, _angle, _angle),
    )  # fmt: skip
_add(
    "HS76", (0.5,) * 4,
    lambda x, xp: (
        x[0] ** 2 + 0.5 * x[1] ** 2 + x[2] ** 2 + 0.5 * x[3] ** 2 - x[0] * x[2] + x[2] * x[3]
        - x[0] - 3 * x[1] + x[2] - x[3]
    ),
    -4.681818182,
    g=lambda x, xp: [
        5 - x[0] - 2 * x[1] - x[2] - x[3], 4 - 3 * x[0] - x[1] - 2 * x[2] + x[3],
        x[1] + 4 * x[2] - 1.5,
    ],
    lower=0,
)  # fmt: skip
_add(
    "HS77", (2,) * 5,
    lambda x, xp: (
        (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[2] - 1) ** 2 + (x[3] - 1) ** 4 + (x[4] - 1) ** 6
    ),
    0.24150513,
    lambda x, xp: [
        x[0] ** 2 * x[3] + xp.sin(x[3] - x[4]) - 2 * ROOT2,
        x[1] + x[2] ** 4 * x[3] ** 2 - 8 - ROOT2,
    ],
)  # fmt: skip


def _hs78_rows(x: Any, xp: Any) -> Any:
    return [squares(x) - 10, x[1] * x[2] - 5 * x[3] * x[4], x[0] ** 3 + x[1] ** 3 + 1]


_add("HS78", (-2, 1.5, 2, -1, -1), lambda x, xp: product(x), -2.91970041, _hs78_rows)
_add(
    "HS79", (2,) * 5,
    lambda x, xp: (
        (x[0] - 1) ** 2 + (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 2 + (x[2] - x[3]) ** 4
        + (x[3] - x[4]) ** 4
    ),
    0.0787768209,
    lambda x, xp: [
        x[0] + x[1] ** 2 + x[2] ** 3 - 2 - 3 * ROOT2,
        x[1] - x[2] ** 2 + x[3] + 2 - 2 * ROOT2, x[0] * x[4] - 2,
    ],
)  # fmt: skip
_BOX80 = (2.3, 2.3, 3.2, 3.2, 3.2)
_add(
    "HS80", (-2, 2, 2, -1, -1), lambda x, xp: xp.exp(product(x)), 0.0539498478, _hs78_rows,
    lower=tuple(-b for b in _BOX80), upper=_BOX80,
)  # fmt: skip
_add(
    "HS81", (-2, 2, 2, -1, -1),
    lambda x, xp: xp.exp(product(x)) - 0.5 * (x[0] ** 3 + x[1] ** 3 + 1) ** 2, 0.0539498478,
    _hs78_rows, lower=tuple(-b for b in _BOX80), upper=_BOX80,
)  # fmt: skip


def _hs83_rows(x: Any, xp: Any) -> Any:
    a = 85.334407 + 0.0056858 * x[1] * x[4] + 0.0006262 * x[0] * x[3] - 0.0022053 * x[2] * x[4]
    b = 80.51249 + 0.0071317 * x[1] * x[4] + 0.0029955 * x[0] * x[1] + 0.0021813 * x[2] ** 2
    c = 9.300961 + 0.0047026 * x[2] * x[4] + 0.0012547 * x[0] * x[2] + 0.0019085 * x[2] * x[3]
    return [a, 92 - a, b - 90, 110 - b, c - 20, 25 - c]


_add(
    "HS83", (78, 33, 27, 27, 27),
    lambda x, xp: (
        5.3578547 * x[2] ** 2 + 0.8356891 * x[0] * x[4] + 37.293239 * x[0] - 40792.141
    ),
    -30665.53867, g=_hs83_rows, lower=(78, 33, 27, 27, 27), upper=(102, 45, 45, 45, 45),
)  # fmt: skip

_COLVILLE_C = (
    (30, -20, -10, 32, -10), (-20, 39, -6, -31, 32), (-10, -6, 10, -6, -10),
    (32, -31, -6, 39, -20), (-10, 32, -10, -20, 30),
)  # fmt: skip
_COLVILLE_A = (
    (-16, 2, 0, 1, 0), (0, -2, 0, 4, 2), (-3.5, 0, 2, 0, 0), (0, -2, 0, -4, -1),
    (0, -9, -2, 1, -2.8), (2, 0, -4, 0, 0), (-1, -1, -1, -1, -1), (-1, -2, -3, -2, -1),
    (1, 2, 3, 4, 5), (1, 1, 1, 1, 1),
)  # fmt: skip
_COLVILLE_B = (-40, -2, -0.25, -4, -4, -1, -40, -60, 5, 1)


def _hs86(x: Any, xp: Any) -> Any:
    linear = -15 * x[0] - 27 * x[1] - 36 * x[2] - 18 * x[3] - 12 * x[4]
    quadratic = sum(_COLVILLE_C[i][j] * x[i] * x[j] for i in range(5) for j in range(5))
    cubic = 4 * x[0] ** 3 + 8 * x[1] ** 3 + 10 * x[2] ** 3 + 6 * x[3] ** 3 + 2 * x[4] ** 3
    return linear + quadratic + cubic


_add(
    "HS86", (0, 0, 0, 0, 1), _hs86, -32.34867897,
    g=lambda x, xp: [
        sum(a * y for a, y in zip(row, [x[i] for i in range(5)], strict=True)) - b
        for row, b in zip(_COLVILLE_A, _COLVILLE_B, strict=True)
    ],
    lower=0,
)  # fmt: skip


def _hs93_parts(x: Any) -> tuple[Any, Any]:
    return x[0] * x[3] * (x[0] + x[1] + x[2]), x[1] * x[2] * (x[0] + 1.57 * x[1] + x[3])


def _hs93(x: Any, xp: Any) -> Any:
    a, b = _hs93_parts(x)
    return 0.0204 * a + 0.0187 * b + 0.0607 * a * x[4] ** 2 + 0.0437 * b * x[5] ** 2


def _hs93_rows(x: Any, xp: Any) -> Any:
    a, b = _hs93_parts(x)
    return [
        0.001 * product([x[i] for i in range(6)]) - 2.07,
        1 - 0.00062 * a * x[4] ** 2 - 0.00058 * b * x[5] ** 2,
    ]


_add("HS93", (5.54, 4.4, 12.02, 11.82, 0.702, 0.852), _hs93, 135.075961, g=_hs93_rows, lower=0)
_add(
    "HS100", (1, 2, 0, 4, 0, 1, 1),
    lambda x, xp: (
        (x[0] - 10) ** 2 + 5 * (x[1] - 12) ** 2 + x[2] ** 4 + 3 * (x[3] - 11) ** 2
        + 10 * x[4] ** 6 + 7 * x[5] ** 2 + x[6] ** 4 - 4 * x[5] * x[6] - 10 * x[5] - 8 * x[6]
    ),
    680.6300573,
    g=lambda x, xp: [
        127 - 2 * x[0] ** 2 - 3 * x[1] ** 4 - x[2] - 4 * x[3] ** 2 - 5 * x[4],
        282 - 7 * x[0] - 3 * x[1] - 10 * x[2] ** 2 - x[3] + x[4],
        196 - 23 * x[0] - x[1] ** 2 - 6 * x[5] ** 2 + 8 * x[6],
        -4 * x[0] ** 2 - x[1] ** 2 + 3 * x[0] * x[1] - 2 * x[2] ** 2 - 5 * x[5] + 11 * x[6],
    ],
)  # fmt: skip


def _hs104(x: Any, xp: Any) -> Any:
    return (
        0.4 * x[0] ** 0.67 * x[6] ** -0.67 + 0.4 * x[1] ** 0.67 * x[7] ** -0.67 + 10 - x[0] - x[1]
    )


_add(
    "HS104", (6, 3, 0.4, 0.2, 6, 6, 1, 0.5), _hs104, 3.9511634396,
    g=lambda x, xp: [
        1 - 0.0588 * x[4] * x[6] - 0.1 * x[0],
        1 - 0.0588 * x[5] * x[7] - 0.1 * x[0] - 0.1 * x[1],
        1 - 4 * x[2] / x[4] - 2 * x[2] ** -0.71 / x[4] - 0.0588 * x[2] ** -1.3 * x[6],
        1 - 4 * x[3] / x[5] - 2 * x[3] ** -0.71 / x[5] - 0.0588 * x[3] ** -1.3 * x[7],
        _hs104(x, xp) - 0.1, 4.2 - _hs104(x, xp),
    ],
    lower=0.1, upper=10,
)  # fmt: skip
_add(
    "HS106", (5000, 5000, 5000, 200, 350, 150, 225, 425), lambda x, xp: x[0] + x[1] + x[2],
    7049.248021,
    g=lambda x, xp: [
        1 - 0.0025 * (x[3] + x[5]), 1 - 0.0025 * (x[4] + x[6] - x[3]), 1 - 0.01 * (x[7] - x[4]),
        x[0] * x[5] - 833.33252 * x[3] - 100 * x[0] + 83333.333,
        x[1] * x[6] - 1250 * x[4] - x[1] * x[3] + 1250 * x[3],
        x[2] * x[7] - 1250000 - x[2] * x[4] + 2500 * x[4],
    ],
    lower=(100, 1000, 1000, 10, 10, 10, 10, 10), upper=(1e4, 1e4, 1e4, 1e3, 1e3, 1e3, 1e3, 1e3),
)  # fmt: skip
_add(
    "HS110", (9,) * 10,
    lambda x, xp: (
        sum(xp.log(x[i] - 2) ** 2 + xp.log(10 - x[i]) ** 2 for i in range(10))
        - product([x[i] for i in range(10)]) ** 0.2
    ),
    -45.77846971, lower=2.001, upper=9.999,
)  # fmt: skip
_C112 = (
    -6.089, -17.164, -34.054, -5.914, -24.721, -14.986, -24.1, -10.708, -26.662, -22.179
)  # fmt: skip
_add(
    "HS112", (0.1,) * 10,
    lambda x, xp: sum(
        x[j] * (_C112[j] + xp.log(x[j] / sum(x[i] for i in range(10)))) for j in range(10)
    ),
    -47.76109026,
    lambda x, xp: [
        x[0] + 2 * x[1] + 2 * x[2] + x[5] + x[9] - 2, x[3] + 2 * x[4] + x[5] + x[6] - 1,
        x[2] + x[6] + x[7] + 2 * x[8] + x[9] - 1,
    ],
    lower=1e-6,
)  # fmt: skip
_add(
    "HS113", (2, 3, 5, 5, 1, 2, 7, 3, 6, 10),
    lambda x, xp: (
        x[0] ** 2 + x[1] ** 2 + x[0] * x[1] - 14 * x[0] - 16 * x[1] + (x[2] - 10) ** 2
        + 4 * (x[3] - 5) ** 2 + (x[4] - 3) ** 2 + 2 * (x[5] - 1) ** 2 + 5 * x[6] ** 2
        + 7 * (x[7] - 11) ** 2 + 2 * (x[8] - 10) ** 2 + (x[9] - 7) ** 2 + 45
    ),
    24.3062091,
    g=lambda x, xp: [
        105 - 4 * x[0] - 5 * x[1] + 3 * x[6] - 9 * x[7], -10 * x[0] + 8 * x[1] + 17 * x[6]
        - 2 * x[7], 8 * x[0] - 2 * x[1] - 5 * x[8] + 2 * x[9] + 12,
        -3 * (x[0] - 2) ** 2 - 4 * (x[1] - 3) ** 2 - 2 * x[2] ** 2 + 7 * x[3] + 120,
        -5 * x[0] ** 2 - 8 * x[1] - (x[2] - 6) ** 2 + 2 * x[3] + 40,
        -0.5 * (x[0] - 8) ** 2 - 2 * (x[1] - 4) ** 2 - 3 * x[4] ** 2 + x[5] + 30,
        -(x[0] ** 2) - 2 * (x[1] - 2) ** 2 + 2 * x[0] * x[1] - 14 * x[4] + 6 * x[5],
        3 * x[0] - 6 * x[1] - 12 * (x[8] - 8) ** 2 + 7 * x[9],
    ],
)  # fmt: skip

# --- unconstrained --------------------------------------------------------------------------

_add("Rosenbrock", (-1.2, 1), rosenbrock, 0.0, source="MGH 1")
_add(
    "Powell badly scaled", (0, 1),
    lambda x, xp: (
        (1e4 * x[0] * x[1] - 1) ** 2 + (xp.exp(-x[0]) + xp.exp(-x[1]) - 1.0001) ** 2
    ),
    0.0, source="MGH 3",
)  # fmt: skip
_add(
    "Brown badly scaled", (1, 1),
    lambda x, xp: (x[0] - 1e6) ** 2 + (x[1] - 2e-6) ** 2 + (x[0] * x[1] - 2) ** 2, 0.0,
    source="MGH 4",
)  # fmt: skip
_add(
    "Beale", (1, 1),
    lambda x, xp: sum(
        (y - x[0] * (1 - x[1] ** (i + 1))) ** 2 for i, y in enumerate((1.5, 2.25, 2.625))
    ),
    0.0, source="MGH 5",
)  # fmt: skip
_add(
    "Powell singular", (3, -1, 0, 1),
    lambda x, xp: (
        (x[0] + 10 * x[1]) ** 2 + 5 * (x[2] - x[3]) ** 2 + (x[1] - 2 * x[2]) ** 4
        + 10 * (x[0] - x[3]) ** 4
    ),
    0.0, source="MGH 13",
)  # fmt: skip
_add("Wood", (-3, -1, -3, -1), wood, 0.0, source="MGH 14")
_add(
    "Jennrich and Sampson", (0.3, 0.4),
    lambda x, xp: sum(
        (2 + 2 * i - xp.exp(i * x[0]) - xp.exp(i * x[1])) ** 2 for i in range(1, 11)
    ),
    124.362182, source="MGH 6",
)  # fmt: skip
_add("One variable", (4,), lambda x, xp: x[0] ** 4 - 3 * x[0] ** 3 + 2, -6.54296875, source="-")
_add("Saddle", (0, 0), lambda x, xp: x[0] ** 2 - x[1] ** 2 + 0.25 * x[1] ** 4, -1.0, source="-")

# --- complementarity ------------------------------------------------------------------------

_add(
    "kth1", (1, 1), lambda x, xp: x[0] + x[1], 0.0, g=lambda x, xp: [-x[0] * x[1]], lower=0,
    source="MacMPEC", qualified=True,
)  # fmt: skip
_add(
    "kth2", (1, 2), lambda x, xp: x[0] + (x[1] - 1) ** 2, 0.0, g=lambda x, xp: [-x[0] * x[1]],
    lower=0, source="MacMPEC",
)  # fmt: skip
_add(
    "kth3", (1, 2), lambda x, xp: 0.5 * (x[0] - 1) ** 2 + (x[1] - 1) ** 2, 0.5,
    g=lambda x, xp: [-x[0] * x[1]], lower=0, source="MacMPEC",
)  # fmt: skip
_add(
    "scholtes3", (1, 1), lambda x, xp: 0.5 * ((x[0] - 1) ** 2 + (x[1] - 1) ** 2), 0.5,
    g=lambda x, xp: [-x[0] * x[1]], lower=0, source="MacMPEC",
)  # fmt: skip
_add(
    "ralph1", (1, 1), lambda x, xp: 2 * x[0] - x[1], 0.0,
    g=lambda x, xp: [x[1] - x[0], -x[1] * (x[1] - x[0])], lower=0, source="MacMPEC",
    qualified=False,
)  # fmt: skip
_add(
    "ralph2", (1, 1), lambda x, xp: x[0] ** 2 + x[1] ** 2 - 4 * x[0] * x[1], 0.0,
    g=lambda x, xp: [-x[0] * x[1]], lower=0, source="MacMPEC",
)  # fmt: skip
_add(
    "bard1", (0, 0, 0, 0, 0), lambda x, xp: (x[0] - 5) ** 2 + (2 * x[1] + 1) ** 2, 17.0,
    lambda x, xp: [2 * (x[1] - 1) - 1.5 * x[0] + x[2] - 0.5 * x[3] + x[4]],
    lambda x, xp: [
        3 * x[0] - x[1] - 3, -x[0] + 0.5 * x[1] + 4, -x[0] - x[1] + 7,
        -x[2] * (3 * x[0] - x[1] - 3), -x[3] * (-x[0] + 0.5 * x[1] + 4),
        -x[4] * (-x[0] - x[1] + 7),
    ],
    lower=0, source="MacMPEC",
)  # fmt: skip
_add(
    "stackelberg1", (100, 20, 0), lambda x, xp: 0.5 * x[0] ** 2 + 0.5 * x[0] * x[1] - 95 * x[0],
    -3266.666667, lambda x, xp: [2 * x[1] + 0.5 * x[0] - 100 - x[2]],
    lambda x, xp: [-x[1] * x[2]], lower=0, upper=(200, INF, INF), source="MacMPEC",
)  # fmt: skip
_add(
    "gauvin", (7, 7, 7), lambda x, xp: x[0] ** 2 + (x[1] - 10) ** 2, 20.0,
    lambda x, xp: [4 * (x[0] + 2 * x[1] - 30) + x[2]],
    lambda x, xp: [20 - x[0] - x[1], -x[2] * (20 - x[0] - x[1])], lower=0, upper=(15, INF, INF),
    source="MacMPEC",
)  # fmt: skip

# --- degenerate -----------------------------------------------------------------------------

_add(
    "No multiplier", (1,), lambda x, xp: x[0], 0.0, g=lambda x, xp: [-(x[0] ** 2)], source="-",
    qualified=False,
)  # fmt: skip
_add(
    "No multiplier, equality", (1,), lambda x, xp: x[0], 0.0, lambda x, xp: [x[0] ** 2],
    source="-", qualified=False,
)  # fmt: skip
_add(
    "Touching circles", (0.5, 1), lambda x, xp: x[0] + x[1], 0.0,
    lambda x, xp: [(x[0] - 1) ** 2 + x[1] ** 2 - 1, (x[0] + 1) ** 2 + x[1] ** 2 - 1],
    source="-", qualified=False,
)  # fmt: skip
_add(
    "Cusp", (1, 1), lambda x, xp: x[0], 0.0, lambda x, xp: [x[0] ** 3 - x[1] ** 2], source="-",
    qualified=False,
)  # fmt: skip
_add(
    "Repeated equality", (3, -1), lambda x, xp: x[0] ** 2 + 2 * x[1] ** 2, 2 / 3,
    lambda x, xp: [x[0] + x[1] - 1, 2 * x[0] + 2 * x[1] - 2, x[0] + x[1] - 1], source="-",
)  # fmt: skip
_add(
    "More rows than variables", (2, 2), lambda x, xp: x[0] + x[1], 2.0,
    lambda x, xp: [x[0] - 1, x[1] - 1, x[0] * x[1] - 1, x[0] ** 2 - x[1]], source="-",
)  # fmt: skip
_add(
    "WB", (-2, 3, 1), lambda x, xp: x[0], 1.0,
    lambda x, xp: [x[0] ** 2 - x[1] - 1, x[0] - x[2] - 0.5], lower=(-INF, 0, 0),
)  # fmt: skip
_add(
    "Start without slope", (0, 0), lambda x, xp: (x[0] - 2) ** 2 + x[1] ** 2, 1.0,
    lambda x, xp: [squares(x) - 1], source="-",
)  # fmt: skip
_add(
    "Held variable", (0, 5, 9), lambda x, xp: squares(x) + x[0] * x[1], 3.125,
    g=lambda x, xp: [x[0] + x[1] + x[2] - 1.5], lower=(-INF, 2, -INF), upper=(INF, 2, INF),
    source="-",
)  # fmt: skip
_add(
    "Entropy", (0, 0, 0), lambda x, xp: sum(x[i] * xp.log(x[i]) for i in range(3)), -math.log(3),
    lambda x, xp: [x[0] + x[1] + x[2] - 1], lower=0, source="-",
)  # fmt: skip
_add(
    "Logarithm outside", (-3, -3), lambda x, xp: x[0] - xp.log(x[0]) + (x[1] - 2) ** 2, 1.0,
    lower=(0, -INF), source="-",
)  # fmt: skip
_add(
    "Square root at its end", (0, 2), lambda x, xp: x[1] - 2 * xp.sqrt(x[0]) + x[0], -1.0,
    lower=0, source="-",
)  # fmt: skip

# --- linear ---------------------------------------------------------------------------------

_add(
    "Beale's cycling LP", (0, 0, 0, 0),
    lambda x, xp: -0.75 * x[0] + 150 * x[1] - 0.02 * x[2] + 6 * x[3], -0.05,
    g=lambda x, xp: [
        -0.25 * x[0] + 60 * x[1] + 0.04 * x[2] - 9 * x[3],
        -0.5 * x[0] + 90 * x[1] + 0.02 * x[2] - 3 * x[3], 1 - x[2],
    ],
    lower=0,
)  # fmt: skip
_add(
    "Klee and Minty", (0, 0, 0), lambda x, xp: -100 * x[0] - 10 * x[1] - x[2], -1e4,
    g=lambda x, xp: [1 - x[0], 100 - 20 * x[0] - x[1], 1e4 - 200 * x[0] - 20 * x[1] - x[2]],
    lower=0,
)  # fmt: skip
_add(
    "Transport", (0,) * 4, lambda x, xp: 2 * x[0] + 3 * x[1] + 4 * x[2] + x[3], 50.0,
    lambda x, xp: [
        x[0] + x[1] - 20, x[2] + x[3] - 10, x[0] + x[2] - 20, x[1] + x[3] - 10,
    ],
    lower=0, source="-",
)  # fmt: skip

# --- without an answer ----------------------------------------------------------------------

_add("No root", (2,), lambda x, xp: x[0], None, lambda x, xp: [x[0] ** 2 + 1], source="-",
     answer="infeasible")  # fmt: skip
_add(
    "Parallel lines", (0, 0), lambda x, xp: squares(x), None,
    lambda x, xp: [x[0] + x[1] - 1, x[0] + x[1] - 2], source="-", answer="infeasible",
)  # fmt: skip
_add(
    "Disc and half plane", (0, 0), lambda x, xp: x[1], None,
    g=lambda x, xp: [1 - squares(x), x[0] - 3], source="-", answer="infeasible",
)  # fmt: skip
_add(
    "isolated", (3, 2), lambda x, xp: x[0] + x[1], None,
    g=lambda x, xp: [
        -(x[0] ** 2) + x[1] - 1, -(x[0] ** 2) - x[1] - 1, x[0] - x[1] ** 2 - 1,
        -x[0] - x[1] ** 2 - 1,
    ],
    source="BCN", answer="infeasible",
)  # fmt: skip
_add(
    "nactive", (-20, 10), lambda x, xp: x[0], None,
    g=lambda x, xp: [0.5 * (-x[0] - x[1] ** 2 - 1), x[0] - x[1] ** 2, -x[0] + x[1] ** 2],
    source="BCN", answer="infeasible",
)  # fmt: skip
_add(
    "unique", (3, 2), lambda x, xp: x[0] + x[1], None,
    g=lambda x, xp: [x[1] - x[0] ** 2 - 1, 0.3 * (1 - xp.exp(x[1]))], source="BCN",
    answer="infeasible",
)  # fmt: skip
_add(
    "Out of the box", (0, 0), lambda x, xp: x[0], None, lambda x, xp: [x[0] + x[1] - 5],
    lower=-1, upper=1, source="-", answer="infeasible",
)  # fmt: skip
_add("Falling line", (0, 0), lambda x, xp: -x[0] + x[1] ** 2, None, source="-",
     answer="unbounded")  # fmt: skip
_add(
    "Falling along a parabola", (1, 1), lambda x, xp: -x[0], None,
    lambda x, xp: [x[1] - x[0] ** 2], source="-", answer="unbounded",
)  # fmt: skip
_add(
    "Unbounded LP", (0, 0), lambda x, xp: -x[0] - x[1], None,
    g=lambda x, xp: [1 - x[0] + x[1], 2 + x[0] - x[1]], lower=0, source="-", answer="unbounded",
)  # fmt: skip
_add("Cubic", (-1, 0), lambda x, xp: x[0] ** 3 + x[1] ** 2, None, source="-", answer="unbounded")
_add(
    "Concave", (0.0, 0.0), lambda x, xp: -squares(x), None, g=lambda x, xp: [x[0] - x[1]],
    source="-", answer="unbounded",
)  # fmt: skip

# --- written when the solver was finished, and tuned on by nobody ----------------------------

_TUNED = len(PROGRAMS)
_add(
    "Freudenstein and Roth", (0.5, -2),
    lambda x, xp: (
        (-13 + x[0] + ((5 - x[1]) * x[1] - 2) * x[1]) ** 2
        + (-29 + x[0] + ((x[1] + 1) * x[1] - 14) * x[1]) ** 2
    ),
    0.0, source="MGH 2",
)  # fmt: skip
_BARD = (0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.1, 4.39)
_add(
    "Bard", (1, 1, 1),
    lambda x, xp: xp.sum(
        (xp.array(_BARD) - x[0] - xp.array([*range(1, 16)]) / (
            xp.array([*range(15, 0, -1)]) * x[1]
            + xp.array([min(i, 16 - i) for i in range(1, 16)]) * x[2]
        )) ** 2
    ),
    8.21487e-3, source="MGH 8",
)  # fmt: skip
_MEYER = (
    34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147, 4427, 3820,
    3307, 2872,
)  # fmt: skip
_add(
    "Meyer", (0.02, 4000, 250),
    lambda x, xp: xp.sum(
        (x[0] * xp.exp(x[1] / (xp.array([*range(50, 130, 5)]) + x[2])) - xp.array(_MEYER)) ** 2
    ),
    87.9458, source="MGH 10",
)  # fmt: skip
_TENTHS = [0.1 * i for i in range(1, 11)]
_add(
    "Box", (0, 10, 20),
    lambda x, xp: xp.sum(
        (xp.exp(-xp.array(_TENTHS) * x[0]) - xp.exp(-xp.array(_TENTHS) * x[1])
         - xp.array([math.exp(-t) - math.exp(-10 * t) for t in _TENTHS]) * x[2]) ** 2
    ),
    0.0, source="MGH 12",
)  # fmt: skip
_FIFTHS = [i / 5 for i in range(1, 21)]
_add(
    "Brown and Dennis", (25, 5, -5, -1),
    lambda x, xp: xp.sum(
        ((x[0] + xp.array(_FIFTHS) * x[1] - xp.array([math.exp(t) for t in _FIFTHS])) ** 2
         + (x[2] + xp.array([math.sin(t) for t in _FIFTHS]) * x[3]
            - xp.array([math.cos(t) for t in _FIFTHS])) ** 2) ** 2
    ),
    85822.2, source="MGH 16",
)  # fmt: skip
_add(
    "HS47", (2, ROOT2, -1, 2 - ROOT2, 0.5),
    lambda x, xp: (
        (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 3 + (x[2] - x[3]) ** 4 + (x[3] - x[4]) ** 4
    ),
    0.0,
    lambda x, xp: [
        x[0] + x[1] ** 2 + x[2] ** 3 - 3, x[1] - x[2] ** 2 + x[3] - 1, x[0] * x[4] - 1,
    ],
)  # fmt: skip
_add(
    "HS95", (0,) * 6,
    lambda x, xp: (
        4.3 * x[0] + 31.8 * x[1] + 63.3 * x[2] + 15.8 * x[3] + 68.5 * x[4] + 4.7 * x[5]
    ),
    0.015619514,
    g=lambda x, xp: [
        17.1 * x[0] + 38.2 * x[1] + 204.2 * x[2] + 212.3 * x[3] + 623.4 * x[4] + 1495.5 * x[5]
        - 169 * x[0] * x[2] - 3580 * x[2] * x[4] - 3810 * x[3] * x[4] - 18500 * x[3] * x[5]
        - 24300 * x[4] * x[5] - 4.97,
        17.9 * x[0] + 36.8 * x[1] + 113.9 * x[2] + 169.7 * x[3] + 337.8 * x[4] + 1385.2 * x[5]
        - 139 * x[0] * x[2] - 2450 * x[3] * x[4] - 16600 * x[3] * x[5] - 17200 * x[4] * x[5]
        + 1.88,
        -273 * x[1] - 70 * x[3] - 819 * x[4] + 26000 * x[3] * x[4] + 29.08,
        159.9 * x[0] - 311 * x[1] + 587 * x[3] + 391 * x[4] + 2198 * x[5]
        - 14000 * x[0] * x[5] + 78.02,
    ],
    lower=0, upper=(0.31, 0.046, 0.068, 0.042, 0.028, 0.0134),
)  # fmt: skip
_add(
    "S254", (1, 1, 1), lambda x, xp: xp.log(x[2]) / math.log(10) - x[1], -ROOT3,
    lambda x, xp: [x[1] ** 2 + x[2] ** 2 - 4, x[2] - 1 - x[0] ** 2], lower=(-INF, -INF, 1),
)  # fmt: skip
_add(
    "S263", (10, 10, 10, 10), lambda x, xp: -x[0], -1.0,
    lambda x, xp: [x[1] - x[0] ** 3 - x[2] ** 2, x[0] ** 2 - x[1] - x[3] ** 2],
    lambda x, xp: [x[1] - x[0] ** 3, x[0] ** 2 - x[1]],
)  # fmt: skip
_add(
    "S336", (0, 0, 0), lambda x, xp: 7 * x[0] - 6 * x[1] + 4 * x[2], -0.337896,
    lambda x, xp: [
        x[0] ** 2 + 2 * x[1] ** 2 + 3 * x[2] ** 2 - 1, 5 * x[0] + 5 * x[1] - 3 * x[2] - 6,
    ],
)  # fmt: skip
_add(
    "S338", (0, 0, 0), lambda x, xp: -squares(x), -10.992806,
    lambda x, xp: [
        0.5 * x[0] + x[1] + x[2] - 1, x[0] ** 2 + 2 / 3 * x[1] ** 2 + 0.25 * x[2] ** 2 - 4,
    ],
)  # fmt: skip
_add(
    "S340", (1, 1, 1), lambda x, xp: -product(x), -0.054,
    g=lambda x, xp: [1.8 - x[0] - 2 * x[1] - 2 * x[2]], lower=0, upper=(1, INF, INF),
)  # fmt: skip
_add(
    "scholtes4", (1, 1, 1), lambda x, xp: x[0] + x[1] - x[2], 0.0,
    g=lambda x, xp: [4 * x[0] - x[2], 4 * x[1] - x[2], -x[0] * x[1]], lower=(0, 0, -INF),
    source="MacMPEC", qualified=False,
)  # fmt: skip
_add(
    "Many at one corner", (-1, 2), lambda x, xp: -x[0] - x[1], -2.0,
    g=lambda x, xp: [2 - squares(x), 2 - x[0] - x[1], 6 - 3 * x[0] - 3 * x[1], 1 - x[0] * x[1]],
    source="-",
)  # fmt: skip
_ROOT = (6 + math.sqrt(44)) / 4
_add(
    "Logarithm from the wrong side", (-1,), lambda x, xp: (x[0] - 3) ** 2 - xp.log(x[0]),
    (_ROOT - 3) ** 2 - math.log(_ROOT), source="-",
)  # fmt: skip
_add(
    "Complementary corner", (0.5, 0.5), lambda x, xp: (x[0] - 1) ** 2 + (x[1] + 1) ** 2, 1.0,
    lambda x, xp: [x[0] * x[1], x[0] ** 2 - x[0]], lower=0, source="-",
)  # fmt: skip
_add(
    "Line beside a circle", (0, 0), lambda x, xp: x[0] - x[1], None,
    lambda x, xp: [squares(x) - 1, x[0] + x[1] - 3], source="-", answer="infeasible",
)  # fmt: skip
_add("Sine of two", (0.3,), lambda x, xp: x[0] ** 2, None, lambda x, xp: [xp.sin(x[0]) - 2],
     source="-", answer="infeasible")  # fmt: skip
_add(
    "Hyperbola", (1, -1), lambda x, xp: x[0] * x[1], None, lambda x, xp: [x[0] + x[1]],
    source="-", answer="unbounded",
)  # fmt: skip

HELD_OUT = PROGRAMS[_TUNED:]
del PROGRAMS[_TUNED:]

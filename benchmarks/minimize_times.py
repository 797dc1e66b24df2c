"""Time that `jaxatt.minimize` takes for a new problem, and for the next start of it.

    python -m benchmarks.minimize_times [--rows 500 2000 10000] [--only NAME ...]
                                       [--loop auto|host|compiled]

Small problems first, then few variables under many constraints: semi-infinite programmes on a grid
(Coope & Watson 1985, problem 1: 0.1944660; the smallest disc around points), minima of maxima
(approximation of exp by a cubic and by a quotient), and linear programmes without and with
degeneracy, against SciPy's HiGHS.  Seconds are those of the processor, of a process in which
JAX has run something before; no programs are kept between problems.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import scipy.optimize as so

import jaxatt

_NEXT = 5


@dataclass(frozen=True)
class Case:
    """One problem; optimum : None where only the conditions tell."""

    name: str
    objective: Callable[..., Any]
    x0: list[float]
    optimum: float | None
    args: tuple[Any, ...] = ()
    options: dict[str, Any] = field(default_factory=dict)

    def solve(self, away: float, loop: str) -> Any:
        """From x0, moved by `away`."""
        begin = np.array(self.x0) + away
        return jaxatt.minimize(self.objective, begin, self.args, loop=loop, **self.options)


def small() -> Iterator[Case]:
    """Problems of two to four variables."""
    yield Case("Rosenbrock", lambda x: 100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2,
               [-1.2, 1.0], 0.0)  # fmt: skip
    disc = {"equality": lambda x: x @ x - 1.0, "inequality": lambda x: x[0]}
    yield Case("nearest of a circle", lambda x: (x[0] - 2.0) ** 2 + (x[1] - 1.0) ** 2,
               [0.3, -0.4], (5.0**0.5 - 1.0) ** 2, options=disc)  # fmt: skip
    bounds = {"equality": lambda x: x @ x - 40.0, "inequality": lambda x: jnp.prod(x) - 25.0}
    yield Case("HS71", lambda x: x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
               [1.0, 5.0, 5.0, 1.0], 17.0140173,
               options={**bounds, "lower": 1.0, "upper": 5.0})  # fmt: skip


def many(q: int) -> Iterator[Case]:
    """Two to five variables under about q constraints."""
    grid = jnp.linspace(0.0, 1.0, q)

    def coope_watson(x: Any, s: Any) -> Any:
        return x[0] * s**2 + x[1] ** 2 - x[1] - (1.0 - (x[0] * s) ** 2) ** 2

    yield Case("semi-infinite", lambda x, s: x[0] ** 2 / 3 + x[1] ** 2 + x[0] / 2, [-1.0, -1.0],
               0.1944660, (grid,), {"inequality": coope_watson})  # fmt: skip
    rng = np.random.default_rng(0)
    points = rng.normal(size=(q, 2))

    def covered(x: Any, p: Any) -> Any:
        return x[2] ** 2 - (x[0] - p[:, 0]) ** 2 - (x[1] - p[:, 1]) ** 2

    yield Case("smallest disc", lambda x, p: x[2], [0.0, 0.0, 1.0], _disc(points), (points,),
               {"inequality": covered, "lower": np.array([-np.inf, -np.inf, 0.0])})  # fmt: skip
    u = np.linspace(-1.0, 1.0, q // 2)

    def between(error: Any, most: Any) -> Any:
        return jnp.concatenate([most - error, most + error])

    def cubic(x: Any, u: Any) -> Any:
        return between(x[0] + u * (x[1] + u * (x[2] + u * x[3])) - jnp.exp(u), x[4])

    powers = np.vander(u, 4, increasing=True)
    rows = np.block([[powers, -np.ones((len(u), 1))], [-powers, -np.ones((len(u), 1))]])
    yield Case("exp by a cubic", lambda x, u: x[4], [0.0, 0.0, 0.0, 0.0, 1.0],
               _linear([0.0, 0.0, 0.0, 0.0, 1.0], -rows, np.r_[-np.exp(u), np.exp(u)]), (u,),
               {"inequality": cubic})  # fmt: skip

    def quotient(x: Any, u: Any) -> Any:
        return between((x[0] + u * x[1]) / (1.0 + u * x[2]) - jnp.exp(u), x[3])

    yield Case("exp by a quotient", lambda x, u: x[3], [1.0, 0.5, -0.2, 1.0], None, (u,),
               {"inequality": quotient})  # fmt: skip
    a = rng.normal(size=(q, 3))
    a = a / np.linalg.norm(a, axis=1)[:, None]
    above = np.where(a.sum(axis=1)[:, None] < 0, -a, a)
    twice, ones = np.repeat(a[: q // 2], 2, axis=0), np.ones(3)
    cases = {
        "linear": (a, -np.ones(q)),
        "all through a vertex": (above, above @ np.array([1.0, 2.0, 3.0])),
        "every row twice": (twice, -np.ones(len(twice))),
    }
    for name, (matrix, least) in cases.items():
        yield Case(name, lambda x, a, b: jnp.sum(x), [0.0, 0.0, 0.0],
                   _linear(ones, matrix, least), (matrix, least),
                   {"inequality": lambda x, a, b: a @ x - b})  # fmt: skip


def _linear(cost: Any, matrix: Any, least: Any) -> float:
    """Least cost'x with matrix x >= least, by HiGHS."""
    return float(so.linprog(cost, A_ub=-matrix, b_ub=-least, bounds=(None, None)).fun)


def _disc(points: Any) -> float:
    """Radius of the smallest disc around the points, a convex programme."""
    squares = (points**2).sum(axis=1)
    rows = {"type": "ineq", "fun": lambda y: y[2] + 2.0 * points @ y[:2] - squares}
    best = so.minimize(lambda y: y[2] + y[:2] @ y[:2], [0.0, 0.0, squares.max()],
                       constraints=[rows], method="SLSQP", tol=1e-14)  # fmt: skip
    return float(np.sqrt(best.fun))


def measure(case: Case, loop: str) -> str:
    """One line of the table."""
    began = time.process_time()
    found = case.solve(0.0, loop)
    first = time.process_time() - began
    count, began = 0, time.process_time()
    while count < _NEXT and time.process_time() - began < 10.0:
        count += 1
        case.solve(1e-2 * count, loop)
    following = (time.process_time() - began) / count
    off = "" if case.optimum is None else f"{found.objective - case.optimum:10.1e}"
    return (f"{case.name:22s} {first:8.2f} {1e3 * following:10.1f}  {found.status.name:12s} "
            f"{found.objective:13.7g} {off:>10s} {found.iterations:6d}")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rows", type=int, nargs="*", default=[500, 2000, 10_000])
    parser.add_argument("--loop", default="auto")
    parser.add_argument("--only", nargs="+", default=[])
    chosen = parser.parse_args()
    jaxatt.configure()
    warm = Case("warm", lambda x: x @ x, [1.0, 2.0, 3.0], 0.0)
    warm.solve(0.0, chosen.loop)
    jax.config.update("jax_enable_compilation_cache", False)
    print(f"{'':22s} {'new, s':>8s} {'next, ms':>10s}  {'status':12s} {'objective':>13s} "
          f"{'beyond':>10s} {'passes':>6s}")  # fmt: skip
    groups = [("small", small()), *((f"{q} constraints", many(q)) for q in chosen.rows)]
    for title, cases in groups:
        print(title)
        for case in cases:
            if not chosen.only or case.name in chosen.only:
                print(measure(case, chosen.loop), flush=True)


if __name__ == "__main__":
    main()

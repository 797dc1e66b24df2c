"""Cost of applying no torque at all, where the printed cost may prefer it."""

from __future__ import annotations

import math

from jaxatt.problems.answer import Answer


def do_nothing_cost(result: Answer) -> float | None:
    """Printed cost of applying no torque at all, where it is known."""
    known = result.extra.get("do_nothing_cost")
    if known is not None:
        return float(known)
    resting = not any(phase.active.any() for phase in result.phases)
    return sum(phase.total_cost for phase in result.phases) if resting else None


def do_nothing_sentence(result: Answer) -> str:
    """Sentence for cases whose printed cost is lowest at rest, or tumbling, off the target."""
    cost = do_nothing_cost(result)
    if result.scenario.objective.terminal != "penalty" or cost is None:
        return ""
    others = [phase.alternative for phase in result.phases if phase.alternative is not None]
    against = ""
    if len(others) == len(result.phases):
        total = sum(other.total_cost for other in others)
        against = f" against {total:.4g} for the best start that reaches"
    if not any(phase.active.any() for phase in result.phases):
        return f"The printed objective prefers not moving: J = {cost:.4g}{against}."
    turned = [phase for phase in result.phases if not phase.reached and "rate" in phase.errors]
    if not turned:
        return ""
    worst = max(turned, key=lambda phase: phase.errors["attitude"])
    return (
        "The printed objective prefers tumbling to braking: "
        f"J = {sum(phase.total_cost for phase in result.phases):.4g} ends "
        f"{math.degrees(worst.errors['attitude']):.3g} deg off at "
        f"{math.degrees(worst.errors['rate']):.3g} deg/s{against}; "
        f"not moving costs {cost:.4g}."
    )

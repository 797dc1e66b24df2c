"""Rows of the table of a manoeuvre that earns energy."""

from __future__ import annotations

from jaxatt.problems.answer import Answer
from jaxatt.problems.net_power.record import net_power
from jaxatt.problems.sections import Block, Row, Rows
from jaxatt.records.wording import objective_title, short


def title(answer: Answer) -> str:
    """Text of what is earned, and of how the target enters."""
    objective, options = answer.scenario.objective, answer.scenario.options
    weight = options.weights.time
    timed = f", k3 = {weight:g} W/s" if weight else ""
    return f"{objective_title(objective.kind)}, {objective.terminal}{timed}"


def rows(answer: Answer) -> Rows:
    """Rows of the energies, of the baseline and of the shadow."""
    unit = "W" if answer.scenario.options.cost == "mean-power" else "J"
    free = net_power(answer.phases[0]).final_time_free
    time: list[Row] = [("final time [s]", lambda b: short(b["final_time_s"], 7))] if free else []
    found: list[Row] = [
        *time,
        ("net energy [J]", lambda b: short(b["energy"]["net_J"], 7)),
        ("  solar", lambda b: short(b["energy"]["solar_J"], 7)),
        ("  actuation", lambda b: short(b["energy"]["actuation_J"], 5)),
        ("  loads", lambda b: short(b["energy"]["loads_J"], 7)),
        ("mean power [W]", lambda b: short(b["energy"]["mean_power_W"], 5)),
        (f"cost [{unit}]", _cost),
        ("baseline, PD law [J]", _baseline),
        ("charge of the battery", _charge),
        ("dipole at its limit [% of the time]", _saturated),
        ("shadow [s]", _shadow),
        ("optimality", _optimality),
    ]
    return Rows(answer=found)


def _cost(block: Block) -> str:
    found = block["net_power"]
    return "" if found is None or found["cost"] is None else short(found["cost"], 7)


def _baseline(block: Block) -> str:
    energy = block["energy"]
    if energy["baseline_J"] is None:
        return ""
    share = energy["gain_percent"]
    told = "" if share is None else f", {share:+.3g} %"
    return f"{short(energy['baseline_J'], 7)} (gain {energy['gain_J']:+.5g} J{told})"


def _charge(block: Block) -> str:
    energy = block["energy"]
    if energy["final_charge_J"] is None:
        return ""
    hours = 1.0 / 3600.0
    return (
        f"{energy['final_charge_J'] * hours:.4g} Wh at the end, least "
        f"{energy['least_charge_J'] * hours:.4g} Wh"
    )


def _saturated(block: Block) -> str:
    found = block["net_power"]
    share = None if found is None else found["dipole_saturated_percent"]
    return "" if share is None else f"{share:.3g}"


def _shadow(block: Block) -> str:
    found = block["net_power"]
    if found is None:
        return ""

    def told(time: float | None, otherwise: str) -> str:
        return otherwise if time is None else f"{time:.1f}"

    return "; ".join(
        f"umbra {told(passage['umbra_entry'], 'before')} to {told(passage['umbra_exit'], 'after')}"
        for passage in found["shadow_s"]
    )


def _optimality(block: Block) -> str:
    kkt, found = block["kkt"], block["net_power"]
    if found is None or kkt["violation"] is None:
        return ""
    minima = "1 minimum" if found["minima"] == 1 else f"{found['minima']} minima"
    starts = block["starts"]["requested"]
    few = f"{found['refined_starts']} of {starts} solved on the shortest intervals, "
    return (
        f"violation {short(kkt['violation'], 2)}, stationarity {short(kkt['stationarity'], 2)}; "
        f"{few if found['refined_starts'] < starts else ''}"
        f"{100.0 * found['share_at_best']:.3g} % of the starts at the best of {minima}"
    )

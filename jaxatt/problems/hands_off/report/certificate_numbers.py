"""A certificate as plain numbers and as labelled arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jaxatt.problems.hands_off.certificate import CertificateRecord, PhaseCertificate
from jaxatt.problems.hands_off.report.certificate_words import LARGE, sentences

if TYPE_CHECKING:
    import xarray


def to_dict(certificate: CertificateRecord) -> dict[str, Any]:
    """Plain numbers, ready for JSON."""
    result = certificate.result
    return {
        "scenario": result.scenario.name,
        "objective": result.scenario.objective.kind,
        "minimal": certificate.minimal,
        "sentences": sentences(certificate),
        "legs": [_phase_numbers(phase) for phase in certificate.phases],
        "seed": result.seed,
        "device": result.device,
        "versions": dict(result.versions),
    }


def _phase_numbers(phase: PhaseCertificate) -> dict[str, Any]:
    return {
        "active_intervals": phase.found.active_intervals,
        "active_interval_indices": np.flatnonzero(phase.found.active).tolist(),
        "weighted_cost": phase.found_cost,
        "l1_effort_Nms": phase.found.l1_effort,
        "minimal": phase.minimal,
        "classes": [
            {
                "active": record.kind.size,
                "cost": record.kind.cost,
                "supports": record.kind.number if record.kind.number < LARGE else None,
                "tried": record.tried,
                "reach_short_way": None
                if record.short is None
                else int(record.short.reached.sum()),
                "reach_long_way": None if record.long is None else int(record.long.reached.sum()),
                "time_s": record.seconds,
            }
            for record in (*phase.cheaper, *phase.equal)
        ],
        "best_support": None if phase.best is None else phase.best[:, 0].tolist(),
        "best_l1_effort_Nms": phase.best_effort,
        "best_long_way": phase.best_long,
    }


def to_dataset(certificate: CertificateRecord) -> xarray.Dataset:
    """Return every support that was tried, both ways round, as a Dataset.

    Dimensions "support" and "slot"; `interval` and `group` are -1 in slots that a support does not
    use.
    """
    import xarray

    rows: dict[str, list[Any]] = {name: [] for name in ("leg", "cost", "way", "reached")}
    effort, residual, groups = [], [], []
    for number, phase in enumerate(certificate.phases):
        for record in (*phase.cheaper, *phase.equal):
            for way, found in ((1, record.short), (-1, record.long)):
                if found is None:
                    continue
                count = len(found.reached)
                rows["leg"] += [number] * count
                rows["cost"] += [record.kind.cost] * count
                rows["way"] += [way] * count
                rows["reached"] += found.reached.tolist()
                effort.append(found.effort)
                residual.append(found.residual)
                groups += list(found.groups)
    slots = max((len(entry) for entry in groups), default=0)
    filled = np.full((len(groups), slots, 2), -1)
    for index, entry in enumerate(groups):
        filled[index, : len(entry)] = entry
    empty = np.zeros(0)
    return xarray.Dataset(
        {
            "interval": (("support", "slot"), filled[..., 0]),
            "group": (("support", "slot"), filled[..., 1]),
            "leg": ("support", np.asarray(rows["leg"], int)),
            "weighted_cost": ("support", np.asarray(rows["cost"], float)),
            "way_round": ("support", np.asarray(rows["way"], int), {"values": "1 short, -1 long"}),
            "reached": ("support", np.asarray(rows["reached"], bool)),
            "l1_effort": ("support", np.concatenate([empty, *effort]), {"units": "N m s"}),
            "residual": ("support", np.concatenate([empty, *residual]), {"units": "rad"}),
        },
        attrs={
            "scenario": certificate.result.scenario.name,
            "text": " ".join(sentences(certificate)),
        },
    )

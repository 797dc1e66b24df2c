"""Sentences on what a certificate shows and what was only tried."""

from __future__ import annotations

from jaxatt.problems.hands_off.certificate import CertificateRecord, PhaseCertificate
from jaxatt.records.wording import indices_text, plural, short

LARGE = 1e15
"""Numbers of supports from which on digits say nothing."""


def sentences(certificate: CertificateRecord) -> list[str]:
    """Sentences on what was shown, what was only tried, and what is out of reach."""
    several = len(certificate.phases) > 1
    found = []
    for number, phase in enumerate(certificate.phases, start=1):
        where = f"Leg {number}: " if several else ""
        found += [where + sentence for sentence in _phase_sentences(phase)]
    return found


def _phase_sentences(phase: PhaseCertificate) -> list[str]:
    if not phase.found.reached:
        return ["No answer reaches the target, so there is nothing to certify."]
    told = []
    tried = [record for record in phase.cheaper if record.tried]
    left = [record for record in phase.cheaper if not record.tried]
    many = plural(sum(record.kind.number for record in tried), "cheaper support")
    if phase.refuted:
        cheaper = sum(int(record.reached.sum()) for record in tried)
        told.append(
            f"Not minimal: {plural(cheaper, 'support')} that cost less reach the target in the "
            "roll-out; solve again from more starts."
        )
    elif phase.minimal:
        told.append(
            f"Minimal, shown numerically: none of the {many} reaches "
            "the target, the short or the long way round, from rest or from random torques."
        )
    elif not phase.consistent:
        told.append(
            f"Nothing is shown: {many} were tried and none reaches, but neither does the answer's "
            "own support, which flies; the trials are not to be trusted here."
        )
    elif tried:
        told.append(
            f"None of {many} tried reaches the target; minimality is "
            "not shown, because others are out of reach."
        )
    if left:
        told.append(
            f"Out of reach: {number_text(sum(r.kind.number for r in left))} cheaper supports, "
            f"about {duration_text(sum(r.seconds for r in left))}."
        )
    equal = [record for record in phase.equal if record.tried]
    if equal:
        reached = sum(int(record.reached.sum()) for record in equal)
        total = sum(record.kind.number for record in equal)
        told.append(
            f"{reached} of {number_text(total)} supports that cost as much reach the target."
        )
    for record in phase.equal:
        if not record.tried:
            told.append(
                f"Not tried: the {number_text(record.kind.number)} supports of {record.kind.size} "
                f"that cost as much, about {duration_text(record.seconds)}."
            )
    if phase.best is not None and phase.best_effort is not None:
        same = phase.best_effort >= phase.found.l1_effort * (1.0 - 1e-6)
        way = ", the long way round" if phase.best_long else ""
        effort = f"{short(phase.best_effort)} N m s,"
        told.append(
            f"The least L1 effort among them has {_where(phase)}{way}: {effort}"
            + (
                " the answer's own effort."
                if same
                else f" less than the answer's {short(phase.found.l1_effort)}."
            )
        )
    return told


def _where(phase: PhaseCertificate) -> str:
    assert phase.best is not None
    return "intervals " + indices_text(sorted(set(phase.best[:, 0].tolist())))


def number_text(number: int) -> str:
    """Text of a number of supports, in digits where they mean something."""
    return f"{number}" if number < LARGE else f"{float(number):.3g}"


def duration_text(seconds: float) -> str:
    """Text of a duration in a suitable unit."""
    for unit, size in (("years", 3.15576e7), ("days", 86400.0), ("hours", 3600.0), ("min", 60.0)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.2g} s"

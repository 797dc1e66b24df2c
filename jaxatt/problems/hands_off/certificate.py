"""Record of trying the supports that cost less than an answer, or as much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from jaxatt.problems.answer import Answer
from jaxatt.problems.hands_off.search.enumeration import Enumerated, SupportClass
from jaxatt.records.phase import Phase
from jaxatt.runtime.arrays import Flags


@dataclass(frozen=True)
class ClassRecord:
    """Outcome of trying the supports of one class.

    kind : which supports.  short, long : tried the short and the long way round; None if the class
    is out of reach, or where there is but one way.  seconds : wall clock, or what it would take.
    """

    kind: SupportClass
    short: Enumerated | None
    long: Enumerated | None
    seconds: float

    @property
    def tried(self) -> bool:
        """Whether all supports of the class were tried."""
        return self.short is not None

    @property
    def reached(self) -> Flags:
        """Which supports reach the target one way round or the other, (S,)."""
        if self.short is None:
            return np.zeros(0, bool)
        return self.short.reached if self.long is None else self.short.reached | self.long.reached


@dataclass(frozen=True, eq=False)
class PhaseCertificate:
    """Certificate of one phase.

    found : the verified answer.  found_cost : its weighted count.
    cheaper, equal : classes of supports that cost less, and as much.
    best : (K, 2) interval and group of the best support of the found cost by L1 effort, verified in
    flight; None if those were out of reach.  best_effort : [N m s].  best_long : the way round.
    consistent : whether the answer's own support was found to reach, as it must be.
    """

    found: Phase
    found_cost: float
    cheaper: tuple[ClassRecord, ...]
    equal: tuple[ClassRecord, ...]
    best: npt.NDArray[np.int64] | None
    best_effort: float | None
    best_long: bool
    consistent: bool = True

    @property
    def minimal(self) -> bool:
        """Whether every cheaper support was tried with a reliable method and none reached."""
        nothing = all(record.tried and not record.reached.any() for record in self.cheaper)
        return self.found.reached and self.consistent and nothing

    @property
    def refuted(self) -> bool:
        """Whether a cheaper support reaches the target."""
        return any(record.reached.any() for record in self.cheaper)


@dataclass(frozen=True, eq=False)
class CertificateRecord:
    """Evidence on whether the answer of a solve is the sparsest."""

    result: Answer
    phases: tuple[PhaseCertificate, ...]

    @property
    def minimal(self) -> bool:
        """Whether all cheaper supports of every phase were tried and none reached."""
        return all(phase.minimal for phase in self.phases)

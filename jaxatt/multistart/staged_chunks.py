"""Choose how many starts of a programme over stages make one chunk."""

from __future__ import annotations

import jax

from jaxatt.runtime.chunks import ACCELERATOR_CHUNK, share_of

_STAGES = 640
"""Stages side by side that keep a core busy; more of them leave its cache."""

_MOST = 8
"""Starts side by side that a recursion over the stages gains from."""


def rows_of_stages(count: int, intervals: int) -> int:
    """Starts in one compiled call of the interior-point method, a power of two.

    The derivatives of all stages are evaluated side by side, so one start with 500 stages
    fills a core as well as eight with 60; the recursions over the stages are faster for one
    start than a share of many, and a start that has ended keeps no other waiting.

    count : starts.  intervals : stages of each.
    """
    if jax.default_backend() != "cpu":
        return min(ACCELERATOR_CHUNK, 1 << max(3, (share_of(count) - 1).bit_length()))
    share = 1 << max(0, share_of(count) - 1).bit_length()
    fitting = 1 << max(0, (_STAGES // intervals).bit_length() - 1)
    return min(share, fitting, _MOST)

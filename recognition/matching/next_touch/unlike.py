"""How unlike what is foreseen under each two hypotheses is, in standard deviations."""

from __future__ import annotations

import numpy as np
from numba import njit

from primitives.arrays import Bools, Floats
from recognition.matching.next_touch.outcomes import Outcomes


def unlikeness(outcomes: Outcomes, vague: Bools, noise: tuple[float, float, float], alike: float) -> Floats:
    """(c, h, h) squared distances where both or none are met, in single precision; -1 where one of them is.

    `noise` is of depth [mm], normal [rad] and gap [mm]; gaps err together over `alike` [mm^2] of the skin.
    Those of (h,) vague poses do not count: no match asks what lay under the pad where it does not know the pose.
    """
    depth, normal, gaps = (
        np.asarray(x, np.float32) for x in (outcomes.depth, outcomes.normal, outcomes.gaps)
    )
    flush, together = outcomes.flush, max(alike / outcomes.cell, 1.0)
    rolled = np.array(outcomes.sharp)
    args = np.array(outcomes.hit), depth, normal, np.ascontiguousarray(gaps), flush, rolled, np.array(vague)
    return np.asarray(_unlike(*args, *noise, outcomes.cell, together))


@njit(cache=True, nogil=True, fastmath=True)
def _unlike(hit, depth, normal, gaps, flush, rolled, vague, deep, turned, gapped, cell, together):  # type: ignore[no-untyped-def]
    count, many = hit.shape
    apart = np.zeros((count, many, many), dtype=np.float32)
    for c in range(count):
        for i in range(many):
            for j in range(i):
                d = np.float32(0.0)
                if hit[c, i] != hit[c, j]:
                    d = np.float32(-1.0)
                elif hit[c, i]:
                    both = flush[c, i] and flush[c, j]
                    unsure = deep**2 + cell if rolled[c, i] or rolled[c, j] else deep**2
                    d = np.float32((depth[c, i] - depth[c, j]) ** 2 / unsure)
                    if both:
                        turn, gap = np.float32(0.0), np.float32(0.0)
                        for k in range(3):
                            turn += (normal[c, i, k] - normal[c, j, k]) ** 2
                        for k in range(0 if vague[i] or vague[j] else gaps.shape[2]):
                            gap += (gaps[c, i, k] - gaps[c, j, k]) ** 2
                        d += np.float32(turn / turned**2 + gap / (together * gapped**2))
                apart[c, i, j] = apart[c, j, i] = d
    return apart

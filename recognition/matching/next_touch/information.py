"""How many bits an outcome would tell about the object, and about the pose.

Under hypothesis i with weight w_i an outcome is normal about what is foreseen.  The information between
hypothesis and outcome is bounded from below by the pairwise estimate of Kolchinsky and Tracey (2017) with
Bhattacharyya distances, which for one covariance are d^2 / 8::

    I >= - sum_i w_i log2 sum_j w_j exp(-d_ij^2 / 8)

Of the names alone it is that of all hypotheses less the mean of what is told within one name.  An object that
is in no library is like one of it in most places: it shares most of the outcomes of touches that meet something,
and where the pad meets nothing it tells nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from recognition.matching.next_touch.held import Held
from recognition.matching.next_touch.outcomes import Outcomes


@dataclass(frozen=True)
class TouchNoise:
    """How well an outcome can be foreseen, 1 sigma: the touch's own noise, and the poses' error."""

    depth: float = 0.5  # [mm]
    normal: float = 0.06  # [rad]
    gap: float = 0.35  # [mm]
    alike: float = 100.0  # [mm^2] of the skin, over which gaps err together
    never: float = 60.0  # squared distance between meeting and missing
    unknown: float = 0.7  # overlap of what is met with that of an object in no library


def information(outcomes: Outcomes, known: Held, noise: TouchNoise | None = None) -> tuple[Floats, Floats]:
    """(c,) bits about the name, and (c,) bits about the pose that a name has."""
    noise = noise or TouchNoise()
    overlap = np.exp(-squared_distances(outcomes, noise) / 8.0)
    shared = np.where(outcomes.hit, noise.unknown, 1.0)
    whole = _bits(overlap, known.weights, known.unknown, shared)
    within = np.zeros(len(overlap))
    for rows in known.groups:
        share = float(known.weights[rows].sum())
        if len(rows) > 1 and share > 0.0:
            own = overlap[:, rows][:, :, rows]
            within += share * _bits(own, known.weights[rows] / share, 0.0, shared[:, rows])
    return np.maximum(whole - within, 0.0), within


def squared_distances(outcomes: Outcomes, noise: TouchNoise) -> Floats:
    """(c, h, h) between what is foreseen under each two hypotheses, in standard deviations."""
    sharp = outcomes.sharp[:, :, None] | outcomes.sharp[:, None]
    unsure = np.where(sharp, noise.depth**2 + outcomes.cell, noise.depth**2)
    depth = (outcomes.depth[:, :, None] - outcomes.depth[:, None]) ** 2 / unsure
    turn = ((outcomes.normal[:, :, None] - outcomes.normal[:, None]) ** 2).sum(axis=-1) / noise.normal**2
    both_gaps = outcomes.gaps @ np.swapaxes(outcomes.gaps, 1, 2)  # |a - b|^2 without all a - b at once
    own = np.einsum("chh->ch", both_gaps)
    gap = np.maximum(own[:, :, None] + own[:, None] - 2.0 * both_gaps, 0.0)
    flush = turn + gap / (max(noise.alike / outcomes.cell, 1.0) * noise.gap**2)
    apart: Floats = depth + np.where(sharp, 0.0, flush)
    both = outcomes.hit[:, :, None] & outcomes.hit[:, None]
    one = outcomes.hit[:, :, None] ^ outcomes.hit[:, None]
    return np.where(both, np.minimum(apart, noise.never), np.where(one, noise.never, 0.0))


def _bits(overlap: Floats, weights: Floats, unknown: float, shared: Floats) -> Floats:
    mixed = overlap @ weights + unknown * shared
    told = -(np.log2(np.maximum(mixed, 1e-12)) @ weights)
    if unknown > 0.0:
        told = told - unknown * np.log2(unknown + shared @ weights)
    return np.asarray(told)

"""How many bits an outcome would tell about the object, and about the pose.

Under pose i, of weight w_i, of an object n_i an outcome is normal about what is foreseen.  Any guess q of the name
from the outcome bounds the bits about it from below (Barber and Agakov 2003)::

    I(name) >= sum_i w_i log2( q(n_i | y_i) / p(n_i) )

Here q goes by how much outcomes of each name's other poses overlap with y_i, exp(-d^2 / 8), at the best of some
widths: a draw from a loose pose says nothing by being itself, so it is left out where its own name is asked, and
few draws tell no more than their like do.  The bits about the pose are those that tell poses of one name apart::

    I(pose) ~ - sum_i w_i log2 sum_j w_j exp(-d_ij^2 / 8)            (Kolchinsky and Tracey 2017)

An object that is in no library is like one of it in most places: it shares most of what is met.  That the pad
meets nothing tells little, for it tells nothing of what it is that is not there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from recognition.matching.next_touch.held import Held
from recognition.matching.next_touch.outcomes import Outcomes
from recognition.matching.next_touch.unlike import unlikeness


@dataclass(frozen=True)
class TouchNoise:
    """How well an outcome can be foreseen, 1 sigma: the touch's own noise, and the poses' error."""

    depth: float = 0.5  # [mm]
    normal: float = 0.06  # [rad]
    gap: float = 0.35  # [mm]
    alike: float = 30.0  # [mm^2] of the skin, over which gaps err together
    widths: tuple[float, ...] = (1.0, 2.0, 4.0)  # times these, over which outcomes count as alike
    apart: float = 3.0  # the same of poses that are worth telling apart
    never: float = 60.0  # squared distance from what would have been missed
    background: float = 0.005  # overlap of any two outcomes, at least
    unknown: float = 0.7  # overlap of what is met with that of an object in no library


def information(outcomes: Outcomes, known: Held, noise: TouchNoise | None = None) -> tuple[Floats, Floats]:
    """(c,) bits about the name, and (c,) bits about the pose that a name has."""
    noise = noise or TouchNoise()
    apart = unlikeness(outcomes, known.vague, (noise.depth, noise.normal, noise.gap), noise.alike)
    names = [
        _named(_overlap(apart, width, outcomes, noise), known, outcomes, noise) for width in noise.widths
    ]
    overlap = _overlap(apart, noise.apart, outcomes, noise)
    within = np.zeros(len(overlap))
    for rows in known.groups:
        share = float(known.weights[rows].sum())
        if len(rows) > 1 and share > 0.0:
            weights = known.weights[rows] / share
            mixed = overlap[:, rows][:, :, rows] @ weights
            within -= share * (np.log2(np.maximum(mixed, 1e-12)) @ weights)
    return np.maximum(np.max(names, axis=0), 0.0), within


def _overlap(apart: Floats, width: float, outcomes: Outcomes, noise: TouchNoise) -> Floats:
    """(c, h, h) of what is foreseen under i with that under j."""
    lone = np.where(outcomes.hit, np.exp(-noise.never / 8.0), 1.0).astype(np.float32)
    return np.where(apart < 0.0, lone[:, :, None], np.exp(apart * np.float32(-0.125 / width**2)))


def _named(overlap: Floats, known: Held, outcomes: Outcomes, noise: TouchNoise) -> Floats:
    """(c,) bits about the name by one guess of it."""
    groups, rows, weights = known.groups, np.arange(len(known)), known.weights
    share = np.array([weights[own].sum() for own in groups])
    member = np.zeros((len(known), len(groups)))
    for g, own in enumerate(groups):
        member[own, g] = weights[own] / share[g]
    of = member.argmax(axis=1)
    like = np.asarray(overlap @ member.astype(np.float32), dtype=float)  # (c, h, names)
    itself = np.where(known.loose & (np.bincount(of)[of] > 1), member[rows, of], 0.0)
    like[:, rows, of] = (like[:, rows, of] - itself) / np.maximum(1.0 - itself, 1e-9)
    like = np.maximum(like, 0.0) + noise.background
    strange = known.unknown * like.max(axis=2) * np.where(outcomes.hit, noise.unknown, 1.0)
    guessed = like[:, rows, of] / (like @ share + strange)
    return np.asarray(np.log2(guessed) @ weights)

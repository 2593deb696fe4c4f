"""Matching with the noise that the contacts turn out to have, where nobody told it.

A guess from the contacts alone may be far too wide where few of them share a face: they are looked for too far
from the surface, and count for too little beside their normals.  What they leave over on the likeliest pose tells
more: the median of |r| over that of a normal variable.  The pose has the least sum of |r|, which passes through as
many contacts as a pose has numbers, so that the six least say nothing; and m left over tell sigma but roughly, so
that it is raised by 1 + 2 / m.  They are matched again with that until it falls no more (our derivation).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from models.library import Entry
from primitives.arrays import frozen
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.belief import UNKNOWN
from recognition.matching.match import MatchConfig

MADE = 0.06  # [mm] by which an object differs from its model, whose facets are only so fine
_MEDIAN = 0.6745  # of |r| of a unit normal
_POSE = 6  # numbers
_FEWEST = 2  # contacts left over, below which they tell nothing


@dataclass(frozen=True)
class SettleConfig:
    """How often contacts are matched, and when that is enough."""

    rounds: int = 4
    falls: float = 1.5  # factor by which sigma falls while it is not settled
    likely: float = 0.01  # probability of a pose that is tried again


def settled(evidence: Evidence, library: Mapping[str, Entry], prior: Prior | None, unknown: float,
            matching: MatchConfig, config: SettleConfig = SettleConfig()) -> tuple[Belief, Evidence]:  # fmt: skip
    """What the evidence says of which object it is, and where; and the evidence with the noise that was taken."""
    belief = match(evidence, library, prior, unknown, config=matching)
    for _ in range(config.rounds):
        left = _left_over(belief, evidence, library)
        if left is None or left > float(np.median(evidence.contacts.sigma)) / config.falls:
            break
        sigma = np.full(len(evidence.contacts), left)
        narrow = replace(evidence, contacts=replace(evidence.contacts, sigma=frozen(sigma)))
        starts = [(h.name, h.pose) for h in belief.hypotheses if h.probability > config.likely]
        again = match(narrow, library, prior, unknown, starts, matching)
        belief, evidence = again, narrow
    return belief, evidence


def _left_over(belief: Belief, evidence: Evidence, library: Mapping[str, Entry]) -> float | None:
    """[mm] 1 sigma of the contacts from the likeliest pose of what is decided; None where that tells nothing."""
    best = belief.best(belief.decision)
    count = len(evidence.contacts)
    if evidence.scale_known or belief.decision == UNKNOWN or best is None or count < _POSE + _FEWEST:
        return None
    there = (evidence.contacts.points - best.pose[:3, 3]) @ best.pose[:3, :3]
    off = np.sort(np.abs(library[best.name].solid.signed_distance(there)))[_POSE:]
    return max(float(np.median(off)) / _MEDIAN * (1.0 + 2.0 / len(off)), MADE)

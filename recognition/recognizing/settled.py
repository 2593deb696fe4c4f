"""Matching with the noise that the contacts turn out to have, where nobody told it.

A guess from the contacts alone may be far too wide where few of them share a face: they are looked for too far
from the surface, and count for too little beside their normals.  What they leave over on the likeliest pose tells
more (`left_over`).  They are matched again with that until it falls no more, and it is theirs then but for the
factor between Laplace's b and sigma: few would else pass for surer than they are, for their least sum of |r|
passes through as many as the pose has numbers.  What is left over by more than was guessed may be another
object's, which would fit all the better: the guess stays then (our derivation).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from models.library import Entry
from primitives.arrays import frozen
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.belief import UNKNOWN
from recognition.matching.facing import turned
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.match import MatchConfig
from recognition.recognizing.left_over import Scatter, left_over

MADE = 0.06  # [mm] by which an object differs from its model, whose facets are only so fine


@dataclass(frozen=True)
class SettleConfig:
    """How often contacts are matched, and when that is enough."""

    rounds: int = 4
    falls: float = (
        1.2  # factor by which sigma falls while it is not settled, and may rise over the guess at first
    )
    loosest: float = 1.2533  # sqrt(pi / 2): factor up to which it may be less or more then
    likely: float = 0.01  # probability of a pose that is tried again


def settled(evidence: Evidence, library: Mapping[str, Entry], prior: Prior | None, unknown: float,
            matching: MatchConfig, config: SettleConfig = SettleConfig()) -> tuple[Belief, Evidence]:  # fmt: skip
    """What the evidence says of which object it is, and where; and the evidence with the noise that was taken."""
    belief = match(evidence, library, prior, unknown, config=matching)
    told = replace(matching, noise=replace(matching.noise, loosest=config.loosest))
    for again in range(config.rounds):
        left = _told(belief, evidence, library, matching.noise)
        most = float(np.median(evidence.contacts.sigma)) * (1.0 / config.falls if again else config.falls)
        if left is None or left.sigma > most:
            break
        evidence = _with(evidence, left)
        starts = [(h.name, h.pose) for h in belief.hypotheses if h.probability > config.likely]
        belief = match(evidence, library, prior, unknown, starts, told)
    return belief, evidence


def _told(
    belief: Belief, evidence: Evidence, library: Mapping[str, Entry], noise: NoiseConfig
) -> Scatter | None:
    """How the contacts scatter about the likeliest pose of what is decided; None where that tells nothing."""
    best = belief.best(belief.decision)
    if evidence.scale_known or belief.decision == UNKNOWN or best is None:
        return None
    seen = turned(evidence) if belief.inward > 0.5 else evidence
    return left_over(seen.checked().contacts, library[best.name], best.pose, MADE, noise)


def _with(evidence: Evidence, left: Scatter) -> Evidence:
    c = evidence.contacts
    c = replace(c, sigma=frozen(np.full(len(c), left.sigma)))
    if left.tau is not None and not evidence.normal_scale_known:
        c = replace(c, normal_sigma=frozen(np.full(len(c), left.tau)))
    return replace(evidence, contacts=c)

"""What taxels say that felt nothing beside others that did: no surface is where it would have been felt.

Under a hypothesis, an untouched place of the skin that lies inside the object contradicts it.  With probability
`wrong` such a taxel says so by mistake, taxels of one neighborhood together, so that a hypothesis loses at most

    log(wrong) * min(contradictions / together, most)

A pose that is not known well enough to say where its holes are loses nothing (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from models.library import Library
from primitives.arrays import Floats
from primitives.evidence import FreeSpace
from primitives.pose import transform_points
from recognition.matching import Belief, Hypothesis
from recognition.matching.next_touch.held import UNKNOWN


@dataclass(frozen=True)
class UntouchedConfig:
    """When an untouched taxel contradicts a hypothesis."""

    inside: float = 0.3  # [mm] of material over the skin there
    wrong: float = 0.02  # probability that a place so deep inside is not felt
    together: int = 3  # taxels that err together
    most: float = 4.0  # such groups that count
    passed: float = 0.1  # share of its weight that a pose keeps for each approach that goes through it
    samples: int = 3  # of its surface in the way, for that
    shrunk: float = 2.5  # [mm] by which what was swept is narrower for that
    placed: float = 0.6  # [mm] error of the place, beyond which a hypothesis is not asked
    turned: float = 0.05  # [rad] likewise


def swept(belief: Belief, library: Library, free: FreeSpace, config: UntouchedConfig | None = None) -> Belief:
    """The belief after approaches that met nothing: a pose that they go through is unlikely, and no more.

    Poses are modes; while they are loose, one beside the mode may let the pad pass.
    """
    config = config or UntouchedConfig()
    if not len(free.poses) or not belief.hypotheses:
        return belief
    gains = np.zeros(len(belief.hypotheses))
    for k, h in enumerate(belief.hypotheses):
        points = transform_points(h.pose, library[h.name].samples.points)
        for pose, half in zip(free.poses, free.half_extents, strict=True):
            inside = FreeSpace(pose[None], half[None]).contains(points, config.shrunk)
            gains[k] += np.log(config.passed) if inside.sum() >= config.samples else 0.0
    return _reweighed(belief, np.maximum(gains, config.most * np.log(config.passed)))


def weighed(belief: Belief, library: Library, cells: Floats, config: UntouchedConfig | None = None) -> Belief:
    """The belief after (n, 3) places of the skin [mm] that felt nothing."""
    config = config or UntouchedConfig()
    if not len(cells) or not belief.hypotheses:
        return belief
    return _reweighed(belief, np.array([_gain(h, library, cells, config) for h in belief.hypotheses]))


def _reweighed(belief: Belief, gains: Floats) -> Belief:
    """With `gains` (h,) on the logarithms of the hypotheses' weights; `unknown` does as well as the best name."""
    shares = dict.fromkeys(belief.probabilities, 1.0)
    for name in belief.probabilities:
        rows = [k for k, h in enumerate(belief.hypotheses) if h.name == name]
        if rows and name != UNKNOWN:
            before = np.exp([belief.hypotheses[k].log_weight for k in rows])
            if before.sum() > 0.0:
                shares[name] = float(before @ np.exp(gains[rows]) / before.sum())
    shares[UNKNOWN] = max((shares[h.name] for h in belief.hypotheses), default=1.0)
    after = {name: p * shares[name] for name, p in belief.probabilities.items()}
    total = sum(after.values())
    if total <= 0.0:
        return belief
    told = [
        replace(h, log_weight=float(h.log_weight + gain - np.log(total)))
        for h, gain in zip(belief.hypotheses, gains, strict=True)
    ]
    told.sort(key=lambda h: -h.log_weight)
    return Belief(tuple(told), {name: p / total for name, p in after.items()})


def _gain(h: Hypothesis, library: Library, cells: Floats, config: UntouchedConfig) -> float:
    if h.translation_sigma > config.placed or h.rotation_sigma > config.turned:
        return 0.0
    depth = library[h.name].solid.placed(h.pose).signed_distance(cells)
    groups = int((depth < -config.inside).sum()) / config.together
    return float(np.log(config.wrong) * min(groups, config.most))

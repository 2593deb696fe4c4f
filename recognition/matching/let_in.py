"""Where a hypothesis stands so that space which was felt empty lets it be, of all poses it stands for.

Approaches swept space, skin felt nothing beside what it felt, and its whole picture was felt: what of that speaks
against a pose is a bound on its likelihood.  A loose pose is asked at poses beside it, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import logsumexp

from models.library import Entry
from primitives.arrays import Floats, frozen
from recognition.console.interrupts import checkpoint
from recognition.matching.belief import Hypothesis
from recognition.matching.evidence import Evidence
from recognition.matching.imprints import log_imprints
from recognition.matching.loose import LooseConfig, cross_points, sigma_points
from recognition.matching.target import Target
from recognition.matching.untouched import log_untouched

SWEPT = -4.6  # log likelihood of a sample of the object in space that was swept
_TRIED = LooseConfig(sigmas=(0.6, 1.2))  # poses that a loose mode stands for


def let_in(made: Hypothesis, entry: Entry, target: Target, evidence: Evidence) -> tuple[Hypothesis, float]:
    """The hypothesis where space that was felt empty lets it be, of all poses it stands for, and what is left."""
    nothing = evidence.free is None and evidence.missed is None and not len(evidence.untouched)
    if nothing and not evidence.imprints:
        return made, 0.0
    sigma = float(np.median(evidence.contacts.sigma))

    def left_at(at: Floats) -> float:
        checkpoint()
        there = replace(made, pose=frozen(at))
        told = _free(evidence, target, at, sigma) + log_untouched(there, entry, evidence)
        return told + log_imprints(there, entry, evidence)

    left = [left_at(made.pose)]
    if left[0] == 0.0:
        return made, 0.0
    poses = sigma_points(made.pose, made.covariance, entry, _TRIED)
    for at in poses[1:]:
        left.append(left_at(at))
        if left[-1] == 0.0:
            return replace(made, pose=frozen(at)), 0.0
    best = int(np.argmax(left))
    if left[best] > SWEPT:
        return replace(made, pose=frozen(poses[best])), left[best]
    poses += cross_points(made.pose, made.covariance, entry, _TRIED)
    left += [left_at(at) for at in poses[len(left) :]]
    best = int(np.argmax(left))
    return replace(made, pose=frozen(poses[best])), float(logsumexp(left) - np.log(len(left)))


def _free(evidence: Evidence, target: Target, world: Floats, sigma: float) -> float:
    """Logarithm of how well the object keeps out of the space that was swept: one outlier a sample in it."""
    if evidence.free is None or len(evidence.free.poses) == 0:
        return 0.0
    inside = evidence.free.contains(target.points @ world[:3, :3].T + world[:3, 3], margin=3 * sigma + 1.0)
    return float(SWEPT * min(int(inside.sum()), 10))

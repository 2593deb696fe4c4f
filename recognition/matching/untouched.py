"""What places say at which nothing was felt: no surface is where it would have been felt.

Under a hypothesis, an untouched place of the skin that lies inside the object contradicts it.  With probability
`wrong` such a taxel says so by mistake, taxels of one neighborhood together, so that a hypothesis loses at most

    log(wrong) * min(contradictions / together, most)

A pose that is not known well enough to say where its holes are loses nothing.  An approach that met nothing makes
a pose that it goes through unlikely, and no more: poses are modes, and while they are loose, one beside the mode
may let the pad pass (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.library import Entry
from primitives.arrays import Floats
from primitives.evidence import FreeSpace
from primitives.pose import transform_points
from recognition.matching.belief import Hypothesis
from recognition.matching.evidence import Evidence


@dataclass(frozen=True)
class UntouchedConfig:
    """When a place contradicts a hypothesis."""

    inside: float = 0.3  # [mm] of material over the skin there
    wrong: float = 0.02  # probability that a place so deep inside is not felt
    together: int = 3  # taxels that err together
    most: float = 4.0  # such groups that count, and approaches
    passed: float = 0.1  # share of its weight that a pose keeps for each approach that goes through it
    samples: int = 3  # of its surface in the way, for that
    shrunk: float = 2.5  # [mm] by which what was swept is narrower for that
    placed: float = 0.6  # [mm] error of the place, beyond which a hypothesis is not asked
    turned: float = 0.05  # [rad] likewise


def log_untouched(
    h: Hypothesis, entry: Entry, evidence: Evidence, config: UntouchedConfig | None = None
) -> float:
    """Logarithm of what is left of a hypothesis after all that was not felt."""
    config = config or UntouchedConfig()
    return _under_skin(h, entry, evidence.untouched, config) + _passed(h, entry, evidence.missed, config)


def _under_skin(h: Hypothesis, entry: Entry, cells: Floats, config: UntouchedConfig) -> float:
    """Of (n, 3) places of the skin [mm] that felt nothing beside others that did."""
    if not len(cells) or h.translation_sigma > config.placed or h.rotation_sigma > config.turned:
        return 0.0
    depth = entry.solid.placed(h.pose).signed_distance(cells)
    groups = int((depth < -config.inside).sum()) / config.together
    return float(np.log(config.wrong) * min(groups, config.most))


def _passed(h: Hypothesis, entry: Entry, missed: FreeSpace | None, config: UntouchedConfig) -> float:
    """Of approaches that met nothing."""
    if missed is None or not len(missed.poses):
        return 0.0
    points = transform_points(h.pose, entry.samples.points)
    through = missed.passed(points, config.shrunk, config.samples, int(config.most))
    return float(np.log(config.passed) * through)

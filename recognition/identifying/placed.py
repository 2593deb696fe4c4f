"""Whether the pose of the object that is believed in is known too, and not only its name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.library import Entry
from models.symmetry import pose_error
from recognition.matching import Belief


@dataclass(frozen=True)
class PlacedConfig:
    """What is known well enough."""

    sigma: float = 0.5  # [mm] error of the likeliest pose's place
    near: float = 2.0  # [mm] poses that are as good as the likeliest
    turned: float = 0.05  # [rad] likewise, and the error of its attitude


def is_placed(belief: Belief, entry: Entry, confidence: float, config: PlacedConfig | None = None) -> bool:
    """Whether the likeliest pose is sharp, and poses near it, up to symmetry, have that share of its name."""
    config = config or PlacedConfig()
    mine = [h for h in belief.hypotheses if h.name == entry.name]
    if not mine or mine[0].translation_sigma >= config.sigma or mine[0].rotation_sigma >= config.turned:
        return False
    shares = np.exp([h.log_weight - mine[0].log_weight for h in mine])
    near = 0.0
    for share, h in zip(shares, mine, strict=True):
        error = pose_error(entry.symmetry, h.pose, mine[0].pose)
        near += share if error.distance <= config.near and error.angle <= config.turned else 0.0
    return bool(near >= confidence * shares.sum())

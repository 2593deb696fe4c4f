"""All that may be, as objects at poses: a belief's sharp modes as they are, its loose ones by draws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from models.library import Entry, Library
from primitives.arrays import Floats
from recognition.matching.evidence import Evidence
from recognition.matching.next_touch.drawn import DrawConfig, Seen, drawn
from recognition.matching.next_touch.held import UNKNOWN, Believed, Held, Posed, placed
from recognition.matching.next_touch.placing import doubt


@dataclass(frozen=True)
class SampleConfig:
    """How many draws stand for a belief."""

    most: int = 112  # of all names, about
    fewest: int = 4  # of a name
    each: int = 12  # modes of a name
    least: float = 2e-3  # probability of a name, below which it is left out
    slight: float = 0.25  # draws, for which a mode of a name is too slight
    sharp: float = 0.5  # [mm] error of places of its surface, up to which a mode is one pose
    behind: float = 8.0  # log likelihood that a mode can lose to others of its name by what its draws meet
    drawing: DrawConfig = field(default_factory=DrawConfig)


def sampled(belief: Believed, library: Library, evidence: Evidence, rng: np.random.Generator,
            config: SampleConfig | None = None) -> Held:  # fmt: skip
    """The objects that are likely, each name's probability shared among poses that it may have."""
    config = config or SampleConfig()
    chances = {n: p for n, p in belief.probabilities.items() if n != UNKNOWN and p >= config.least}
    own = {n: [h for h in belief.hypotheses if h.name == n] for n in chances}
    total = sum(chance for n, chance in chances.items() if own[n])
    seen = Seen.of(evidence, config.drawing)
    kept: list[tuple[str, Floats, float, float]] = []
    for name, modes in own.items():
        if modes:
            share = chances[name] / total
            many = max(config.fewest, round(config.most * share))
            best = sorted(modes, key=lambda h: -h.log_weight)[: config.each]
            kept += [
                (name, at, share * weight, loose)
                for at, weight, loose in _poses(best, library[name], many, seen, rng, config)
            ]
    return placed(kept, library, float(belief.probabilities.get(UNKNOWN, 0.0)))


def _poses(modes: Sequence[Posed], entry: Entry, many: int, seen: Seen, rng: np.random.Generator,
           config: SampleConfig) -> list[tuple[Floats, float, float]]:  # fmt: skip
    """Of one name: poses, weights that sum to one, and [mm] of how loose a mode they are drawn from."""
    shares = np.exp(np.array([h.log_weight - modes[0].log_weight for h in modes]))
    shares /= shares.sum()
    found: list[tuple[Floats, float]] = []
    fits: list[float] = []
    parts = [float(s) for s in shares if s * many >= config.slight]
    for h, part in zip(modes, parts, strict=False):
        open_by = doubt(h, entry)
        if open_by <= config.sharp:
            found.append((h.pose[None], 0.0))
            fits.append(np.inf)
        else:
            poses, like = drawn(h, entry, max(2, int(np.ceil(many * part))), seen, rng, config.drawing)
            found.append((poses, open_by))
            fits.append(float(like.max()))
    best = max((f for f in fits if np.isfinite(f)), default=0.0)
    weights = np.array(parts) * np.exp(np.clip(np.array(fits) - best, -config.behind, 0.0))
    weights /= weights.sum()
    return [
        (pose, float(weight) / len(poses), loose)
        for (poses, loose), weight in zip(found, weights, strict=True)
        for pose in poses
    ]

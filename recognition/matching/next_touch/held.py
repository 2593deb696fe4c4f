"""The part of a belief that a next touch is chosen for: its likeliest hypotheses, with weights that sum to one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from models.library import Library
from models.solid import Solid
from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.pose import transform_points
from recognition.matching.loose import sigma_points

_VAGUE = 0.6  # [mm] error of places of the surface, as `untouched` and `imprints` have it
UNKNOWN = "unknown"  # none of the library's objects


class Posed(Protocol):
    """One hypothesis: an object at a pose."""

    @property
    def name(self) -> str:
        """Of the object."""
        ...

    @property
    def pose(self) -> Floats:
        """(4, 4) world_from_object."""
        ...

    @property
    def log_weight(self) -> float:
        """Up to a constant."""
        ...

    @property
    def covariance(self) -> Floats:
        """(6, 6) of (v [mm], w [rad]) in the object's frame, about the middle of its box."""
        ...


class Believed(Protocol):
    """A belief over objects and poses."""

    @property
    def hypotheses(self) -> Sequence[Posed]:
        """All that are still held."""
        ...

    @property
    def probabilities(self) -> Mapping[str, float]:
        """By name, `unknown` among them."""
        ...


@dataclass(frozen=True)
class HeldConfig:
    """How much of a belief is looked at."""

    most: int = 28  # hypotheses
    each: int = 8  # of one name
    least: float = 2e-3  # probability of a name, below which it is left out
    spread: int = 6  # hypotheses, likeliest first, that stand for all poses that their covariance spans


@dataclass(frozen=True)
class Held:
    """Hypotheses as solids at their poses."""

    names: tuple[str, ...]  # of each hypothesis
    solids: tuple[Solid, ...]
    weights: Floats  # (h,) with `unknown` they sum to one
    centers: Floats  # (h, 3) [mm]
    radii: Floats  # (h,) [mm] of balls round the centers that hold the objects
    unknown: float  # probability of none of these
    doubts: Floats | None = (
        None  # (h,) [mm] of the modes that these are draws of; 0, or left out: itself a mode
    )

    @property
    def groups(self) -> list[Ints]:
        """Rows of each name."""
        of = np.array(self.names)
        return [np.flatnonzero(of == name) for name in dict.fromkeys(self.names)]

    @property
    def loose(self) -> Bools:
        """(h,) which are draws: what is so exactly is none of them."""
        return np.zeros(len(self), dtype=bool) if self.doubts is None else self.doubts > 0.0

    @property
    def vague(self) -> Bools:
        """(h,) whose pose is too loose for it to be asked what lies under the skin."""
        return np.zeros(len(self), dtype=bool) if self.doubts is None else self.doubts > _VAGUE

    def __len__(self) -> int:
        return len(self.names)


def held(belief: Believed, library: Library, config: HeldConfig | None = None) -> Held:
    """The likeliest hypotheses, a name's probability shared among its own by their weights."""
    config = config or HeldConfig()
    chances = {n: p for n, p in belief.probabilities.items() if n != UNKNOWN and p >= config.least}
    kept: list[tuple[float, Posed]] = []
    for name, chance in chances.items():
        own = sorted((h for h in belief.hypotheses if h.name == name), key=lambda h: -h.log_weight)
        own = own[: config.each]
        if own:
            shares = np.exp(np.array([h.log_weight for h in own]) - own[0].log_weight)
            kept += [(float(chance * s / shares.sum()), h) for s, h in zip(shares, own, strict=True)]
    kept = sorted(kept, key=lambda pair: -pair[0])[: config.most]
    unknown = float(belief.probabilities.get(UNKNOWN, 0.0))
    spread = [
        (h.name, pose, weight / len(poses), 0.0)
        for k, (weight, h) in enumerate(kept)
        for poses in [sigma_points(h.pose, h.covariance, library[h.name]) if k < config.spread else [h.pose]]
        for pose in poses
    ]
    return placed(spread, library, unknown)


def placed(told: Iterable[tuple[str, Floats, float, float]], library: Library, unknown: float) -> Held:
    """Names at poses (4, 4) with their shares of what is known, and how loose [mm] what they are drawn from is."""
    rows = list(told)
    weights = np.array([weight for _, _, weight, _ in rows])
    solids = tuple(library[name].solid.placed(pose) for name, pose, _, _ in rows)
    balls = [_ball(solid) for solid in solids]
    return Held(
        tuple(name for name, _, _, _ in rows),
        solids,
        frozen(weights * (1.0 - unknown) / max(float(weights.sum()), 1e-12)),
        frozen(np.array([b[0] for b in balls]).reshape(-1, 3)),
        frozen(np.array([b[1] for b in balls])),
        unknown,
        frozen(np.array([loose for _, _, _, loose in rows])),
    )


def _ball(solid: Solid) -> tuple[Floats, float]:
    vertices = solid.body.vertices
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    radius = float(np.linalg.norm(vertices - middle, axis=1).max())
    return transform_points(solid.pose, middle[None])[0], radius

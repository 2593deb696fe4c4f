"""What an approach would feel under each hypothesis, by ray casting on the posed models.

A grid of rays stands for the skin.  The first hit is where contact begins; its distance and normal are felt,
and so is, once the pad lies flush, how far every place of the skin is from the plane of contact: nothing there,
an edge, a hole, or a wall in the way.  That gap is felt up to the press only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.lone_touch import Approach
from models.solid import Solid
from primitives.arrays import Bools, Floats, frozen

_GAP = 1.0  # [mm] beyond which the skin cannot say how far away the surface is
_GRID = (5, 3)  # rays over the skin, along its x and y


@dataclass(frozen=True)
class Outcomes:
    """For c approaches under h hypotheses."""

    hit: Bools  # (c, h)
    depth: Floats  # (c, h) [mm] of advance to first contact; 0 where nothing is met
    normal: Floats  # (c, h, 3) outward there
    gaps: Floats  # (c, h, k) [mm] below the plane of contact, within +- 1
    risk: Floats  # (c, h) chance that the housing is in the way or the pad does not settle


def foresee(approaches: list[Approach], solids: tuple[Solid, ...], size: tuple[float, float]) -> Outcomes:
    """Cast all rays of all approaches on each solid."""
    starts = np.stack([a.start for a in approaches])
    x, y = (np.linspace(-0.45 * s, 0.45 * s, n) for s, n in zip(size, _GRID, strict=True))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    c, k, h = len(approaches), len(grid), len(solids)
    origins = starts[:, None, :3, 3] + np.einsum("cij,kj->cki", starts[:, :3, :2], grid)
    ways = np.broadcast_to(starts[:, None, :3, 2], origins.shape)
    length = np.array([a.length for a in approaches])
    hit, depth = np.zeros((c, h), dtype=bool), np.zeros((c, h))
    normal, gaps, risk = np.zeros((c, h, 3)), np.full((c, h, k), _GAP), np.zeros((c, h))
    for j, solid in enumerate(solids):
        cast = solid.cast_rays(origins.reshape(-1, 3), np.ascontiguousarray(ways.reshape(-1, 3)))
        reached = cast.distance.reshape(c, k)
        first = reached.argmin(axis=1)
        rows = np.arange(c)
        met = reached[rows, first] <= length
        hit[:, j], depth[:, j] = met, np.where(met, reached[rows, first], 0.0)
        normal[:, j] = cast.normals.reshape(c, k, 3)[rows, first] * met[:, None]
        felt = np.isfinite(reached)
        points = origins + np.where(felt, reached, 0.0)[..., None] * ways
        below = np.einsum("cki,ci->ck", points[rows, first][:, None] - points, normal[:, j])
        gaps[:, j] = np.where(felt & met[:, None], np.clip(below, -_GAP, _GAP), _GAP)
        steep = -np.einsum("ci,ci->c", normal[:, j], starts[:, :3, 2]) < 0.5
        blocked = (below < -2.0).any(axis=1, where=felt)
        risk[:, j] = np.where(met, 0.15 + 0.35 * steep + 0.4 * blocked, 0.0)
    return Outcomes(frozen(hit, bool), frozen(depth), frozen(normal), frozen(gaps), frozen(risk))

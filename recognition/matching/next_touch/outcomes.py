"""What an approach would feel under each hypothesis, by ray casting on the posed models.

A grid of rays stands for the skin.  The first hit is where contact begins; its distance and normal are felt,
and so is, once the pad lies flush, how far every place of the skin is from the plane of contact: nothing there,
an edge, a hole, or a wall in the way.  That gap is felt up to the press only.  A pad that comes down aslant on an
edge or a corner may roll onto any face beside it: neither normal nor gaps are foreseen there, and how deep it lies
only as well as rays stand close.  Where something stands higher than the plane of contact, as the far rim of a
bowl, the pad cannot lie flush, and no normal is felt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from models.solid import Solid
from primitives.arrays import Bools, Floats, frozen

_GAP = 1.0  # [mm] beyond which the skin cannot say how far away the surface is
_APART = (2.0, 6.0)  # [mm] between rays over the skin: a hole of twice that is met by several
_RAYS = (
    600_000  # in all, that are cast where few poses are asked; of more, rays stand as far apart as they may
)
_ASLANT = 0.25  # [rad] between pad and face, from which it meets the face's edge first
_FOLD = 0.5  # [rad] between the normals beside an edge
_BESIDE = 8.0  # [mm] by which the same face may lie deeper beside the first contact
_HIGHER = 0.6  # [mm] above the plane of contact, to which the rubber does not give way
_UNSETTLED = 0.1  # chance that a pad that meets a face squarely does not settle at once,
_LEANING = 0.2  # [1/rad] and what leaning adds: the rim is crushed to the housing before outer taxels feel
_SKIN = 0.9  # of the skin's sides, that rays cover


@dataclass(frozen=True)
class Outcomes:
    """For c approaches under h hypotheses."""

    hit: Bools  # (c, h)
    depth: Floats  # (c, h) [mm] of advance to first contact; 0 where nothing is met
    normal: Floats  # (c, h, 3) outward there
    gaps: Floats  # (c, h, k) [mm] below the plane of contact, within +- 1
    risk: Floats  # (c, h) chance that the housing is in the way or the pad does not settle
    sharp: (
        Bools  # (c, h) whether it meets an edge or a corner aslant, so that either face's normal may be felt
    )
    cell: float = 50.0  # [mm^2] of the skin that a place stands for
    propped: Bools | None = None  # (c, h) whether something stands too high for the pad to lie flush

    @property
    def flush(self) -> Bools:
        """(c, h) whether the normal and the gaps are felt that are foreseen."""
        return ~self.sharp if self.propped is None else ~(self.sharp | self.propped)


def foresee(approaches: list[Approach], solids: tuple[Solid, ...], size: tuple[float, float]) -> Outcomes:
    """Cast all rays of all approaches on each solid."""
    starts = np.stack([a.start for a in approaches])
    each = _RAYS / max(len(approaches) * len(solids), 1)
    apart = float(np.clip(_SKIN * np.sqrt(size[0] * size[1] / each), *_APART))
    x, y = (_across(side, apart) for side in size)
    cell = _SKIN**2 * size[0] * size[1] / (len(x) * len(y))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    c, k, h = len(approaches), len(grid), len(solids)
    origins = starts[:, None, :3, 3] + np.einsum("cij,kj->cki", starts[:, :3, :2], grid)
    ways = np.ascontiguousarray(np.broadcast_to(starts[:, None, :3, 2], origins.shape))
    rays = [np.ascontiguousarray(x.reshape(-1, 3), dtype=np.float32) for x in (origins, ways)]
    length, rows = np.array([a.length for a in approaches]), np.arange(len(approaches))
    hit, depth = np.zeros((c, h), dtype=bool), np.zeros((c, h))
    normal, gaps, risk = np.zeros((c, h, 3)), np.full((c, h, k), _GAP), np.zeros((c, h))
    sharp, propped = np.zeros((c, h), dtype=bool), np.zeros((c, h), dtype=bool)
    spacing = max(x[1] - x[0], y[1] - y[0])
    beside = np.linalg.norm(grid[:, None] - grid, axis=2) < 1.5 * spacing
    for j, solid in enumerate(solids):
        distance, triangle = solid.first_hits(rays[0], rays[1])
        reached = distance.astype(np.float64).reshape(c, k)
        first = reached.argmin(axis=1)
        met = reached[rows, first] <= length
        hit[:, j], depth[:, j] = met, np.where(met, reached[rows, first], 0.0)
        normal[:, j] = solid.cast_rays(origins[rows, first], ways[rows, first]).normals * met[:, None]
        felt = np.isfinite(reached)
        along = -np.einsum("ci,ci->c", normal[:, j], starts[:, :3, 2])
        height = (
            np.einsum("cki,ci->ck", origins, normal[:, j]) - np.where(felt, reached, 0.0) * along[:, None]
        )
        below = height[rows, first][:, None] - height
        gaps[:, j] = np.where(felt & met[:, None], np.clip(below, -_GAP, _GAP), _GAP)
        facets = solid.body.triangle_normals[triangle].reshape(c, k, 3)
        turned = np.einsum("cki,ci->ck", facets, normal[:, j] @ solid.pose[:3, :3]) < np.cos(_FOLD)
        folded = turned | ~felt
        beyond = reached > reached[rows, first][:, None] + _BESIDE
        sharp[:, j] = met & (along < np.cos(_ASLANT)) & (beside[first] & (folded | beyond)).any(axis=1)
        propped[:, j] = met & (below < -_HIGHER).any(axis=1, where=felt)
        lean = np.arccos(np.clip(along, 0.0, 1.0))
        blocked = (below < -2.0).any(axis=1, where=felt)
        risk[:, j] = np.where(met, np.minimum(_UNSETTLED + _LEANING * lean + 0.4 * blocked, 0.9), 0.0)
    return Outcomes(frozen(hit, bool), frozen(depth), frozen(normal), frozen(gaps), frozen(risk),
                    frozen(sharp, bool), cell, frozen(propped, bool))  # fmt: skip


def _across(side: float, apart: float) -> Floats:
    """(n,) [mm] places along a side of the skin, its middle among them."""
    half = max(1, min(8, round(0.5 * _SKIN * side / apart)))
    return np.linspace(-0.5 * _SKIN * side, 0.5 * _SKIN * side, 2 * half + 1)

"""What no curved surface claimed: planes, one for each facet, and freeform where facets run on smoothly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.body import LabeledSurface
from models.recovery.curved import Region
from models.recovery.grow import Mesh
from primitives.arrays import Ints
from primitives.shapes import Plane


@dataclass(frozen=True)
class LeftoverOptions:
    """When facets are freeform."""

    smooth: float = np.deg2rad(32.0)  # [rad] the greatest turn within a freeform face
    alike: float = 20.0  # the greatest ratio of areas between its neighbors
    flat: float = (
        6.0  # a facet larger than this many middling ones, at the end of a freeform face, is a plane
    )
    fewest: int = 6  # facets; fewer are planes


def label_leftover(
    mesh: Mesh, regions: list[Region], flat: float, options: LeftoverOptions
) -> tuple[Ints, tuple[LabeledSurface, ...]]:
    """(f,) surface of each facet, and all surfaces."""
    n = len(mesh.flats)
    label = np.full(n, -1, dtype=np.int64)
    surfaces: list[LabeledSurface] = []
    for region in regions:
        label[region.facets] = len(surfaces)
        surfaces.append(LabeledSurface(region.shape, region.convex, -1))
    for group in _freeform(mesh, label, options):
        label[group] = len(surfaces)
        surfaces.append(LabeledSurface(None, True, -1))
    for f in np.flatnonzero((label < 0) & ~mesh.thin):
        label[f] = len(surfaces)
        surfaces.append(LabeledSurface(Plane(mesh.flats.center[f], mesh.flats.normal[f]), True, -1))
    _place_thin(mesh, label, surfaces, flat)
    used, label = np.unique(label, return_inverse=True)
    return label.reshape(-1), tuple(surfaces[i] for i in used)


def _freeform(mesh: Mesh, label: Ints, options: LeftoverOptions) -> list[Ints]:
    creases, area = mesh.creases, mesh.flats.area
    n = len(mesh.flats)
    first = np.repeat(np.arange(n), np.diff(creases.start))
    ratio = area[first] / area[creases.other]
    good = (label[first] < 0) & (label[creases.other] < 0) & (np.abs(creases.turn) < options.smooth)
    good &= (ratio < options.alike) & (ratio > 1 / options.alike)
    good &= ~mesh.thin[first] & ~mesh.thin[creases.other]
    graph = coo_array(
        (np.ones(int(good.sum()), dtype=bool), (first[good], creases.other[good])), shape=(n, n)
    )
    group = connected_components(graph, False)[1]
    links = np.bincount(first[good], minlength=n)
    out = []
    for g in np.flatnonzero(np.bincount(group) >= options.fewest):
        members = np.flatnonzero(group == g)
        ends = (links[members] < 2) & (area[members] > options.flat * np.median(area[members]))
        if (~ends).sum() >= options.fewest:
            out.append(members[~ends])
    return out


def _place_thin(mesh: Mesh, label: Ints, surfaces: list[LabeledSurface], flat: float) -> None:
    """Slivers join the neighbor on whose surface their corners are, or else the one they share most rim with."""
    creases, start = mesh.creases, mesh.flats.start
    waiting = [f for f in np.flatnonzero(label < 0).tolist()]
    while waiting:
        again: list[int] = []
        for f in waiting:
            rows = creases.around(f)
            known = [
                (float(n), int(label[g]))
                for g, n in zip(creases.other[rows], creases.length[rows], strict=True)
                if label[g] >= 0
            ]
            if not known:
                again.append(f)
                continue
            corners = mesh.vertices[mesh.flats.corners[start[f] : start[f + 1]]]

            def cost(item: tuple[float, int], corners=corners) -> tuple[float, float]:
                shape = surfaces[item[1]].shape
                away = flat if shape is None else float(np.abs(shape.signed_distance(corners)).max())
                return max(away, flat), -item[0]

            label[f] = min(known, key=cost)[1]
        if len(again) == len(waiting):
            for f in again:
                label[f] = len(surfaces)
                surfaces.append(LabeledSurface(None, True, -1))
            break
        waiting = again

"""What no curved surface claimed: planes, one for each facet, and freeform where facets run on smoothly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.body import LabeledSurface
from models.recovery.curved import Region, alike
from models.recovery.grow import Mesh
from primitives.arrays import Bools, Ints
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
    for group in freeform_groups(mesh, label, options):
        label[group] = len(surfaces)
        surfaces.append(LabeledSurface(None, True, -1))
    ledges = _ledges(mesh, regions, label)
    for f in np.flatnonzero((label < 0) & ~mesh.thin & ~ledges):
        label[f] = len(surfaces)
        surfaces.append(LabeledSurface(Plane(mesh.flats.center[f], mesh.flats.normal[f]), True, -1))
    _place_thin(mesh, label, surfaces, flat)
    used, label = np.unique(label, return_inverse=True)
    return label.reshape(-1), tuple(surfaces[i] for i in used)


def _ledges(mesh: Mesh, regions: list[Region], label: Ints) -> Bools:
    """(f,) leftover facets narrower than a chord of a neighbor is deep, with all corners that near to it.

    Where two facetted surfaces are tangent, or meet along different chords, their solids leave such steps.
    """
    creases, start = mesh.creases, mesh.flats.start
    first = np.repeat(np.arange(len(label)), np.diff(creases.start))
    width = 2 * mesh.flats.area / np.maximum(np.bincount(first, creases.length, len(label)), 1e-12)
    deepest = max((region.reach.corner for region in regions), default=0.0)
    out = np.zeros(len(label), dtype=bool)
    for f in np.flatnonzero((label < 0) & (width < deepest)).tolist():
        corners = mesh.vertices[mesh.flats.corners[start[f] : start[f + 1]]]
        beside = label[creases.other[creases.around(f)]]
        out[f] = any(
            width[f] < regions[s].reach.corner
            and float(np.abs(regions[s].shape.signed_distance(corners)).max()) < regions[s].reach.corner
            for s in set(beside[(beside >= 0) & (beside < len(regions))].tolist())
        )
    return out


def freeform_groups(mesh: Mesh, label: Ints, options: LeftoverOptions) -> list[Ints]:
    """Facets without a label that run on smoothly, one group for each face."""
    area, n = mesh.flats.area, len(mesh.flats)
    first, second = alike(mesh, options.alike, options.smooth)
    open_ = (label[first] < 0) & (label[second] < 0)
    first, second = first[open_], second[open_]
    graph = coo_array((np.ones(len(first), dtype=bool), (first, second)), shape=(n, n))
    group = connected_components(graph, False)[1]
    out = []
    for g in np.flatnonzero(np.bincount(group) >= options.fewest):
        members = np.flatnonzero(group == g)
        large = members[area[members] > options.flat * np.median(area[members])]
        ends = np.isin(members, [f for f in large.tolist() if _is_tangent(mesh, f, members, options.smooth)])
        if (~ends).sum() >= options.fewest:
            out.append(_with_narrow(mesh, members[~ends], label, options))
    return out


def _is_tangent(mesh: Mesh, facet: int, members: Ints, smooth: float) -> bool:
    """Whether a facet only touches one other, and that one turns away from it half as far as on its other side."""
    creases = mesh.creases
    inside = set(members.tolist())

    def turns(f: int) -> dict[int, float]:
        rows = creases.around(f)
        pairs = zip(creases.other[rows].tolist(), np.abs(creases.turn[rows]).tolist(), strict=True)
        return {g: turn for g, turn in pairs if g in inside and turn < smooth}

    mine = turns(facet)
    if len(mine) != 1:
        return False
    ((neighbor, turn),) = mine.items()
    beyond = [t for g, t in turns(neighbor).items() if g != facet]
    return bool(beyond) and turn < 0.75 * max(beyond)


def _with_narrow(mesh: Mesh, members: Ints, label: Ints, options: LeftoverOptions) -> Ints:
    """The members, and the leftover facets smaller than most that meet them smoothly round most of a rim."""
    inside = np.zeros(len(label), dtype=bool)
    inside[members] = True
    creases, area = mesh.creases, mesh.flats.area
    first = np.repeat(np.arange(len(label)), np.diff(creases.start))
    rim = np.bincount(first, creases.length, len(label))
    narrow = (label < 0) & (area < np.median(area[members]))
    while True:
        shared = inside[creases.other] & (np.abs(creases.turn) < options.smooth)
        joins = narrow & ~inside & (np.bincount(first, creases.length * shared, len(label)) > 0.6 * rim)
        if not joins.any():
            return np.flatnonzero(inside)
        inside |= joins


def _place_thin(mesh: Mesh, label: Ints, surfaces: list[LabeledSurface], flat: float) -> None:
    """Slivers and ledges join the neighbor on whose surface their corners are, or else that of the longest rim."""
    creases, start = mesh.creases, mesh.flats.start
    waiting = np.flatnonzero(label < 0).tolist()
    while waiting:
        again: list[int] = []
        for f in waiting:
            rows = creases.around(f)
            beside = label[creases.other[rows]]
            if (beside < 0).all():
                again.append(f)
                continue
            corners = mesh.vertices[mesh.flats.corners[start[f] : start[f + 1]]]
            costs = []
            for s, shared in zip(beside.tolist(), creases.length[rows].tolist(), strict=True):
                shape = surfaces[s].shape if s >= 0 else None
                away = flat if shape is None else float(np.abs(shape.signed_distance(corners)).max())
                costs.append((max(away, flat) if s >= 0 else np.inf, -shared, s))
            label[f] = min(costs)[2]
        if len(again) == len(waiting):
            label[again] = len(surfaces)
            surfaces.append(LabeledSurface(None, True, -1))
            return
        waiting = again

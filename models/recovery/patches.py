"""Patches of facets round a seed, from which a surface is guessed."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

import numpy as np

from models.recovery.curved_options import CurvedOptions
from models.recovery.fits import corners_of
from models.recovery.grow import Mesh
from primitives.arrays import Bools, Ints
from primitives.pose import frame_along

_ROUGH = 12.0  # corner noises that the corners' root mean square may be off
_BENT = 0.05  # of the height of a patch, by which it may depart from a quadric


def patches(
    mesh: Mesh, seed: int, free: Bools, noise: float, options: CurvedOptions
) -> Iterator[tuple[Ints, float, float]]:
    """Patches round a seed, each with the greatest turn in it [rad] and its typical sag [mm], the best first.

    Where facets are fine a dozen of them bend too little to tell a shape, and as many as bend enough come first.
    The last goes over the longest rims: the sides of a bar have long ones with each other and short ones with the
    bend that they run into.
    """
    patch, turn, sag = patch_round(mesh, seed, free, options.patches[0], options)
    span = _span(mesh, patch)
    if len(patch) == options.patches[0] and span < options.span:
        count = min(int(len(patch) * (options.span / max(span, 1e-6)) ** 2), options.largest)
        larger = patch_round(mesh, seed, free, count, options)
        if _smooth(mesh, larger[0], noise):
            yield larger
    yield patch, turn, sag
    for count in options.patches[1:]:
        yield patch_round(mesh, seed, free, count, options)
    patch = _patch_along(mesh, seed, free, options)
    inside = np.zeros(len(free), dtype=bool)
    inside[patch] = True
    yield patch_round(mesh, seed, inside, len(patch), options)


def patch_round(
    mesh: Mesh, seed: int, free: Bools, count: int, options: CurvedOptions
) -> tuple[Ints, float, float]:
    """The nearest free facets of like size, the greatest turn among them [rad] and their typical sag [mm]."""
    creases, area = mesh.creases, mesh.flats.area
    patch, turns, sags = [seed], [0.0], [0.0]
    inside = {seed}
    for f in patch:
        for i in range(*creases.around(f).indices(len(creases.other))):
            g, turn = int(creases.other[i]), abs(float(creases.turn[i]))
            if turn > options.smooth or not free[g] or mesh.thin[g]:
                continue
            if g in inside:
                turns.append(turn)
                sags.append(turn * min(area[f], area[g]) / max(float(creases.length[i]), 1e-12) / 8)
            elif len(patch) < count and 1 / options.alike < area[g] / area[f] < options.alike:
                patch.append(g)
                inside.add(g)
                turns.append(turn)
    return np.array(patch), max(turns), float(np.quantile(sags, 0.8))


def _smooth(mesh: Mesh, patch: Ints, noise: float) -> bool:
    """Whether corners lie on a quadric over the plane of a patch as well as those of a shape have to.

    A circle departs from a parabola by (a / 2)^2 of its height over an angle a to either side: little here.
    """
    normal = mesh.flats.normal[patch].sum(axis=0)
    frame = frame_along(normal / np.linalg.norm(normal))
    x, y, z = ((mesh.vertices[corners_of(mesh, patch)] - mesh.flats.center[patch[0]]) @ frame).T
    size = max(float(np.hypot(x, y).max()), 1e-12)
    x, y = x / size, y / size
    rows = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    left = z - rows @ np.linalg.lstsq(rows, z, rcond=None)[0]
    return bool(np.sqrt((left**2).mean()) < _ROUGH * noise + _BENT * np.ptp(z))


def _span(mesh: Mesh, patch: Ints) -> float:
    """[rad] by which normals of a patch turn from that of its seed, at most."""
    normals = mesh.flats.normal[patch]
    return float(np.arccos(np.clip((normals @ normals[0]).min(), -1.0, 1.0)))


def _patch_along(mesh: Mesh, seed: int, free: Bools, options: CurvedOptions) -> Ints:
    """Facets gathered over the longest rim of all that are gathered."""
    creases, area = mesh.creases, mesh.flats.area
    patch: list[int] = []
    waiting = [(0.0, seed)]
    while waiting and len(patch) < options.along:
        f = heapq.heappop(waiting)[1]
        if f in patch:
            continue
        patch.append(f)
        for i in range(*creases.around(f).indices(len(creases.other))):
            g = int(creases.other[i])
            alike = 1 / options.alike < area[g] / area[f] < options.alike
            if abs(float(creases.turn[i])) <= options.smooth and free[g] and not mesh.thin[g] and alike:
                heapq.heappush(waiting, (-float(creases.length[i]), g))
    return np.array(patch)

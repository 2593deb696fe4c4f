"""Patches of facets round a seed, from which a surface is guessed."""

from __future__ import annotations

import heapq
from collections.abc import Iterator

import numpy as np

from models.recovery.curved_options import CurvedOptions
from models.recovery.grow import Mesh
from primitives.arrays import Bools, Ints


def patches(
    mesh: Mesh, seed: int, free: Bools, options: CurvedOptions
) -> Iterator[tuple[Ints, float, float]]:
    """Patches round a seed, each with the greatest turn in it [rad] and its typical sag [mm], the best first.

    The last goes over the longest rims: the sides of a bar have long ones with each other and short ones with the
    bend that they run into.
    """
    for count in options.patches:
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
    for f in patch:
        for i in range(*creases.around(f).indices(len(creases.other))):
            g, turn = int(creases.other[i]), abs(float(creases.turn[i]))
            if turn > options.smooth or not free[g] or mesh.thin[g]:
                continue
            if g in patch:
                turns.append(turn)
                sags.append(turn * min(area[f], area[g]) / max(float(creases.length[i]), 1e-12) / 8)
            elif len(patch) < count and 1 / options.alike < area[g] / area[f] < options.alike:
                patch.append(g)
                turns.append(turn)
    return np.array(patch), max(turns), float(np.quantile(sags, 0.8))


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

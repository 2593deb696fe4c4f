"""Where what joins the pieces of a draft may be: between two surfaces of different pieces that face each other.

An object hangs together.  Where its draft does not, as a wheel of which rim and hub were felt and no spoke, the
places on straight ways between the pieces are worth a touch, across those ways.  The ways between a rim and a hub
fill a plane, and what joins them is come at from its two sides; those between two flanges are along one line, and
it is come at from all round.  From each side the places are put on one plane amid them (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial import KDTree

from exploration.planning.open.frontier import Predicted
from models.solid import Solid
from primitives.arrays import Floats

NOWHERE = Predicted(np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=np.int64))


@dataclass(frozen=True)
class BridgingConfig:
    """Which ways are taken."""

    spacing: float = 3.0  # [mm] between the places
    samples: int = 1500  # on each piece
    widest: float = 60.0  # [mm] between two pieces
    facing: float = 0.7  # least cosine between a way and the normals at its ends
    ends: float = 0.2  # of a way, at either end, that is left out
    least: float = 6.0  # [mm] of it, that an array has room in
    across: float = 0.15  # mean squared cosine with the ways, up to which a direction is across them


def bridging(solid: Solid, config: BridgingConfig = BridgingConfig()) -> Predicted:
    """Places between the pieces of a solid, in an order that spreads them; none where it is in one piece."""
    mesh = trimesh.Trimesh(solid.vertices, solid.triangles, process=False)
    pieces = [_sampled(piece, config) for piece in mesh.split(only_watertight=False)]
    found = [
        _between(one, other, config)
        for k, one in enumerate(pieces)
        for other in (pieces[:k] + pieces[k + 1 :])
    ]
    places = np.concatenate([np.empty((0, 3)), *(there for there, _ in found)])
    if len(places) < 3:
        return NOWHERE
    middle, sides = places.mean(axis=0), list[tuple[Floats, Floats]]()
    for normal in _across(places, np.concatenate([ways for _, ways in found]), config):
        flat = places - np.outer((places - middle) @ normal, normal)
        _, first = np.unique(np.round(flat / config.spacing), axis=0, return_index=True)
        sides += [(flat[first], normal), (flat[first], -normal)]
    points = np.concatenate([flat for flat, _ in sides])
    normals = np.concatenate([np.tile(normal, (len(flat), 1)) for flat, normal in sides])
    order = np.random.default_rng(0).permutation(len(points))
    return Predicted(points[order], normals[order], np.zeros(len(points), dtype=np.int64))


def _across(places: Floats, ways: Floats, config: BridgingConfig) -> Floats:
    """(k, 3) unit directions across (n, 3) ways: one if they fill a plane, two if they are along one line.

    These two are the ones along which the (n, 3) places spread most and least.
    """
    shares, axes = np.linalg.eigh(ways.T @ ways / len(ways))
    free = axes[:, : max(1, int((shares < config.across).sum()))]
    turn = np.linalg.svd((places - places.mean(axis=0)) @ free, full_matrices=False)[2]
    return np.asarray(turn @ free.T)


def _sampled(piece: trimesh.Trimesh, config: BridgingConfig) -> tuple[Floats, Floats]:
    """(n, 3) places on a piece, and (n, 3) outward normals."""
    points, triangle = trimesh.sample.sample_surface(piece, config.samples, seed=0)
    return np.asarray(points), np.asarray(piece.face_normals)[triangle]


def _between(
    one: tuple[Floats, Floats], other: tuple[Floats, Floats], config: BridgingConfig
) -> tuple[Floats, Floats]:
    """(n, 3) places on straight ways from one piece to the nearest of another, and (n, 3) these unit ways."""
    (points, normals), (there, facing) = one, other
    nearest = np.asarray(KDTree(there).query(points)[1])
    away = np.linalg.norm(there[nearest] - points, axis=1)
    way = (there[nearest] - points) / np.maximum(away, 1e-9)[:, None]
    good = (away > config.least) & (away < config.widest)
    good &= (way * normals).sum(axis=1) > config.facing
    good &= -(way * facing[nearest]).sum(axis=1) > config.facing
    out, ways = [np.empty((0, 3))], [np.empty((0, 3))]
    for k in np.flatnonzero(good):
        along = np.arange(config.ends * away[k], (1.0 - config.ends) * away[k], config.spacing)
        out.append(points[k] + np.outer(along, way[k]))
        ways.append(np.tile(way[k], (len(along), 1)))
    return np.concatenate(out), np.concatenate(ways)

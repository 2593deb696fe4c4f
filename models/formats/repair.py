"""Triangles made to close and split into bodies: a line for all that was mended, or one for what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.boundaries.stitch import stitched
from models.boundaries.topology import open_edges, wound
from models.formats.folds import unfolded
from models.formats.holes import filled
from models.formats.labeled import LabeledMesh
from models.formats.shells import bodies
from models.formats.weld import equal_rows, renumbered, welded
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError


@dataclass(frozen=True)
class RepairConfig:
    """What may be mended; lengths are shares of the longest side."""

    grids: tuple[float, ...] = (0.0, 1e-6, 1e-5)  # corners closer than this are one, tried in turn
    stitch: float = 1e-5  # a corner this near an open edge lies on it
    fill_holes: bool = True
    most_shells: int = 1000


def closed(found: LabeledMesh, name: str, config: RepairConfig) -> tuple[list[LabeledMesh], list[str]]:
    """The bodies in a mesh, closed and their normals out, and what was done."""
    said: list[str] = []
    points, corners, source = _connected(found, name, config)
    single = _without_doubles(corners)
    if len(single) < len(corners):
        said.append(f"{name} had {len(corners) - len(single)} doubled triangles; they were left out")
        corners, source = corners[single], source[single]
    if not len(corners):
        raise PalpateError(
            f"{name} is folded flat: it has every triangle both ways round; export it as a solid"
        )
    if len(corners) < 4:
        count = f"{len(corners)} triangle" + "s" * (len(corners) != 1)
        raise PalpateError(f"{name} has only {count}, which enclose nothing; export it as a solid")
    corners, turned = wound(points, corners)
    if (missing := open_edges(corners)) > 0:
        patch, holes = filled(points, corners) if config.fill_holes else (np.empty((0, 3), np.int64), 0)
        if not len(patch) or open_edges(np.concatenate([corners, patch])):
            cure = (
                "repair it in a mesh editor first"
                if config.fill_holes
                else "sew its faces into a solid first"
            )
            raise PalpateError(f"{name} is not closed: {missing} open edges; {cure}")
        said.append(f"{name} had {_count(holes, 'hole')} with {missing} open edges; flat pieces fill them")
        corners = np.concatenate([corners, patch])
        source = np.concatenate([source, np.full(len(patch), -1)])
        corners, _ = wound(points, corners)
    elif config.fill_holes:
        corners, kept, faces = unfolded(points, corners)
        source = np.where(kept < 0, -1, source[kept])
        if faces:
            said.append(f"{name} had {_count(faces, 'flat face')} folded over themselves; cut anew")
    parts = bodies(points, corners, config.most_shells)
    if not parts:
        raise PalpateError(f"{name} is in more than {config.most_shells} pieces; export one solid")
    if turned or parts.turned:
        said.append(f"{name} had triangles that faced inward; they were turned")
    if parts.doubled:
        said.append(f"{name} had {_count(parts.doubled, 'shell')} inside its material; left out")
    pieces = zip(parts.triangles, parts.rows, strict=True)
    return [found.with_triangles(points, triangles, source[rows]) for triangles, rows in pieces], said


def _connected(found: LabeledMesh, name: str, config: RepairConfig) -> tuple[Floats, Ints, Ints]:
    size = float(np.ptp(found.vertices[renumbered(found.triangles)[0]], axis=0).max())
    for grid in config.grids:
        points, corners, source = welded(found.vertices, found.triangles, grid * size)
        a, b, c = np.moveaxis(points[corners], 1, 0)
        if not np.linalg.norm(np.cross(b - a, c - a), axis=1).any():
            raise PalpateError(f"{name} has only triangles without area; export it again")
        if open_edges(corners) == 0:
            return points, corners, source
    corners, cut = stitched(points, corners, config.stitch * size)
    return points, corners, source[cut]


def _without_doubles(corners: Ints) -> Ints:
    """Rows of one triangle of each that is there more than once, and of none that is there both ways round."""
    key = np.sort(corners, axis=1)
    after_least = (np.argmin(corners, axis=1) + 1) % 3
    turn = corners[np.arange(len(key)), after_least] == key[:, 1]
    first, same = equal_rows(key)
    if len(first) == len(corners):
        return np.arange(len(corners))
    net = np.bincount(same, weights=np.where(turn, 1.0, -1.0))
    return np.sort(first[net != 0])


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'s' * (number != 1)}"

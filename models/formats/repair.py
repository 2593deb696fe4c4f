"""Triangles made to close, with a line for all that was changed, or one line that says what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.formats.labeled import LabeledMesh
from models.formats.weld import welded
from models.stitch import stitched
from models.topology import open_edges, wound
from primitives.errors import PalpateError


@dataclass(frozen=True)
class RepairConfig:
    """What may be mended; lengths are shares of the longest side."""

    grids: tuple[float, ...] = (0.0, 1e-6, 1e-5)  # corners closer than this are one, tried in turn
    stitch: float = 1e-5  # a corner this near an open edge lies on it
    fill_holes: bool = True


def closed(found: LabeledMesh, name: str, config: RepairConfig) -> tuple[LabeledMesh, list[str]]:
    """The mesh closed and its normals out, and what was done."""
    said: list[str] = []
    size = float(np.ptp(found.vertices[np.unique(found.triangles)], axis=0).max())
    for grid in config.grids:
        points, corners, source = welded(found.vertices, found.triangles, grid * size)
        a, b, c = np.moveaxis(points[corners], 1, 0)
        if not np.linalg.norm(np.cross(b - a, c - a), axis=1).any():
            raise PalpateError(f"{name} has only triangles without area; export it again")
        if open_edges(corners) == 0:
            break
    if open_edges(corners) > 0:
        corners, cut = stitched(points, corners, config.stitch * size)
        source = source[cut]
    if len(corners) < 4:
        count = f"{len(corners)} triangle" + "s" * (len(corners) > 1)
        raise PalpateError(f"{name} has only {count}, which enclose nothing; export it as a solid")
    corners, turned = wound(points, corners)
    if (missing := open_edges(corners)) > 0:
        raise PalpateError(f"{name} is not closed: {missing} open edges; repair it in a mesh editor first")
    if turned:
        said.append(f"{name} had triangles that faced inward; they were turned")
    return found.with_triangles(points, corners, source), said

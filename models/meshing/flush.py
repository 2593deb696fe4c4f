"""Where the primitives of a tree are meshed, so that faces that are meant to touch do touch.

Two boxes of which one stands on the other share a plane to the last digit only where no rounding comes
between: 5 mm + 10 mm / 2 need not be 10 mm once all of it is scaled by 0.7, and a file of six digits puts such
faces up to five millionths of the part's size apart.  A boolean then leaves two bodies, or a slit.  So
primitives are meshed in a frame in which as many as can be stand straight: that of most leaves, or one of its
own for a group that is turned out of it.  There a flat face across an axis is one number; numbers that lie
`together` become one, and so do the coordinates of all vertices near it (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from models.csg import Csg, Operation, Placed, Primitive
from models.meshing.flat_facets import Facets
from primitives.arrays import Floats
from primitives.pose import pose, rotate, transform_points


@dataclass(frozen=True)
class FlushConfig:
    """When numbers are meant to be the same."""

    straight: float = 1e-9  # [1] an entry of a rotation from 0 or 1
    together: float = 5e-6  # [1] of the part's size, that faces on one plane may lie apart


_CONFIG = FlushConfig()


def common_frame(tree: Csg) -> Floats:
    """(4, 4) turn of the frame in which the most leaves stand straight; the identity where none is better."""
    turns = [leaf.part_from_primitive[:3, :3] for leaf in tree.leaves()]
    best, most, tried = np.eye(3), _straight_in(np.eye(3), turns), [np.eye(3)]
    for turn in turns:
        if most < len(turns) and not _straight_in(turn, tried):
            tried.append(turn)
            count = _straight_in(turn, turns)
            if count > max(most, 1):
                best, most = turn, count
    return pose(best)


def below(placed: Placed, frame_from_parent: Floats) -> tuple[Floats, Floats | None]:
    """The (4, 4) pose of what is placed, in its frame; that frame's in the one above, None for the same."""
    moved = frame_from_parent @ placed.pose
    turn = np.round(moved[:3, :3])
    if np.abs(turn - moved[:3, :3]).max() <= _CONFIG.straight:
        return pose(turn, moved[:3, 3]), None
    return (moved, None) if isinstance(placed.child, Primitive) else (np.eye(4), moved)


def leaf_poses(tree: Csg, frame_from_tree: Floats) -> Iterator[Floats]:
    """(4, 4) frame_from_primitive of every leaf, in the order of the leaves."""
    if isinstance(tree, Placed):
        yield from leaf_poses(tree.child, below(tree, frame_from_tree)[0])
    elif isinstance(tree, Operation):
        for child in tree.children:
            yield from leaf_poses(child, frame_from_tree)
    else:
        yield frame_from_tree


def flush(meshes: Sequence[Facets], poses: Sequence[Floats]) -> list[Floats]:
    """(v, 3) vertices of each mesh in its frame, where what is meant to lie on one plane does."""
    placed = [transform_points(p, mesh.vertices) for p, mesh in zip(poses, meshes, strict=True)]
    close = _CONFIG.together * max(float(np.ptp(vertices, axis=0).max()) for vertices in placed)
    for axis in range(3):
        levels = [_levels(mesh, p, axis) for p, mesh in zip(poses, meshes, strict=True)]
        together = _groups(np.sort(np.concatenate(levels)), close)
        if len(together):
            for vertices in placed:
                vertices[:, axis] = _snapped(vertices[:, axis], together, close)
    return placed


def _straight_in(frame: Floats, turns: Sequence[Floats]) -> int:
    """How many (3, 3) turns are by right angles only, seen from that of a frame."""
    seen = np.stack([frame.T @ turn for turn in turns])
    return int((np.abs(np.round(seen) - seen).max(axis=(1, 2)) <= _CONFIG.straight).sum())


def _levels(mesh: Facets, placement: Floats, axis: int) -> Floats:
    """(k,) coordinates of the flat faces across an axis."""
    flat = [shape for shape in mesh.surfaces if shape is not None and shape.kind == "plane"]
    if not flat:
        return np.empty(0)
    normals = np.delete(rotate(placement, np.stack([shape.direction for shape in flat])), axis, axis=1)
    points = transform_points(placement, np.stack([shape.anchor for shape in flat]))
    across: Floats = points[np.abs(normals).max(axis=1) <= _CONFIG.straight, axis]
    return across


def _groups(levels: Floats, close: float) -> Floats:
    """(g, 2) least and greatest of each run of sorted numbers that lie together."""
    if not len(levels):
        return np.empty((0, 2))
    cut = np.flatnonzero(np.diff(levels) > close)
    return np.stack([levels[np.r_[0, cut + 1]], levels[np.r_[cut, len(levels) - 1]]], axis=1)


def _snapped(values: Floats, groups: Floats, close: float) -> Floats:
    """Numbers in or beside a group put on its least."""
    before = np.clip(np.searchsorted(groups[:, 0], values + close, side="right") - 1, 0, None)
    low, high = groups[before].T
    inside = (values >= low - close) & (values <= high + close)
    moved: Floats = np.where(inside, low, values)
    return moved

"""Planes gathered three pairs at a time, parallel and perpendicular, into boxes (greedy set cover)."""

from __future__ import annotations

import numpy as np

from models.csg import Cube
from primitives.arrays import Floats, frozen
from primitives.pose import frame_along, pose
from primitives.shapes import Plane
from recognition.assembly.piece import EXACT, Piece, span


def cover(
    planes: dict[int, Plane], area: Floats, hints: list[Floats]
) -> list[tuple[Floats, tuple[int, ...]]]:
    """Orthogonal frames and the planes that each takes, as few as a greedy choice finds."""
    left, out = dict(planes), []
    while left:
        frames = list(_frames(left, hints))
        scored = []
        for frame in frames:
            members = _members(frame, left)
            scored.append((len(members), round(float(area[list(members)].sum()), 6), frame, members))
        best = max(range(len(scored)), key=lambda k: (scored[k][0], scored[k][1], -k))
        frame, members = scored[best][2:]
        out.append((frame, members))
        hints = [*hints, *frame.T]
        left = {i: p for i, p in left.items() if i not in members}
    return out


def _frames(planes: dict[int, Plane], hints: list[Floats]) -> list[Floats]:
    """Right-handed frames along pairs of perpendicular normals, then along one normal and a hint."""
    normals = [p.normal for p in planes.values()]
    pairs = [(a, b) for i, a in enumerate(normals) for b in normals[i + 1 :]]
    pairs += [(a, b) for a in normals for b in hints]
    frames = [frame_along(a, b) for a, b in pairs if abs(float(a @ b)) < EXACT]
    return frames + [frame_along(a) for a in normals]


def _members(frame: Floats, planes: dict[int, Plane]) -> tuple[int, ...]:
    """The planes along the frame's axes, one to each side."""
    sides: dict[tuple[int, bool], int] = {}
    for i, plane in planes.items():
        along = plane.normal @ frame
        axis = int(np.argmax(np.abs(along)))
        if np.linalg.norm(np.delete(along, axis)) < EXACT:
            sides.setdefault((axis, bool(along[axis] > 0)), i)
    return tuple(sorted(sides.values()))


def cube(frame: Floats, planes: dict[int, Plane], corners: Floats) -> Piece:
    """The box along a frame's columns between planes that look out of it, open where there is none."""
    turn = _least_turned(frame)
    origin = corners.mean(axis=0)
    spans, ends = [], []
    for axis in turn.T:
        pair: list[int | None] = [None, None]
        for i, plane in planes.items():
            along = float(plane.normal @ axis)
            if abs(along) > 0.5:
                pair[int(along > 0)] = i
        spans.append(span(origin, axis, [None if i is None else planes[i] for i in pair], corners))
        ends.append((pair[0], pair[1]))
    low, high = np.array(spans).T
    size = high - low
    middle = origin + turn @ (0.5 * (low + high))
    solid = Cube((float(size[0]), float(size[1]), float(size[2])))
    return Piece("cube", "intersect", solid, frozen(pose(turn, middle)), None, tuple(ends))


def _least_turned(frame: Floats) -> Floats:
    """Of the 24 right-handed namings of the same axes, the one that is nearest the world's."""
    best, turned = -np.inf, frame
    for order in ([0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]):
        picked = frame[:, order]
        signed = picked * np.where(np.diag(picked) < 0, -1.0, 1.0)
        if np.linalg.det(signed) < 0:
            weakest = int(np.argmin(np.abs(np.diag(signed))))
            signed[:, weakest] *= -1.0
        score = float(np.trace(signed))
        if score > best + 1e-9:
            best, turned = score, signed
    return turned

"""Named primitives that a person would have written for convex surfaces, each with what it was made from.

A round surface takes the planes across its axis as its ends; other planes are gathered three pairs at a
time, where they are parallel and perpendicular, into cubes (greedy set cover).  A side that no surface closes
reaches past the rest of the body to the next round number: the rest of the intersection cuts it off.  A round
surface with the material outside (a hole) reaches past the body at both ends, and is subtracted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from models.csg import Cone as ConeSolid
from models.csg import Csg, Cube
from models.csg import Cylinder as CylinderSolid
from models.csg import Sphere as SphereSolid
from primitives.arrays import Floats, frozen
from primitives.pose import frame_along, pose, rotation_exp
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere

_EXACT = 1e-6  # [rad] directions that were made equal agree within this
_PAST = 1.0  # [mm] at least, by which an open side reaches past the body
_ROUND = 1.0  # [mm] open sides end at a multiple of this


@dataclass(frozen=True)
class Piece:
    """One primitive, and which surface made each of its sides."""

    kind: str  # "cube", "cylinder", "cone", "sphere", "torus" or "polyhedron"
    operation: str  # "intersect" or "add", or "subtract" for a hole
    solid: Csg  # centered, axis along z
    world_from_piece: Floats  # (4, 4)
    body: int | None  # the round surface, if there is one
    ends: tuple[
        tuple[int | None, int | None], ...
    ]  # per axis (three, or z alone) the surfaces below and above

    @property
    def surfaces(self) -> tuple[int, ...]:
        """All that made it."""
        sides = [s for pair in self.ends for s in pair if s is not None]
        return tuple(sides if self.body is None else [self.body, *sides])

    @property
    def placed(self) -> Csg:
        """In the world."""
        return self.solid.placed(self.world_from_piece)


def pieces(
    shapes: Sequence[Shape], convex: Sequence[bool], area: Floats, corners: Floats
) -> tuple[Piece, ...]:
    """For surfaces with their `area` on the body [mm^2], whose polyhedron has (n, 3) `corners`; best first."""
    planes: dict[int, Plane] = {i: s for i, s in enumerate(shapes) if isinstance(s, Plane)}
    rounds: dict[int, Shape] = {i: s for i, s in enumerate(shapes) if not isinstance(s, Plane)}
    caps = _caps({i: s for i, s in rounds.items() if convex[i]}, planes)
    out: list[Piece] = []
    for i, shape in rounds.items():
        below, above = caps.get((i, -1)), caps.get((i, 1))
        ends = [None if k is None else planes[k] for k in (below, above)]
        if isinstance(shape, Sphere):
            ball = SphereSolid(shape.radius)
            out.append(Piece("sphere", "intersect", ball, pose(None, shape.center), i, ()))
        elif isinstance(shape, Cylinder):
            out.append(_cylinder(i, shape, (below, above), ends, corners))
        elif isinstance(shape, Cone):
            out.append(_cone(i, shape, (below, above), ends, corners))
    left = {i: p for i, p in planes.items() if i not in caps.values()}
    hints = [s.direction for i, s in enumerate(shapes) if i not in left and s.tilts]
    for frame, members in _cover(left, area, hints):
        out.append(_cube(frame, {i: left[i] for i in members}, corners))
    out = [p if p.body is None or convex[p.body] else replace(p, operation="subtract") for p in out]
    order = sorted(range(len(out)), key=lambda k: (out[k].operation == "subtract", -len(out[k].surfaces), k))
    return tuple(out[k] for k in order)


def round_piece(
    body: int, shape: Shape, slab: tuple[int | None, int | None], shapes: Sequence[Shape], corners: Floats
) -> Piece:
    """A cylinder or cone between the planes of a slab, which is told along the shape's own axis."""
    ends = [_plane(shapes, k) for k in slab]
    if isinstance(shape, Cylinder):
        return _cylinder(body, shape, slab, ends, corners)
    assert isinstance(shape, Cone)
    return _cone(body, shape, slab, ends, corners)


def slab_cube(
    frame: Floats, slabs: Sequence[tuple[int | None, int | None]], shapes: Sequence[Shape], corners: Floats
) -> Piece:
    """A box of three slabs along the columns of a frame, its planes turned to look out of it."""
    planes: dict[int, Plane] = {}
    for axis, slab in zip(frame.T, slabs, strict=True):
        for k, outward in zip(slab, (-axis, axis), strict=True):
            if (plane := _plane(shapes, k)) is not None and k is not None:
                planes[k] = Plane(plane.origin, plane.normal if plane.normal @ outward > 0 else -plane.normal)
    right = frame if np.linalg.det(frame) > 0 else frame * np.array([1.0, 1.0, -1.0])
    return _cube(right, planes, corners)


def _plane(shapes: Sequence[Shape], k: int | None) -> Plane | None:
    shape = None if k is None else shapes[k]
    return shape if isinstance(shape, Plane) else None


def _caps(rounds: dict[int, Shape], planes: dict[int, Plane]) -> dict[tuple[int, int], int]:
    """(round surface, end along its axis: -1 or 1) -> the plane across it, each plane used once."""
    out: dict[tuple[int, int], int] = {}
    for k, plane in planes.items():
        best: tuple[float, int, int] | None = None
        for i, shape in rounds.items():
            if not shape.tilts or np.linalg.norm(np.cross(plane.normal, shape.direction)) > _EXACT:
                continue
            end = 1 if plane.normal @ shape.direction > 0 else -1
            width = _radius_at(shape, plane)
            if (i, end) not in out and (best is None or width < best[0]):
                best = (width, i, end)
        if best is not None:
            out[best[1], best[2]] = k
    return out


def _radius_at(shape: Shape, plane: Plane) -> float:
    if isinstance(shape, Cone):
        height = float((plane.origin - shape.apex) @ shape.axis)
        return height * float(np.tan(shape.semi_angle))
    return shape.radius if isinstance(shape, Cylinder) else np.inf


def _span(origin: Floats, axis: Floats, ends: Sequence[Plane | None], corners: Floats) -> tuple[float, float]:
    """Where a piece begins and ends along an axis through a point; open ends are past the corners, rounded."""
    along = (corners - origin) @ axis
    low, high = (float((e.origin - origin) @ axis) if e is not None else None for e in ends)
    if low is None and high is None:
        middle = 0.5 * float(along.min() + along.max())
        half = 0.5 * _round_up(float(np.ptp(along)) + 2 * _PAST)
        return middle - half, middle + half
    if high is None and low is not None:
        return low, low + _round_up(float(along.max()) - low + _PAST)
    if low is None and high is not None:
        return high - _round_up(high - float(along.min()) + _PAST), high
    assert low is not None
    assert high is not None
    return low, high


def _round_up(length: float) -> float:
    return float(np.ceil(length / _ROUND) * _ROUND)


def _upright(axis: Floats) -> Floats:
    """The least (3, 3) rotation that takes z to the axis."""
    across = np.cross([0.0, 0.0, 1.0], axis)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.eye(3) if axis[2] > 0 else rotation_exp([np.pi, 0.0, 0.0])
    return rotation_exp(across / sine * np.arctan2(sine, axis[2]))


def _along(origin: Floats, axis: Floats, low: float, high: float) -> Floats:
    return pose(_upright(axis), origin + 0.5 * (low + high) * axis)


def _cylinder(
    i: int,
    shape: Cylinder,
    indices: tuple[int | None, int | None],
    ends: list[Plane | None],
    corners: Floats,
) -> Piece:
    axis = shape.axis
    if axis[np.argmax(np.abs(axis))] < 0:
        axis, indices, ends = -axis, (indices[1], indices[0]), [ends[1], ends[0]]
    low, high = _span(shape.origin, axis, ends, corners)
    solid = CylinderSolid(shape.radius, high - low)
    return Piece("cylinder", "intersect", solid, _along(shape.origin, axis, low, high), i, (indices,))


def _cone(
    i: int,
    shape: Cone,
    indices: tuple[int | None, int | None],
    ends: list[Plane | None],
    corners: Floats,
) -> Piece:
    """Its bottom is the wide end, and it closes at the apex where no plane cuts that off."""
    near, far = _span(shape.apex, shape.axis, ends, corners)
    near = max(near, 0.0) if ends[0] is not None else 0.0
    slope = float(np.tan(shape.semi_angle))
    solid = ConeSolid(far * slope, near * slope, far - near)
    return Piece(
        "cone",
        "intersect",
        solid,
        _along(shape.apex, -shape.axis, -far, -near),
        i,
        ((indices[1], indices[0]),),
    )


def _cover(
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
    frames = [frame_along(a, b) for a, b in pairs if abs(float(a @ b)) < _EXACT]
    return frames + [frame_along(a) for a in normals]


def _members(frame: Floats, planes: dict[int, Plane]) -> tuple[int, ...]:
    """The planes along the frame's axes, one to each side."""
    sides: dict[tuple[int, bool], int] = {}
    for i, plane in planes.items():
        along = plane.normal @ frame
        axis = int(np.argmax(np.abs(along)))
        if np.linalg.norm(np.delete(along, axis)) < _EXACT:
            sides.setdefault((axis, bool(along[axis] > 0)), i)
    return tuple(sorted(sides.values()))


def _cube(frame: Floats, planes: dict[int, Plane], corners: Floats) -> Piece:
    turn = _least_turned(frame)
    origin = corners.mean(axis=0)
    spans, ends = [], []
    for axis in turn.T:
        pair: list[int | None] = [None, None]
        for i, plane in planes.items():
            along = float(plane.normal @ axis)
            if abs(along) > 0.5:
                pair[int(along > 0)] = i
        spans.append(_span(origin, axis, [None if i is None else planes[i] for i in pair], corners))
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

"""Named primitives that a person would have written for convex surfaces, each with what it was made from.

A round surface takes the planes across its axis as its ends; other planes become boxes, or one prism and boxes
where one box does not take them all. A side that no surface closes reaches past the rest of the body to the next
round number: the rest of the intersection cuts it off. A round surface with the material outside (a hole) reaches
past the body at both ends, and is subtracted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from models.csg import Cone as ConeSolid
from models.csg import Cylinder as CylinderSolid
from models.csg import Prism
from models.csg import Sphere as SphereSolid
from models.csg import Torus as TorusSolid
from primitives.arrays import Floats
from primitives.pose import pose
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus
from recognition.assembly.boxes import cover, cube
from recognition.assembly.piece import EXACT, Piece, along, span
from recognition.assembly.prisms import prism

_SECTOR = 1.5  # of a ring's size, that the sector which leaves a bend of it reaches: chords stay outside


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
    if len(cover(left, area, hints)) > 1 and (found := prism(left, hints, corners)) is not None:
        out.append(found[0])
        left = {i: p for i, p in left.items() if i not in found[1]}
    for frame, members in cover(left, area, hints):
        out.append(cube(frame, {i: left[i] for i in members}, corners))
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


def ring_piece(body: int, shape: Torus, sides: Sequence[Plane]) -> Piece:
    """A ring, or the bend of it inside one or two planes through its axis."""
    ring = TorusSolid(shape.radius, shape.minor_radius)
    world_from_ring = pose(shape.frame, shape.center)
    solid = ring & _sector(shape, [side.normal @ shape.frame[:, :2] for side in sides]) if sides else ring
    return Piece("torus", "add", solid, world_from_ring, body, ())


def _sector(shape: Torus, outward: Sequence[Floats]) -> Prism:
    """What lies inside one or two lines through a ring's middle, from their (2,) outward normals there."""
    ways = [np.arctan2(-normal[1], -normal[0]) for normal in outward]
    apart = (ways[-1] - ways[0] + np.pi) % (2.0 * np.pi) - np.pi
    first, last = sorted((0.0, apart))
    wide = np.pi - (last - first)
    start = ways[0] + last - 0.5 * np.pi
    steps = start + wide * np.linspace(0.0, 1.0, int(np.ceil(3.0 * wide / np.pi - 1e-9)) + 1)
    rim = _SECTOR * (shape.radius + shape.minor_radius) * np.stack([np.cos(steps), np.sin(steps)], axis=1)
    corners = np.concatenate([np.zeros((1, 2)), rim]) if len(outward) > 1 else rim
    return Prism(tuple(map(tuple, corners.tolist())), 2.0 * _SECTOR * shape.minor_radius)


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
    return cube(right, planes, corners)


def _plane(shapes: Sequence[Shape], k: int | None) -> Plane | None:
    shape = None if k is None else shapes[k]
    return shape if isinstance(shape, Plane) else None


def _caps(rounds: dict[int, Shape], planes: dict[int, Plane]) -> dict[tuple[int, int], int]:
    """(round surface, end along its axis: -1 or 1) -> the plane across it, each plane used once."""
    out: dict[tuple[int, int], int] = {}
    for k, plane in planes.items():
        best: tuple[float, int, int] | None = None
        for i, shape in rounds.items():
            if not shape.tilts or np.linalg.norm(np.cross(plane.normal, shape.direction)) > EXACT:
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
    low, high = span(shape.origin, axis, ends, corners)
    solid = CylinderSolid(shape.radius, high - low)
    return Piece("cylinder", "intersect", solid, along(shape.origin, axis, low, high), i, (indices,))


def _cone(
    i: int,
    shape: Cone,
    indices: tuple[int | None, int | None],
    ends: list[Plane | None],
    corners: Floats,
) -> Piece:
    """Its bottom is the wide end, and it closes at the apex where no plane cuts that off."""
    near, far = span(shape.apex, shape.axis, ends, corners)
    near = max(near, 0.0) if ends[0] is not None else 0.0
    slope = float(np.tan(shape.semi_angle))
    solid = ConeSolid(far * slope, near * slope, far - near)
    return Piece(
        "cone",
        "intersect",
        solid,
        along(shape.apex, -shape.axis, -far, -near),
        i,
        ((indices[1], indices[0]),),
    )

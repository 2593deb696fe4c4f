"""Relations that may hold, pair by pair, of each kind what those accepted before it leave to ask."""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.pose import cross, frame_along
from primitives.shapes import Cylinder, Plane, Shape, Sphere
from recognition.assembly.regularities.relation import Constraint, Proposal
from recognition.assembly.regularities.state import State


def coincident(state: State) -> list[Proposal]:
    """One surface felt in two places; the two sides of a plate are none."""
    reach = state.options.reach
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if a.kind != b.kind:
            continue
        if isinstance(a, Plane) and float(a.direction @ b.direction) < 1.0 - reach:
            continue
        if abs(float(a.direction @ b.direction)) < 1.0 - reach:
            continue
        if any(abs(p - q) > reach * p for p, q in zip(a.sizes, b.sizes, strict=True)):
            continue
        out.append(Proposal("coincident", (i, j), _one(a.frame), len(a.translations)))
    return out


def parallel(state: State) -> list[Proposal]:
    """Directions that are one."""
    reach = state.options.reach
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if a.tilts and b.tilts and np.linalg.norm(np.cross(a.direction, b.direction)) < reach:
            aligned = _aligned(frame_along(a.direction)[:, :2])
            out.append(Proposal("parallel", (i, j), aligned, 2, among=2.0 * reach))
    return out


def perpendicular(state: State) -> list[Proposal]:
    """Directions at right angles."""

    def upright(a: Shape, b: Shape) -> Floats:
        return np.array([a.direction @ b.direction])

    reach = state.options.reach
    return [
        Proposal("perpendicular", (i, j), upright, among=2.0 * reach)
        for i, j, a, b in _pairs(state)
        if a.tilts and b.tilts and abs(float(a.direction @ b.direction)) < reach
    ]


def coaxial(state: State) -> list[Proposal]:
    """Parallel axes that are one, and spheres on them."""
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if isinstance(a, Plane) or isinstance(b, Plane) or (isinstance(a, Sphere) and isinstance(b, Sphere)):
            continue
        if not (isinstance(a, Sphere) or isinstance(b, Sphere) or state.has("parallel", (i, j))):
            continue
        axis = b if isinstance(a, Sphere) else a
        across = frame_along(axis.direction)[:, :2]
        out.append(Proposal("coaxial", (i, j), _on_axis(across, axis_first=axis is a), 2))
    return out


def equal_radius(state: State) -> list[Proposal]:
    """Parallel cylinders, and spheres, that are both solid or both hollow: bolt holes, the corners of a plate."""

    def even(a: Cylinder | Sphere, b: Cylinder | Sphere) -> Floats:
        return np.array([a.radius - b.radius])

    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if a.kind != b.kind or state.convex[i] != state.convex[j] or state.has("coincident", (i, j)):
            continue
        if isinstance(a, Sphere) or (isinstance(a, Cylinder) and state.has("parallel", (i, j))):
            room = state.options.reach * max(a.sizes[0], b.sizes[0])
            if abs(a.sizes[0] - b.sizes[0]) < room:
                out.append(Proposal("equal radius", (i, j), even, among=2.0 * room))
    return out


def tangent(state: State) -> list[Proposal]:
    """A wall that a round end, a rounded corner or the end of a slot goes over into."""
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        (k, wall), (m, end) = sorted([(i, a), (j, b)], key=lambda one: one[1].kind != "plane")
        if not (isinstance(wall, Plane) and isinstance(end, Cylinder) and state.has("perpendicular", (i, j))):
            continue
        touching, room = _touching(-1.0 if state.convex[m] else 1.0), state.options.reach * end.radius
        if abs(float(touching(wall, end)[0])) < room:
            out.append(Proposal("tangent", (k, m), touching, among=2.0 * room))
    return out


def _pairs(state: State) -> list[tuple[int, int, Shape, Shape]]:
    shapes = state.shapes()
    return [(i, j, shapes[i], shapes[j]) for i in range(len(shapes)) for j in range(i + 1, len(shapes))]


def _one(frame: Floats) -> Constraint:
    def constraint(a: Shape, b: Shape) -> Floats:
        out: Floats = a.local(b, frame)  # type: ignore[arg-type]
        return out

    return constraint


def _aligned(across: Floats) -> Constraint:
    def constraint(a: Shape, b: Shape) -> Floats:
        out: Floats = cross(a.direction, b.direction) @ across
        return out

    return constraint


def _on_axis(across: Floats, axis_first: bool) -> Constraint:
    def constraint(a: Shape, b: Shape) -> Floats:
        axis, other = (a, b) if axis_first else (b, a)
        offset = other.anchor - axis.anchor
        offset = offset - (offset @ axis.direction) * axis.direction
        out: Floats = offset @ across
        return out

    return constraint


def _touching(side: float) -> Constraint:
    def constraint(wall: Plane, end: Cylinder) -> Floats:
        return np.array([(end.anchor - wall.origin) @ wall.normal - side * end.radius])

    return constraint

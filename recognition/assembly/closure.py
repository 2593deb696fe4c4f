"""Whether convex surfaces bound a body, which of them touch it, and where it is open.

Every curved surface is replaced by planes tangent to it, so the polyhedron holds the body and is little larger.
Its half-spaces and the workspace's six walls are intersected in the dual (Preparata and Muller 1979; Qhull), from
the center of the greatest ball inside (a linear program).  A wall with a facet of its own is a way out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import HalfspaceIntersection

from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere


@dataclass(frozen=True)
class ClosureOptions:
    """Tolerances of the closure test."""

    around: int = 64  # tangent planes round a cylinder or cone
    over: int = 400  # tangent planes over a sphere
    least_ball: float = 0.05  # [mm] a body that holds no ball of this radius is a contradiction
    least_facet: float = 0.01  # [mm^2] a smaller facet is a touch, not a face
    past_walls: float = 5.0  # [mm] the part may come this close to the workspace's walls


@dataclass(frozen=True)
class NotClosed:
    """Why there is no body yet; false in a condition."""

    reason: str
    open_faces: tuple[int, ...] = ()  # faces whose boundary leaves the workspace
    directions: tuple[tuple[float, float, float], ...] = ()  # (k, 3) unit, from inside to where it leaves

    def __bool__(self) -> bool:
        return False


@dataclass(frozen=True)
class Hull:
    """A polyhedron round the body."""

    inside: Floats  # (3,) center of the greatest ball in it [mm]
    corners: Floats  # (n, 3) [mm]
    area: Floats  # (m,) [mm^2] of the facets of each surface; zero where it does not touch the body


def hull(shapes: Sequence[Shape], box: Floats, options: ClosureOptions | None = None) -> Hull | NotClosed:
    """The polyhedron, or where it leaves the (2, 3) `box` [mm]."""
    options = options or ClosureOptions()
    if not shapes:
        return NotClosed("no face is fitted yet", directions=_rows(_WALLS))
    tangents = [_tangents(s, options) for s in shapes]
    owner = np.concatenate([np.full(len(t), i) for i, t in enumerate(tangents)] + [np.full(6, -1)])
    low, high = np.asarray(box, dtype=float)
    reach = np.concatenate([high, -low]) + options.past_walls
    planes = np.concatenate([*tangents, np.column_stack([_WALLS, -reach])])
    inside = greatest_ball(planes, options.least_ball)
    if inside is None:
        return NotClosed("the faces contradict each other: no space lies inside all of them")
    cells = HalfspaceIntersection(planes, inside)
    corners, area, members = _facets(planes, cells)
    walls = [k for k in range(len(planes) - 6, len(planes)) if area[k] > options.least_facet]
    if walls:
        return _open(corners, members, owner, walls, inside)
    by_shape = np.bincount(owner[:-6], area[:-6], minlength=len(shapes))
    by_shape[by_shape < options.least_facet] = 0.0
    return Hull(frozen(inside), frozen(corners), frozen(by_shape))


_WALLS = np.concatenate([np.eye(3), -np.eye(3)])


def _tangents(shape: Shape, options: ClosureOptions) -> Floats:
    """(k, 4) rows (n, c) with n . x + c <= 0."""
    if isinstance(shape, Plane):
        normals, points = shape.normal[None], shape.origin[None]
    elif isinstance(shape, Sphere):
        normals = _spread_normals(options.over)
        points = shape.center + shape.radius * normals
    elif isinstance(shape, Cylinder | Cone):
        turn = 2 * np.pi * np.arange(options.around) / options.around
        ring = np.stack([np.cos(turn), np.sin(turn)], axis=1) @ shape.frame[:, :2].T
        if isinstance(shape, Cylinder):
            normals, points = ring, shape.origin + shape.radius * ring
        else:
            normals = np.cos(shape.semi_angle) * ring - np.sin(shape.semi_angle) * shape.axis
            points = np.broadcast_to(shape.apex, ring.shape)
    else:
        normals, points = np.empty((0, 3)), np.empty((0, 3))
    return np.column_stack([normals, -(normals * points).sum(axis=1)])


def _spread_normals(count: int) -> Floats:
    """Nearly even directions (Fibonacci lattice)."""
    k = np.arange(count)
    z = 1.0 - (2 * k + 1) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - z**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), z], axis=1)


def greatest_ball(planes: Floats, least: float) -> Floats | None:
    """The (3,) center of the greatest ball in (n, 4) half-spaces, none where its radius is below `least` [mm]."""
    constraints = np.column_stack([planes[:, :3], np.ones(len(planes))])
    found = linprog(
        [0, 0, 0, -1], A_ub=constraints, b_ub=-planes[:, 3], bounds=[(None, None)] * 3 + [(None, None)]
    )
    if not found.success or found.x is None or found.x[3] < least:
        return None
    return np.asarray(found.x[:3], dtype=float)


def _facets(planes: Floats, cells: HalfspaceIntersection) -> tuple[Floats, Floats, list[Ints]]:
    """Corners, and each half-space's area and corners."""
    corners = np.asarray(cells.intersections, dtype=float)
    half = np.concatenate([np.asarray(f) for f in cells.dual_facets])
    corner = np.repeat(np.arange(len(corners)), [len(f) for f in cells.dual_facets])
    order = np.argsort(half, kind="stable")
    edges = np.searchsorted(half[order], np.arange(len(planes) + 1))
    members = [corner[order[a:b]] for a, b in pairwise(edges)]
    areas = [_polygon_area(corners[m], planes[k, :3]) for k, m in enumerate(members)]
    return corners, np.array(areas), members


def _polygon_area(points: Floats, normal: Floats) -> float:
    """Of the convex polygon of unordered corners in a plane."""
    if len(points) < 3:
        return 0.0
    away = points - points.mean(axis=0)
    first = away[np.argmax((away**2).sum(axis=1))]
    turn = np.arctan2(np.cross(first, away) @ normal, away @ first)
    ring = away[np.argsort(turn)]
    return float(0.5 * abs(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) @ normal))


def _open(corners: Floats, members: list[Ints], owner: Ints, walls: list[int], inside: Floats) -> NotClosed:
    ways = np.array([corners[members[k]].mean(axis=0) - inside for k in walls])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    out = {int(c) for k in walls for c in members[k]}
    faces = sorted({int(owner[k]) for k, m in enumerate(members) if owner[k] >= 0 and out & set(m.tolist())})
    shown = "; ".join("(" + ", ".join(f"{v:.2f}" for v in way) + ")" for way in ways)
    return NotClosed(f"the boundary is open along {shown}", tuple(faces), _rows(ways))


def _rows(vectors: Floats) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in vectors)

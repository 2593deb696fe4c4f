"""From a solid to its boundary: from labels where its triangles have them, else from surfaces recovered first.

Neighboring triangles on one surface are one face; runs of mesh edges between the same two faces, from one
meeting of three faces to the next, are one edge.  Edge points are then put on both exact surfaces (one face's
mesh is within the facets' tolerance of them), so lengths, extents and angles are those of the exact part.
A face without a surface is freeform: its triangles stand for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.body import Body, LabeledSurface
from models.boundaries.curves import Chain, chains, edge_between, handles, loops, refined
from models.boundaries.extents import anchored
from models.boundaries.short_edges import without_short_edges
from models.boundaries.tangent import absorbed, forward, on_tangents
from models.boundaries.topology import count_shells, genus
from models.brep import Brep, Edge, Face
from models.recovery import Recovered, recover
from models.solid import Solid
from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.shapes import Shape


@dataclass(frozen=True)
class BoundaryConfig:
    """Tolerances of the boundary on known surfaces."""

    same_surface: float = 1e-6  # [mm] between surfaces that are one; and [rad] between their axes
    sliver: float = 1e-6  # [mm^2] faces below this are the facets' fault and join a neighbor
    short: float = 1e-4  # [mm] edges no longer are a vertex
    smooth: float = 1.0  # [deg] between normals below which an edge is smooth
    on_curve: float = 2e-3  # [mm] from a line or circle that an edge may be and still be called so
    parallel: float = 1e-2  # [1] ratio of singular values at which surfaces that meet count as tangent


_FARTHEST = 0.5  # [mm] that a point may move onto its surfaces; farther is a step gone wrong

RECOVERED = BoundaryConfig(smooth=8.0, on_curve=0.02, parallel=0.1)
"""For surfaces that were fitted: a radius off by d tilts the normal at a tangent edge by sqrt(2 d / r)."""


def boundary(solid: Solid, config: BoundaryConfig | None = None) -> Brep:
    """The boundary of a solid, in the part frame."""
    return labeled_boundary(solid, config)[0]


def labeled_boundary(solid: Solid, config: BoundaryConfig | None = None) -> tuple[Brep, Ints]:
    """The boundary, and the (t,) face that each triangle of the solid belongs to; found once for each body."""
    body = solid.body
    tolerances = config or (BoundaryConfig() if body.surfaces else RECOVERED)
    return body.remembered(("boundary", tolerances), lambda: _boundary(body, tolerances))


def exact_surfaces(body: Body) -> Recovered:
    """The labels that the body came with, or what was recovered from its triangles, once."""
    if not body.surfaces:
        return body.remembered("recovered", lambda: recover(body.vertices, body.triangles, body.neighbors))
    freeform = LabeledSurface(None, True, -1)
    labels = np.where(body.face_of_triangle < 0, len(body.surfaces), body.face_of_triangle)
    return Recovered(labels, (*body.surfaces, freeform))


def _boundary(body: Body, tolerances: BoundaryConfig) -> tuple[Brep, Ints]:
    known = exact_surfaces(body)
    surface = known.face_of_triangle
    if body.surfaces:
        surface = _merged(surface, known.surfaces, tolerances.same_surface)
    face = _faces(surface, body.neighbors)
    face = _without_slivers(face, body.neighbors, body.triangle_areas, tolerances.sliver)
    if body.surfaces:
        face = _tidied(face, surface, known.surfaces, body)
    areas = np.bincount(face, weights=body.triangle_areas)
    surfaces = [known.surfaces[i] for i in _majority(face, surface, body.triangle_areas)]
    pieces = chains(body.triangles, body.neighbors, face)
    runs = loops(pieces, body.triangles, body.neighbors, face)
    round_ = handles(face, body.triangles, body.neighbors, [len(r) for r in runs])
    shapes = [s.shape for s in surfaces]
    exact = _on_surfaces(body.vertices, pieces, shapes, tolerances.parallel, bool(body.surfaces))
    corners = np.unique([v for p in pieces if not p.closed for v in (p.vertices[0], p.vertices[-1])])
    number = {int(v): i for i, v in enumerate(corners)}
    edges = tuple(
        _edge(i, piece, exact, number, surfaces, body, tolerances) for i, piece in enumerate(pieces)
    )
    meetings = exact[corners.astype(np.int64)].reshape(-1, 3)
    edges, runs, meetings = without_short_edges(edges, runs, meetings, tolerances.short)
    of_face: list[list[Edge]] = [[] for _ in surfaces]
    for edge in edges:
        for f in edge.faces:
            of_face[f].append(edge)
    order, begin = (
        np.argsort(face, kind="stable"),
        np.searchsorted(np.sort(face), np.arange(len(surfaces) + 1)),
    )
    faces = []
    for f, known_surface in enumerate(surfaces):
        rim = np.concatenate([refined(edge) for edge in of_face[f]]) if of_face[f] else np.empty((0, 3))
        mine = exact[body.triangles[order[begin[f] : begin[f + 1]]]]
        shape, extent = anchored(known_surface.shape, mine, rim)
        faces.append(Face(f, shape, known_surface.convex, float(areas[f]), extent, tuple(runs[f]), round_[f]))
    shells = count_shells(body.neighbors)
    brep = Brep(tuple(faces), edges, frozen(meetings), shells, genus(body.triangles, shells))
    return brep, frozen(face, np.int64)


def _tidied(face: Ints, surface: Ints, surfaces: tuple[LabeledSurface, ...], body: Body) -> Ints:
    """(t,) faces without the islands that facets of tangent surfaces leave in each other."""
    while True:
        most = _majority(face, surface, body.triangle_areas)
        whole = absorbed(face, [surfaces[i] for i in most], body)
        if np.array_equal(whole, face):
            return face
        face = np.asarray(np.unique(whole, return_inverse=True)[1])


def _edge(
    i: int,
    piece: Chain,
    exact: Floats,
    number: dict[int, int],
    surfaces: list[LabeledSurface],
    body: Body,
    tolerances: BoundaryConfig,
) -> Edge:
    ends = None if piece.closed else (number[piece.vertices[0]], number[piece.vertices[-1]])
    points = exact[list(piece.vertices)]
    kept = forward(points, tolerances.on_curve)
    points = points[kept]
    middle = (points[1:] + points[:-1]) / 2
    flat = body.triangle_normals[np.array(piece.triangles)[kept[:-1]]]
    left, right = (surfaces[f].normals(middle, flat[:, k]) for k, f in enumerate(piece.faces))
    return edge_between(i, piece.faces, points, ends, (left, right), tolerances.smooth, tolerances.on_curve)


def _majority(face: Ints, surface: Ints, areas: Floats) -> list[int]:
    """The surface that most of each face's area is on."""
    count = int(surface.max()) + 1
    key, inverse = np.unique(face * count + surface, return_inverse=True)
    share = np.bincount(inverse.reshape(-1), areas)
    order = np.lexsort((share, key // count))
    last = np.append(np.flatnonzero(np.diff(key[order] // count)), len(order) - 1)
    return [int(k) for k in (key % count)[order][last]]


def _merged(labels: Ints, surfaces: tuple[LabeledSurface, ...], tolerance: float) -> Ints:
    """(t,) labels with the first of all surfaces that are the same surface."""
    first = np.arange(len(surfaces))
    kinds: dict[tuple[str, bool | None], list[int]] = {}
    for i, surface in enumerate(surfaces):
        if surface.shape is not None:
            kinds.setdefault((surface.shape.kind, surface.convex), []).append(i)
    for (kind, _), rows in kinds.items():
        shapes = [shape for i in rows if (shape := surfaces[i].shape) is not None]
        table = np.array([[*shape.direction, *shape.anchor, *shape.sizes] for shape in shapes])
        for k, i in enumerate(rows):
            before = np.flatnonzero(first[rows[:k]] == rows[:k])
            same = before[_same(kind, table[before], table[k], tolerance)]
            first[i] = rows[same[0]] if len(same) else i
    return np.asarray(first[labels])


def _same(kind: str, these: Floats, that: Floats, tolerance: float) -> Bools:
    """(n,) which of some shapes are another of their kind: rows of direction, anchor and sizes."""
    direction, apart = these[:, :3], that[3:6] - these[:, 3:6]
    along = (apart * direction).sum(axis=1, keepdims=True) * direction
    apart = {"plane": along, "cylinder": apart - along}.get(kind, apart)
    same = (np.abs(these[:, 6:] - that[6:]) <= tolerance).all(axis=1)
    same &= np.linalg.norm(apart, axis=1) < tolerance
    if kind != "sphere":
        same &= np.linalg.norm(np.cross(direction, that[:3]), axis=1) < tolerance
    if kind not in ("sphere", "cylinder"):
        same &= direction @ that[:3] > 0
    return np.asarray(same)


def _faces(surface: Ints, neighbors: Ints) -> Ints:
    """(t,) connected pieces of equal surface, numbered by their first triangle."""
    rows, columns = np.nonzero(surface[neighbors] == surface[:, None])
    linked = (rows, neighbors[rows, columns])
    n = len(surface)
    _, piece = connected_components(coo_array((np.ones(len(rows), dtype=bool), linked), shape=(n, n)), False)
    _, at, number = np.unique(piece, return_index=True, return_inverse=True)
    rank = np.empty(len(at), dtype=np.int64)
    rank[np.argsort(surface[at], kind="stable")] = np.arange(len(at))
    return np.asarray(rank[number])


def _without_slivers(face: Ints, neighbors: Ints, area: Floats, least: float) -> Ints:
    """(t,) faces after those below `least` [mm^2] have joined the neighbor that they share most edges with."""
    out = face.copy()
    for f in np.flatnonzero(np.bincount(face, weights=area) < least):
        around = out[neighbors[out == f]]
        around = around[around != f]
        if len(around):
            out[out == f] = np.bincount(around).argmax()
    return np.asarray(np.unique(out, return_inverse=True)[1])


def _on_surfaces(
    vertices: Floats, pieces: list[Chain], shapes: list[Shape | None], parallel: float, known: bool
) -> Floats:
    """(v, 3) vertices, those on edges put on every surface that meets there: least-norm Newton steps.

    Where surfaces are `known` exactly and touch, onto the curve along which they do.
    """
    size = float(np.ptp(vertices, axis=0).max())
    meets: dict[int, set[int]] = {}
    for piece in pieces:
        for v in piece.vertices:
            meets.setdefault(v, set()).update(f for f in piece.faces if shapes[f] is not None)
    groups: dict[tuple[int, ...], list[int]] = {}
    for v, faces in meets.items():
        groups.setdefault(tuple(sorted(faces)), []).append(v)
    out = vertices.copy()
    for group, rows in groups.items():
        near = [shape for f in group if (shape := shapes[f]) is not None]
        if not near:
            continue
        points = out[rows]
        touching = on_tangents(points, near, size) if known else None
        if touching is not None:
            out[rows] = touching
            continue
        for _ in range(3):
            gap = np.stack([shape.signed_distance(points) for shape in near], axis=1)
            slope = np.stack([shape.normals(points) for shape in near], axis=1)
            points = points - (np.linalg.pinv(slope, rcond=parallel) @ gap[..., None])[..., 0]
        kept = np.linalg.norm(points - out[rows], axis=1) < _FARTHEST
        out[np.asarray(rows)[kept]] = points[kept]
    return out

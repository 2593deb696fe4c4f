"""From a solid whose triangles are labeled with exact surfaces to its boundary.

Neighboring triangles on one surface are one face; runs of mesh edges between the same two faces, from one
meeting of three faces to the next, are one edge.  Edge points are then put on both exact surfaces (one face's
mesh is within the facets' tolerance of them), so lengths, extents and angles are those of the exact part.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.body import LabeledSurface
from models.brep import Brep, Edge, Face
from models.curves import Chain, chains, edge_between, loops_of, refined
from models.extents import anchored
from models.solid import Solid
from models.topology import handles
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.shapes import Plane, Shape, Sphere


@dataclass(frozen=True)
class BoundaryConfig:
    """Tolerances of the recovery."""

    same_surface: float = 1e-6  # [mm] between surfaces that are one; and [rad] between their axes
    sliver: float = 1e-6  # [mm^2] faces below this are the facets' fault and join a neighbor
    smooth: float = 1.0  # [deg] between normals below which an edge is smooth
    on_curve: float = 2e-3  # [mm] from a line or circle that an edge may be and still be called so


def boundary(solid: Solid, config: BoundaryConfig | None = None) -> Brep:
    """The boundary of a solid made from a tree, in the part frame."""
    return labeled_boundary(solid, config)[0]


def labeled_boundary(solid: Solid, config: BoundaryConfig | None = None) -> tuple[Brep, Ints]:
    """The boundary, and the (t,) face that each triangle of the solid belongs to."""
    tolerances = config or BoundaryConfig()
    if not solid.surfaces:
        raise PalpateError("no exact surfaces are known for a mesh yet; build the part as CSG")
    body = solid.body
    surface = _merged(body.face_of_triangle, body.surfaces, tolerances.same_surface)
    face = _faces(surface, body.neighbors)
    face = _without_slivers(face, body.neighbors, _areas(body.vertices[body.triangles]), tolerances.sliver)
    count = int(face.max()) + 1
    shapes = [body.surfaces[int(np.bincount(surface[face == f]).argmax())] for f in range(count)]
    pieces = chains(body.triangles, body.neighbors, face)
    used = np.unique([v for piece in pieces for v in piece.vertices])
    exact = _on_surfaces(body.vertices, used, pieces, [s.shape for s in shapes])
    corners = np.unique([v for p in pieces if not p.closed for v in (p.vertices[0], p.vertices[-1])]).astype(
        int
    )
    number = {int(v): i for i, v in enumerate(corners)}
    edges = tuple(_edge(i, piece, exact, number, shapes, tolerances) for i, piece in enumerate(pieces))
    areas = np.bincount(face, weights=_areas(body.vertices[body.triangles]))
    faces = tuple(
        _face(f, shapes[f], exact, body.triangles[face == f], float(areas[f]), edges) for f in range(count)
    )
    shells = _count_shells(body.neighbors)
    vertices = frozen(exact[corners].reshape(-1, 3))
    return Brep(faces, edges, vertices, shells, _genus(body.triangles, shells)), frozen(face, np.int64)


def _edge(
    i: int,
    piece: Chain,
    exact: Floats,
    number: dict[int, int],
    shapes: list[LabeledSurface],
    tolerances: BoundaryConfig,
) -> Edge:
    a, b = piece.faces
    ends = None if piece.closed else (number[piece.vertices[0]], number[piece.vertices[-1]])
    points = exact[list(piece.vertices)]
    return edge_between(
        i, piece.faces, points, ends, shapes[a], shapes[b], tolerances.smooth, tolerances.on_curve
    )


def _face(
    f: int, surface: LabeledSurface, exact: Floats, triangles: Ints, area: float, edges: tuple[Edge, ...]
) -> Face:
    mine = [edge for edge in edges if f in edge.faces]
    rim = np.concatenate([refined(edge) for edge in mine]) if mine else np.empty((0, 3))
    shape, extent = anchored(surface.shape, exact[triangles], rim)
    loops = loops_of(f, mine)
    through = handles(triangles, len(loops)) if shape.kind == "torus" else 0
    return Face(f, shape, surface.convex, area, extent, loops, through)


def _merged(labels: Ints, surfaces: tuple[LabeledSurface, ...], tolerance: float) -> Ints:
    """(t,) labels with the first of all surfaces that are the same surface."""
    first = np.arange(len(surfaces))
    for i, later in enumerate(surfaces):
        for j in range(i):
            if (
                first[j] == j
                and surfaces[j].convex == later.convex
                and _same(surfaces[j].shape, later.shape, tolerance)
            ):
                first[i] = j
                break
    return np.asarray(first[labels])


def _same(a: Shape, b: Shape, tolerance: float) -> bool:
    if a.kind != b.kind or not np.allclose(a.sizes, b.sizes, rtol=0, atol=tolerance):
        return False
    if isinstance(a, Plane):
        aligned = float(a.direction @ b.direction) > 0
    else:
        aligned = isinstance(a, Sphere) or a.kind == "cylinder" or float(a.direction @ b.direction) > 0
    turned = 0.0 if isinstance(a, Sphere) else float(np.linalg.norm(np.cross(a.direction, b.direction)))
    apart = b.anchor - a.anchor
    if isinstance(a, Plane):
        apart = a.direction * (apart @ a.direction)
    elif a.kind == "cylinder":
        apart = apart - a.direction * (apart @ a.direction)
    return aligned and turned < tolerance and float(np.linalg.norm(apart)) < tolerance


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


def _on_surfaces(vertices: Floats, used: Ints, pieces: list[Chain], shapes: list[Shape]) -> Floats:
    """(v, 3) vertices, those `used` by edges put on every surface that meets there: least-norm Newton steps."""
    meets: dict[int, set[int]] = {int(v): set() for v in used}
    for piece in pieces:
        for v in piece.vertices:
            meets[int(v)].update(piece.faces)
    groups: dict[tuple[int, ...], list[int]] = {}
    for v, faces in meets.items():
        groups.setdefault(tuple(sorted(faces)), []).append(v)
    out = vertices.copy()
    for group, rows in groups.items():
        points = out[rows]
        for _ in range(3):
            gap = np.stack([shapes[f].signed_distance(points) for f in group], axis=1)
            slope = np.stack([shapes[f].normals(points) for f in group], axis=1)
            points = points - (np.linalg.pinv(slope, rcond=1e-2) @ gap[..., None])[..., 0]
        kept = np.linalg.norm(points - out[rows], axis=1) < _FARTHEST
        out[np.asarray(rows)[kept]] = points[kept]
    return out


_FARTHEST = 0.5  # [mm] that a point may move onto its surfaces; farther is a step gone wrong


def _areas(corners: Floats) -> Floats:
    a, b, c = np.moveaxis(corners, 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


def _count_shells(neighbors: Ints) -> int:
    n = len(neighbors)
    links = coo_array(
        (np.ones(3 * n, dtype=bool), (np.repeat(np.arange(n), 3), neighbors.ravel())), shape=(n, n)
    )
    return int(connected_components(links, False)[0])


def _genus(triangles: Ints, shells: int) -> int:
    euler = len(np.unique(triangles)) - 3 * len(triangles) // 2 + len(triangles)
    return shells - euler // 2

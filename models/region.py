"""The boundary of a region of an object, its open rim marked: some of its faces, or what lies in a box or ball.

An edge that lost one of its faces has `OPEN` in that face's place.  Where a box or ball cuts through a face, the
face goes on smoothly beyond the edge: such edges are `cut`, they stand for nothing on the object, and the face's
area and extent are lower bounds.  An open edge that is not cut is a true edge whose other face is not known.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import ArrayLike

from models.body import LabeledSurface
from models.boundary import labeled_boundary
from models.brep import Brep, Edge, Face
from models.csg import Csg, Cube, Sphere
from models.solid import Solid, clipped
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

OPEN = -1  # stands in `Edge.faces` for a face that is not in the region
_NUDGE_MM = 1e-4  # by which a box or ball is moved off a face that it would touch all over


@dataclass(frozen=True, eq=False)
class PartialBrep:
    """Some of a boundary, in the part frame; false if there is nothing of it."""

    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    vertices: Floats  # (v, 3) [mm]
    sources: tuple[int, ...]  # the face of the whole boundary that each face is, or is a piece of
    cut: frozenset[int]  # edges that only the region's border made

    def __bool__(self) -> bool:
        return bool(self.faces)

    @property
    def open_edges(self) -> tuple[int, ...]:
        """The rim: edges with one face."""
        return tuple(edge.id for edge in self.edges if OPEN in edge.faces)

    @property
    def cut_faces(self) -> frozenset[int]:
        """Faces of which a piece is missing."""
        return frozenset(f for e in self.cut for f in self.edges[e].faces if f != OPEN)

    def graph(self) -> nx.MultiGraph:
        """As `Brep.graph`; nodes know whether they are `cut`, and their true open edges as (curve, length)."""
        graph = nx.MultiGraph()
        for face in self.faces:
            rim = [self.edges[e] for loop in face.loops for e in loop if OPEN in self.edges[e].faces]
            graph.add_node(
                face.id,
                shape=face.kind,
                convex=face.convex,
                area=face.area,
                extent=face.extent,
                cut=face.id in self.cut_faces,
                open=tuple((edge.curve, edge.length) for edge in rim if edge.id not in self.cut),
            )
        for edge in self.edges:
            if OPEN not in edge.faces:
                graph.add_edge(
                    *edge.faces,
                    key=edge.id,
                    kind=edge.kind,
                    curve=edge.curve,
                    length=edge.length,
                    dihedral_deg=edge.dihedral_deg,
                    cut=self._ends_at_a_cut(edge),
                )
        return graph

    def check(self) -> tuple[str, ...]:
        """What is wrong with it, one line each: edges have two faces or are open, and loops close."""
        return tuple(self._wrong())

    def as_json(self) -> dict[str, Any]:
        """The fields of `Brep.as_json`; an open edge's missing face is null."""
        out = Brep(self.faces, self.edges, self.vertices).as_json()
        for edge, fields in zip(self.edges, out["edges"], strict=True):
            fields["faces"] = [None if f == OPEN else f for f in edge.faces]
            fields["cut"] = edge.id in self.cut
        return {key: out[key] for key in ("faces", "edges", "vertices_mm")} | {"sources": list(self.sources)}

    def _ends_at_a_cut(self, edge: Edge) -> bool:
        ends = {v for e in self.cut for v in self.edges[e].vertices or ()}
        return bool(ends & set(edge.vertices or ()))

    def _wrong(self) -> Iterator[str]:
        used = Counter(edge for face in self.faces for loop in face.loops for edge in loop)
        for edge in self.edges:
            wanted = 2 - edge.faces.count(OPEN)
            if used[edge.id] != wanted or wanted == 0:
                yield f"edge {edge.id} is in loops {used[edge.id]} times, not {max(wanted, 1)}"
        for face in self.faces:
            for loop in face.loops:
                ends = [self._ends(e, face.id) for e in loop]
                if any(ends[i - 1][1] != ends[i][0] for i in range(len(ends))):
                    yield f"face {face.id} has a loop that does not close: edges {list(loop)}"
            if not face.area > 0:
                yield f"face {face.id} has no area"

    def _ends(self, edge: int, face: int) -> tuple[int, int]:
        a, b = self.edges[edge].vertices or (-edge - 1, -edge - 1)
        return (a, b) if self.edges[edge].faces[0] == face else (b, a)


def region(
    part: Brep | Solid,
    faces: Iterable[int] | None = None,
    box: ArrayLike | None = None,
    ball: tuple[ArrayLike, float] | None = None,
) -> PartialBrep:
    """Some faces of a boundary, or what of a solid's lies in a (2, 3) box or a ball (center, radius) [mm]."""
    if sum(given is not None for given in (faces, box, ball)) != 1:
        raise PalpateError("a region is given by one of faces, box and ball")
    whole = part if isinstance(part, Brep) else labeled_boundary(part)[0]
    if faces is not None:
        chosen = sorted(set(faces))
        if chosen and not (chosen[0] >= 0 and chosen[-1] < len(whole.faces)):
            raise PalpateError(f"the part has faces 0 to {len(whole.faces) - 1}, not {chosen}")
        return _kept(whole, {f: f for f in chosen}, frozenset())
    if isinstance(part, Brep):
        raise PalpateError("a box or ball cuts faces, so give the solid, not its boundary alone")
    return _inside(
        part, whole, _box(whole, box) if box is not None else _ball(whole, *ball or ((0, 0, 0), 0))
    )


def _inside(solid: Solid, whole: Brep, keeper: Csg) -> PartialBrep:
    labels = labeled_boundary(solid)[1]
    surfaces = tuple(LabeledSurface(face.shape, face.convex, -1) for face in whole.faces)
    piece = clipped(solid.body, labels, surfaces, keeper)
    if piece is None:
        return PartialBrep((), (), frozen(np.empty((0, 3))), (), frozenset())
    brep, face_of = labeled_boundary(piece)
    source = {}
    for f in range(len(brep.faces)):
        mine = face_of == f
        most = int(np.bincount(piece.face_of_triangle[mine], piece.body.triangle_areas[mine]).argmax())
        if most < len(surfaces):
            source[f] = most
    lost = {edge.id for edge in brep.edges if sum(f in source for f in edge.faces) == 1}
    return _kept(brep, source, frozenset(lost))


def _kept(brep: Brep, source: dict[int, int], cut: frozenset[int]) -> PartialBrep:
    """The faces of `brep` that have a source, numbered anew with their edges and vertices."""
    number = {f: i for i, f in enumerate(source)}
    edges = [edge for edge in brep.edges if any(f in number for f in edge.faces)]
    edge_number = {edge.id: i for i, edge in enumerate(edges)}
    used = sorted({v for edge in edges for v in edge.vertices or ()})
    vertex = {v: i for i, v in enumerate(used)}
    return PartialBrep(
        tuple(
            replace(
                brep.faces[f],
                id=i,
                loops=tuple(tuple(edge_number[e] for e in loop) for loop in brep.faces[f].loops),
            )
            for f, i in number.items()
        ),
        tuple(
            replace(
                edge,
                id=edge_number[edge.id],
                faces=(number.get(edge.faces[0], OPEN), number.get(edge.faces[1], OPEN)),
                vertices=None
                if edge.vertices is None
                else (vertex[edge.vertices[0]], vertex[edge.vertices[1]]),
                kind="smooth" if edge.id in cut else edge.kind,
                dihedral_deg=180.0 if edge.id in cut else edge.dihedral_deg,
            )
            for edge in edges
        ),
        frozen(brep.vertices[used].reshape(-1, 3)),
        tuple(source.values()),
        frozenset(edge_number[e] for e in cut),
    )


def _box(whole: Brep, corners: ArrayLike) -> Csg:
    """The box, its sides moved off faces that lie in them: to hold those that look out, and miss the others."""
    sides = np.array(corners, dtype=float)
    if sides.shape != (2, 3) or not np.isfinite(sides).all() or (sides[1] <= sides[0]).any():
        raise PalpateError("a box is its least and its greatest corner, (2, 3) in mm")
    for face in whole.faces:
        if face.shape is None or face.kind != "plane":
            continue
        axis = int(np.abs(face.shape.direction).argmax())
        looks = float(face.shape.direction[axis])
        for end in (0, 1):
            if abs(looks) > 1 - 1e-9 and abs(face.shape.anchor[axis] - sides[end, axis]) < _NUDGE_MM:
                sides[end, axis] = face.shape.anchor[axis] + _NUDGE_MM * looks
    size, middle = sides[1] - sides[0], sides.mean(axis=0)
    return Cube((size[0], size[1], size[2])).at(*middle.tolist())


def _ball(whole: Brep, center: ArrayLike, radius: float) -> Csg:
    """The ball, grown or shrunk off a sphere that it would be."""
    middle = np.asarray(center, dtype=float)
    for face in whole.faces:
        if (
            face.shape is not None
            and face.kind == "sphere"
            and np.linalg.norm(face.shape.anchor - middle) < _NUDGE_MM
            and abs(face.shape.sizes[0] - radius) < _NUDGE_MM
        ):
            radius = face.shape.sizes[0] + (_NUDGE_MM if face.convex else -_NUDGE_MM)
    return Sphere(radius).at(*middle.tolist())

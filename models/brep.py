"""A boundary: faces on exact surfaces, the edges between them and the vertices where edges meet.

An edge separates two faces and is traversed once by a loop of each; an edge without vertices is closed in
itself (a rim).  The dihedral angle is measured through the material: 90 for the edge of a block, 180 where
faces meet smoothly, 270 in an inside corner.  `check` proves the count (our derivation: a rim counts for
nothing, a face with l loops for 2 - l)::

    vertices - open edges + sum over faces (2 - loops - 2 handles) = 2 (shells - genus)
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import networkx as nx
import numpy as np

from primitives.arrays import Floats, frozen
from primitives.pose import transform_points
from primitives.shapes import Shape, parameters

Kind = Literal["convex", "concave", "smooth"]
Curve = Literal["line", "circle", "other"]
_END_MM = 1e-3  # between an edge's end and its vertex


@dataclass(frozen=True, eq=False)
class Face:
    """A maximal connected piece of the boundary on one surface."""

    id: int
    shape: Shape | None  # in the part frame; None for freeform
    convex: bool  # whether the material is inside a curved shape; planes are convex
    area: float  # [mm^2]
    extent: tuple[float, float]  # [mm] what it means for each shape stands in `models.boundaries.extents`
    loops: tuple[tuple[int, ...], ...]  # ids of the edges round it, in order, material on the left
    handles: int = 0  # of the face itself: 1 for a whole torus

    @property
    def kind(self) -> str:
        """The shape's name."""
        return "freeform" if self.shape is None else self.shape.kind

    def as_json(self) -> dict[str, Any]:
        """As `summary.json` lists it."""
        return {
            "id": self.id,
            "shape": self.kind,
            "status": "measured",
            "convex": self.convex,
            "parameters": {} if self.shape is None else parameters(self.shape),
            "sigma": {},
            "extent_mm": list(self.extent),
            "area_mm2": self.area,
            "hardness_n_mm": None,
            "roughness_mm": None,
        }


@dataclass(frozen=True, eq=False)
class Edge:
    """Where two faces meet."""

    id: int
    faces: tuple[int, int]
    kind: Kind
    curve: Curve
    length: float  # [mm]
    dihedral_deg: float  # through the material; the median along the edge
    points: Floats  # (n, 3) [mm] along it, first face on the left; first and last agree where it is closed
    vertices: tuple[int, int] | None  # where it starts and ends; None for a rim

    def as_json(self) -> dict[str, Any]:
        """As `summary.json` lists it."""
        return {
            "id": self.id,
            "faces": list(self.faces),
            "kind": self.kind,
            "curve": self.curve,
            "length_mm": self.length,
            "dihedral_deg": self.dihedral_deg,
            "status": "measured",
        }


@dataclass(frozen=True, eq=False)
class Brep:
    """The whole boundary, in the part frame."""

    faces: tuple[Face, ...]
    edges: tuple[Edge, ...]
    vertices: Floats  # (v, 3) [mm]
    shells: int = 1  # closed surfaces, cavities among them
    genus: int = 0  # handles over all shells

    def graph(self) -> nx.MultiGraph:
        """Faces as nodes and edges as links, with what matching compares as attributes."""
        graph = nx.MultiGraph()
        for face in self.faces:
            graph.add_node(face.id, shape=face.kind, convex=face.convex, area=face.area, extent=face.extent)
        for edge in self.edges:
            graph.add_edge(
                *edge.faces,
                key=edge.id,
                kind=edge.kind,
                curve=edge.curve,
                length=edge.length,
                dihedral_deg=edge.dihedral_deg,
            )
        return graph

    def check(self) -> tuple[str, ...]:
        """What is wrong with it, one line each; empty for a sound boundary."""
        return (*self._broken_ids(), *self._broken_edges(), *self._broken_loops(), *self._broken_count())

    def as_json(self) -> dict[str, Any]:
        """As `brep.json` holds it: the summary's fields with loops, curves and vertices."""
        return {
            "faces": [
                face.as_json() | {"loops": [list(loop) for loop in face.loops], "handles": face.handles}
                for face in self.faces
            ],
            "edges": [
                edge.as_json()
                | {
                    "points_mm": edge.points.tolist(),
                    "vertices": list(edge.vertices) if edge.vertices else None,
                }
                for edge in self.edges
            ],
            "vertices_mm": self.vertices.tolist(),
            "shells": self.shells,
            "genus": self.genus,
        }

    def moved(self, motion: Floats) -> Brep:
        """The same boundary after a (4, 4) rigid motion."""
        return replace(
            self,
            faces=tuple(
                replace(f, shape=None if f.shape is None else f.shape.transformed(motion)) for f in self.faces
            ),
            edges=tuple(replace(e, points=frozen(transform_points(motion, e.points))) for e in self.edges),
            vertices=frozen(transform_points(motion, self.vertices.reshape(-1, 3))),
        )

    def _broken_ids(self) -> Iterator[str]:
        for name, items in (("face", self.faces), ("edge", self.edges)):
            if [item.id for item in items] != list(range(len(items))):
                yield f"{name} ids are not 0 to {len(items) - 1} in order"

    def _broken_edges(self) -> Iterator[str]:
        used = Counter(edge for face in self.faces for loop in face.loops for edge in loop)
        owners = {(face.id, edge) for face in self.faces for loop in face.loops for edge in loop}
        for edge in self.edges:
            if used[edge.id] != 2:
                yield f"edge {edge.id} is in loops {used[edge.id]} times, not twice"
            for face in edge.faces:
                if (face, edge.id) not in owners:
                    yield f"edge {edge.id} names face {face}, which has no such edge"
            if edge.vertices is not None and not self._ends_at(edge, edge.vertices):
                yield f"edge {edge.id} does not run from its first vertex to its second"
            if not edge.length > 0:
                yield f"edge {edge.id} has no length"

    def _ends_at(self, edge: Edge, ends: tuple[int, int]) -> bool:
        if not all(0 <= v < len(self.vertices) for v in ends) or len(edge.points) < 2:
            return False
        apart = np.linalg.norm(edge.points[[0, -1]] - self.vertices[list(ends)], axis=1)
        return bool(apart.max() <= _END_MM)

    def _broken_loops(self) -> Iterator[str]:
        for face in self.faces:
            for loop in face.loops:
                rims = [self.edges[e].vertices is None for e in loop]
                if any(rims) and len(loop) > 1:
                    yield f"face {face.id} joins a rim to other edges"
                elif not any(rims) and not self._closes(face.id, loop):
                    yield f"face {face.id} has a loop that does not close: edges {list(loop)}"

    def _closes(self, face: int, loop: tuple[int, ...]) -> bool:
        steps = [(self.edges[e].vertices or (0, 0), self.edges[e].faces[0] == face) for e in loop]
        ends = [(a, b) if forth else (b, a) for (a, b), forth in steps]
        return all(ends[i - 1][1] == ends[i][0] for i in range(len(ends)))

    def _broken_count(self) -> Iterator[str]:
        bounded = sum(edge.vertices is not None for edge in self.edges)
        faces = sum(2 - len(face.loops) - 2 * face.handles for face in self.faces)
        count, wanted = len(self.vertices) - bounded + faces, 2 * (self.shells - self.genus)
        if count != wanted:
            yield f"Euler's count is {count}, not {wanted} for {self.shells} shells of genus {self.genus}"
        if not all(np.isfinite(face.area) and face.area > 0 for face in self.faces):
            yield "a face has no area"

"""Evidence -> model: the faces that were felt become a boundary and a CSG tree, each part of it with its status.

Where nothing that was felt closes the body, it is cut off at the last contacts, and that is told.

A face is measured when contacts lie on it.  An edge is measured when a trace ran along it, or when both its faces
are measured and were touched beside it: most of its points have a contact of each face within reach.  What is not
measured is inferred from the surfaces that meet there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from models.brep import Edge
from models.rays.triangle_tree import TriangleTree
from primitives.arrays import Floats, Ints
from primitives.evidence import NOT_FELT, Contacts, EdgeTrace
from primitives.fit import Fit
from primitives.patch_graph import PatchGraph
from primitives.plate import Plate
from primitives.shapes import parameters
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.described import (
    LinkedBoundary,
    describe_edges,
    describe_faces,
    describe_primitives,
    describe_regularities,
    link,
)
from recognition.assembly.lapping import lapped
from recognition.assembly.uncertainty import face_sigma
from recognition.best_body import FeltFace, best_body, reach_past

Rows = list[dict[str, Any]]
NO_FACE = -1
_ON = 1.0  # [mm] from a freeform face, within which a contact lies on it


@dataclass(frozen=True)
class ReconstructOptions:
    """What counts as touched."""

    beside: float = 10.0  # [mm] from a point of an edge to the nearest contact of a face that meets there
    most: float = 0.5  # share of an edge's points that must have such contacts
    inferred: float = 0.1  # share of the surface on faces that nobody touched, from which that is told
    named: int = 12  # of those faces, that are named
    past: float = 15.0  # [mm] past all contacts, from which it is told how far the body reaches
    run_on: float = 15.0  # [mm] the same, from which it is cut off where no face ends it
    off: tuple[float, float] = (
        6.0,
        0.5,
    )  # sigmas, and [mm], from the body, beyond which a contact speaks against it
    against: int = 2  # contacts that do so, from which that is told


@dataclass(frozen=True)
class Reconstruction:
    """A body, or why there is none; and what was felt either way."""

    assembly: Assembly | NotClosed
    boundary: LinkedBoundary | None
    faces: Rows  # as in the summary
    edges: Rows
    primitives: Rows
    contacts: Contacts
    face_of_contact: Ints  # (n,) id of a face of the summary; -1 where it lies on none
    warnings: tuple[str, ...]
    regularities: Rows = field(default_factory=list)
    closed: bool = False  # whether faces close the body; else there is none, or it is cut off somewhere

    def brep_json(self) -> dict[str, Any]:
        """`brep.json`: the summary's faces and edges with loops, curves and vertices."""
        if self.boundary is None:
            faces = [face | {"loops": []} for face in self.faces]  # no rim is known
            return {"faces": faces, "edges": self.edges, "vertices_mm": [], "closed": False}
        whole = self.boundary.brep.as_json()
        for kind, rows in (("faces", self.faces), ("edges", self.edges)):
            whole[kind] = [geometry | told for geometry, told in zip(whole[kind], rows, strict=True)]
        return whole


def reconstruct(
    graph: PatchGraph,
    traces: Sequence[EdgeTrace],
    box: Floats,
    options: ReconstructOptions | None = None,
    free: Floats | None = None,
    plates: Sequence[Plate] = (),
) -> Reconstruction:
    """The body behind the faces of a graph, in the (2, 3) workspace `box` [mm].

    (n, 3) `free` places are empty; of `plates` the outlines are known.
    """
    options = options or ReconstructOptions()
    shaped = [FeltFace(face.fit, face.contacts) for face in graph.faces if isinstance(face.fit, Fit)]
    loose = [face.contacts for face in graph.faces if not isinstance(face.fit, Fit)]
    body = best_body(shaped, box, free, options.run_on, Contacts.concatenate(loose), plates)
    assembly, felt = body.assembly, body.felt
    loose += [face.contacts for face in body.left_out]
    contacts = graph.believed(Contacts.concatenate([*(face.contacts for face in felt), *loose]))
    fit_of_contact = np.repeat(
        [*range(len(felt)), *(NO_FACE for _ in loose)],
        [len(table) for table in (*(face.contacts for face in felt), *loose)],
    ).astype(np.int64)
    if isinstance(assembly, NotClosed):
        rows = [_open_face(number, face.fit) for number, face in enumerate(felt)]
        reason = (f"no closed body: {assembly.reason}",)
        return Reconstruction(assembly, None, rows, [], [], contacts, fit_of_contact, reason)
    assembly = lapped(assembly)
    boundary = link(assembly)
    face_of_contact = _faces_of(assembly, boundary, contacts, fit_of_contact)
    faces = describe_faces(assembly, boundary)
    edges = describe_edges(assembly, boundary, traces)
    owner = np.where(contacts.touch == NOT_FELT, NO_FACE, face_of_contact)
    touched = {k: contacts.points[owner == k] for k in set(owner.tolist()) - {NO_FACE}}
    for face in faces:
        face["status"] = "measured" if face["id"] in touched else "inferred"
    for row, edge in zip(edges, boundary.brep.edges, strict=True):
        if _touched_beside(edge, touched, options):
            row["status"] = "measured"
    return Reconstruction(
        assembly, boundary, faces, edges, describe_primitives(assembly), contacts, face_of_contact,
        (*assembly.warnings, *body.told(), *_in_pieces(assembly), *_untouched(assembly, faces, contacts, options),
         *_against(assembly, contacts.select(face_of_contact == NO_FACE), options)),
        describe_regularities(assembly, boundary), body.whole,
    )  # fmt: skip


def _in_pieces(assembly: Assembly) -> list[str]:
    """Whether the body does not hang together, as an object does."""
    parts = assembly.solid.parts
    return (
        [f"the model lies in {parts} pieces: what joins them was not felt, or not enough"]
        if parts > 1
        else []
    )


def _untouched(assembly: Assembly, faces: Rows, contacts: Contacts, options: ReconstructOptions) -> list[str]:
    """How much of the body is nothing but inference."""
    out: list[str] = []
    total = sum(face["area_mm2"] for face in faces)
    inferred = [face for face in faces if face["status"] != "measured"]
    share = sum(face["area_mm2"] for face in inferred) / max(total, 1e-9)
    if share > options.inferred:
        which = ", ".join(str(face["id"]) for face in inferred[: options.named])
        which += f" and {len(inferred) - options.named} more" if len(inferred) > options.named else ""
        out.append(f"{share:.0%} of the surface is inferred, not touched: face {which}")
    past = reach_past(assembly, contacts)
    if past > options.past:
        out.append(f"the body reaches {past:.0f} mm past all that was touched, where nothing says it ends")
    return out


def _against(assembly: Assembly, unowned: Contacts, options: ReconstructOptions) -> list[str]:
    """How many of the contacts that lie on no face lie nowhere near the body's surface either."""
    felt = unowned.select(unowned.touch != NOT_FELT)
    if not len(felt):
        return []
    off = np.abs(assembly.solid.signed_distance(felt.points))
    sigmas, least = options.off
    off = off[off > np.maximum(sigmas * felt.sigma, least)]
    if len(off) < options.against:
        return []
    return [
        f"{len(off)} contacts lie on no face, and up to {off.max():.1f} mm off the model: "
        "a hole or a step may be missing there, or they strayed"
    ]


def _open_face(number: int, fit: Fit) -> dict[str, Any]:
    """A face whose extent is not known because the boundary is not closed."""
    return {
        "id": number,
        "shape": fit.kind,
        "status": "measured",
        "convex": fit.convex,
        "parameters": parameters(fit.shape),
        "sigma": face_sigma(fit.shape, fit.covariance),
        "extent_mm": None,
        "area_mm2": None,
        "hardness_n_mm": None,
        "roughness_mm": None,
    }


def _faces_of(assembly: Assembly, boundary: LinkedBoundary, contacts: Contacts, fit_of_contact: Ints) -> Ints:
    """(n,) the face of each contact: of those on its surface, the nearest."""
    owner = np.full(len(contacts), NO_FACE, dtype=np.int64)
    for number, speaker in enumerate(assembly.surface_of_fit):
        rows = np.flatnonzero(fit_of_contact == number)
        faces = [k for k, made in enumerate(boundary.fit_of_face) if speaker is not None and made == speaker]
        if len(faces) == 1 or not len(rows):
            owner[rows] = faces[0] if faces else NO_FACE
        elif faces:
            solid = assembly.solid
            away = [
                TriangleTree(solid.vertices, solid.triangles[boundary.of_triangle == k]).nearest(
                    contacts.points[rows]
                )
                for k in faces
            ]
            owner[rows] = np.array(faces)[np.argmin([found.distance for found in away], axis=0)]
    return _on_freeform(assembly, boundary, contacts, owner)


def _on_freeform(assembly: Assembly, boundary: LinkedBoundary, contacts: Contacts, owner: Ints) -> Ints:
    """The same, contacts of no face that lie on a freeform one its own."""
    free = [face.id for face in boundary.brep.faces if face.shape is None]
    rows = np.flatnonzero((owner == NO_FACE) & (contacts.touch != NOT_FELT))
    if free and len(rows):
        near = TriangleTree(assembly.solid.vertices, assembly.solid.triangles).nearest(contacts.points[rows])
        face = boundary.of_triangle[near.triangle]
        on = np.isin(face, free) & (near.distance < _ON)
        owner[rows[on]] = face[on]
    return owner


def _touched_beside(edge: Edge, touched: dict[int, Floats], options: ReconstructOptions) -> bool:
    if any(face not in touched for face in edge.faces):
        return False
    along = _evenly(edge.points, options.beside / 4.0)
    first, second = (np.asarray(cKDTree(touched[face]).query(along)[0]) for face in edge.faces)
    return bool(np.mean(np.maximum(first, second) < options.beside) > options.most)


def _evenly(points: Floats, step: float) -> Floats:
    """(m, 3) points along a (n, 3) polyline, at most `step` [mm] apart."""
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.linspace(0.0, reached[-1], max(2, int(np.ceil(reached[-1] / step)) + 1))
    return np.column_stack([np.interp(at, reached, points[:, axis]) for axis in range(3)])

"""An assembly as `summary.json` tells it: its faces with their evidence, and its primitives in order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from models.boundary import labeled_boundary
from models.brep import Brep, Edge
from models.csg import Cone as ConeSolid
from models.csg import Csg, Cube
from models.csg import Cylinder as CylinderSolid
from models.csg import Sphere as SphereSolid
from models.normal.kept_whole import rounded_whole
from primitives.arrays import Ints
from primitives.evidence import EdgeTrace
from primitives.pose import quaternion_wxyz
from primitives.shapes import Plane, Shape
from recognition.assembly.assemble import Assembly
from recognition.assembly.own_frame import in_frame, own_frame
from recognition.assembly.piece import Piece, tree_of
from recognition.assembly.uncertainty import Sigma, face_sigma, piece_sigma

_FINEST = 1e-4  # [mm] no size is known better than this
_DIRECTIONS = "parallel", "perpendicular"  # relations of directions
_DONE = {"add": "", "subtract": ", taken away", "intersect": ", kept to"}
_ALONG = 1.0  # [mm] between a trace and the edge that it followed


@dataclass(frozen=True)
class LinkedBoundary:
    """The boundary of the assembled body, and the fit that each face and edge came from."""

    brep: Brep  # in the world
    of_triangle: Ints  # (t,) face of each triangle of the assembly's solid
    fit_of_face: tuple[int | None, ...]  # None where no measured surface made it

    def face_status(self, face: int) -> str:
        """Whether its surface was touched."""
        return "inferred" if self.fit_of_face[face] is None else "measured"


def link(assembly: Assembly) -> LinkedBoundary:
    """Every face of the body, with the fit whose adjusted surface it lies on."""
    brep, of_triangle = labeled_boundary(assembly.solid)
    speakers = sorted({s for s in assembly.surface_of_fit if s is not None})
    fits = tuple(
        next((i for i in speakers if f.shape and _coincide(f.shape, assembly.shape(i))), None)
        for f in brep.faces
    )
    return LinkedBoundary(brep, of_triangle, fits)


def describe_faces(assembly: Assembly, boundary: LinkedBoundary) -> list[dict[str, Any]]:
    """`faces`, each with its status and the deviations of its parameters."""
    out = []
    for face, fit in zip(boundary.brep.faces, boundary.fit_of_face, strict=True):
        sigma = _of_mesh(assembly) if face.shape is None else {}
        if fit is not None:
            sigma = face_sigma(assembly.shape(fit), assembly.regularized.covariance_of(fit))
        out.append(face.as_json() | {"status": boundary.face_status(face.id), "sigma": sigma})
    return out


def describe_edges(
    assembly: Assembly, boundary: LinkedBoundary, traces: Sequence[EdgeTrace] = ()
) -> list[dict[str, Any]]:
    """`edges`: measured where a trace ran along them, else inferred from the faces that meet there."""
    return [
        edge.as_json() | {"status": "measured" if any(_ran_along(t, edge) for t in traces) else "inferred"}
        for edge in boundary.brep.edges
    ]


def _ran_along(trace: EdgeTrace, edge: Edge) -> bool:
    """Whether most of a trace's points are within reach of the edge."""
    if len(trace.points) == 0:
        return False
    starts, sides = edge.points[:-1], np.diff(edge.points, axis=0)
    away = trace.points[:, None] - starts
    share = np.clip((away * sides).sum(axis=2) / np.maximum((sides**2).sum(axis=1), 1e-12), 0.0, 1.0)
    distance = np.linalg.norm(away - share[..., None] * sides, axis=2).min(axis=1)
    return bool(np.mean(distance < _ALONG) > 0.5)


def describe_primitives(assembly: Assembly) -> list[dict[str, Any]]:
    """`primitives`, in the order in which they apply: the first adds, others intersect or subtract."""
    return [
        describe_piece(p, "add" if k == 0 else p.operation, assembly) for k, p in enumerate(assembly.pieces)
    ]


def describe_regularities(assembly: Assembly, boundary: LinkedBoundary) -> list[dict[str, Any]]:
    """`regularities`, none that follows from others: a round size as measured and as taken, or how far off.

    Two fits of one surface are one face, so that `coincident` does not appear.
    """
    first = {fit: face for face, fit in reversed(list(enumerate(boundary.fit_of_face))) if fit is not None}
    out = []
    for told in assembly.regularized.relations:
        speakers = [assembly.surface_of_fit[i] for i in told.faces]
        faces = [first[s] for s in speakers if s in first]
        if told.implied or len(set(faces)) < len(told.faces):
            continue
        turned = told.kind in _DIRECTIONS
        scale = float(np.rad2deg(1.0)) if turned else 1.0
        out.append(
            {
                "kind": told.kind,
                "faces": sorted(faces),
                "unit": "deg" if turned else "mm",
                "measured": scale * told.measured,
                "sigma": scale * told.sigma,
                "taken": told.taken,
            }
        )
    return out


def describe_piece(piece: Piece, operation: str, assembly: Assembly) -> dict[str, Any]:
    """One entry of `primitives`."""
    entry: dict[str, Any] = {
        "kind": piece.kind,
        "operation": operation,
        "pose": {
            "translation_mm": piece.world_from_piece[:3, 3].tolist(),
            "quaternion_wxyz": quaternion_wxyz(piece.world_from_piece).tolist(),
        },
        "extent_mm": _size(piece),
        "sigma": _piece_sigma(piece, assembly),
    }
    if isinstance(piece.solid, ConeSolid):
        entry["top_radius_mm"] = piece.solid.top_radius
        entry["bottom_radius_mm"] = piece.solid.bottom_radius
    return entry


def _piece_sigma(piece: Piece, assembly: Assembly) -> Sigma:
    if piece.kind == "mesh":
        return {"extent_mm": [], **_of_mesh(assembly)}
    return piece_sigma(piece, assembly.regularized)


def _of_mesh(assembly: Assembly) -> dict[str, float]:
    """The deviation of a freeform surface, where it is known."""
    return {} if assembly.mesh_sigma is None else {"surface_mm": assembly.mesh_sigma}


def written_tree(assembly: Assembly) -> Csg:
    """The tree in the digits that its best known size supports, for a person to read and edit.

    It is drawn in a frame of its own and placed in the world as a whole.  Each primitive is named by its place in
    `primitives`, and by how well its sizes are known.
    """
    told = [_piece_sigma(piece, assembly) for piece in assembly.pieces]
    known = [sigma for each in told for sigma in _numbers(each.values()) if sigma > 0.0]
    frame = own_frame(assembly.pieces)
    named = [
        replace(drawn := in_frame(piece, frame), solid=drawn.solid.named(_name(number, piece, sigma)))
        for number, (piece, sigma) in enumerate(zip(assembly.pieces, told, strict=True))
    ]
    tree = rounded_whole(tree_of(named), max(min(known, default=_FINEST), _FINEST))
    return tree if np.array_equal(frame, np.eye(4)) else tree.placed(frame)


def _name(number: int, piece: Piece, sigma: Sigma) -> str:
    """What a primitive is called in a file that people read."""
    words = [f"primitive {number}: {piece.kind}{_DONE[piece.operation] if number else ''}"]
    for key, value in sigma.items():
        sides = value if isinstance(value, list) else [value]
        what, unit = key.rsplit("_", 1)
        if any(side is not None for side in sides):
            each = " x ".join("?" if side is None else f"{side:.2g}" for side in sides)
            words.append(f"{what.replace('_', ' ')} +- {each} {unit}")
    return ", ".join(words)


def _numbers(values: Iterable[float | Sequence[float | None]]) -> Iterator[float]:
    for value in values:
        yield from ([value] if isinstance(value, float) else [v for v in value if v is not None])


def _size(piece: Piece) -> list[float]:
    solid = piece.solid
    if isinstance(solid, Cube):
        return list(solid.size)
    if isinstance(solid, CylinderSolid):
        return [2 * solid.radius, 2 * solid.radius, solid.height]
    if isinstance(solid, ConeSolid):
        width = 2 * max(solid.bottom_radius, solid.top_radius)
        return [width, width, solid.height]
    if isinstance(solid, SphereSolid):
        return [2 * solid.radius] * 3
    low, high = solid.bounds()
    return [float(side) for side in high - low]


def _coincide(face: Shape, fitted: Shape) -> bool:
    """Whether two shapes are the same up to rounding."""
    along = float(face.direction @ fitted.direction)
    if face.kind != fitted.kind or (along if isinstance(face, Plane) else abs(along)) < 0.9:
        return False
    return bool(np.abs(face.local(fitted)).max() < 1e-4)  # type: ignore[arg-type]

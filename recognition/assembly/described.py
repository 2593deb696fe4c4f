"""An assembly as `summary.json` tells it: its faces with their evidence, and its primitives in order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from models.csg import Cone as ConeSolid
from models.csg import Cube
from models.csg import Cylinder as CylinderSolid
from models.csg import Sphere as SphereSolid
from primitives.arrays import Floats
from primitives.pose import quaternion_wxyz
from primitives.shapes import Cylinder, Plane, Shape, parameters
from recognition.assembly.assemble import Assembly
from recognition.assembly.pieces import Piece
from recognition.assembly.uncertainty import face_sigma, piece_sigma
from recognition.face_regions import Region, Regions, regions


@dataclass(frozen=True)
class LinkedFace:
    """A face of the assembled body and the fit that it came from."""

    region: Region
    fit: int | None  # None where no measured surface made it
    status: str  # "measured" where its surface was touched, else "inferred"


def link_faces(assembly: Assembly) -> tuple[Regions, tuple[LinkedFace, ...]]:
    """Every face of the body, with the fit whose adjusted surface it lies on."""
    found = regions(assembly.solid)
    speakers = sorted({s for s in assembly.surface_of_fit if s is not None})
    linked = []
    for face in found.faces:
        fit = next((i for i in speakers if face.shape and _coincide(face.shape, assembly.shape(i))), None)
        linked.append(LinkedFace(face, fit, "inferred" if fit is None else "measured"))
    return found, tuple(linked)


def describe_face(number: int, face: LinkedFace, assembly: Assembly, corners: Floats) -> dict[str, Any]:
    """One entry of `faces`, from the face's (t, 3, 3) triangles [mm]."""
    region = face.region
    shape = region.shape
    assert shape is not None
    covariance = None if face.fit is None else assembly.regularized.covariance_of(face.fit)
    return {
        "id": number,
        "shape": region.kind,
        "status": face.status,
        "convex": region.convex,
        "parameters": parameters(_anchored(shape, corners)),
        "sigma": {}
        if covariance is None or face.fit is None
        else face_sigma(assembly.shape(face.fit), covariance),
        "extent_mm": list(region.extent or ()),
        "area_mm2": region.area,
        "hardness_n_mm": None,
        "roughness_mm": None,
    }


def describe_faces(assembly: Assembly) -> list[dict[str, Any]]:
    """All entries of `faces`."""
    found, linked = link_faces(assembly)
    corners = assembly.solid.vertices[assembly.solid.triangles]
    return [
        describe_face(k, face, assembly, corners[found.of_triangle == k]) for k, face in enumerate(linked)
    ]


def describe_primitives(assembly: Assembly) -> list[dict[str, Any]]:
    """`primitives`, in the order in which they apply: the first adds, others intersect or subtract."""
    return [
        describe_piece(p, "add" if k == 0 else p.operation, assembly) for k, p in enumerate(assembly.pieces)
    ]


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
        "sigma": piece_sigma(piece, assembly.regularized),
    }
    if isinstance(piece.solid, ConeSolid):
        entry["top_radius_mm"] = piece.solid.top_radius
        entry["bottom_radius_mm"] = piece.solid.bottom_radius
    return entry


def _size(piece: Piece) -> list[float]:
    solid = piece.solid
    if isinstance(solid, Cube):
        return list(solid.size)
    if isinstance(solid, CylinderSolid):
        return [2 * solid.radius, 2 * solid.radius, solid.height]
    if isinstance(solid, ConeSolid):
        width = 2 * max(solid.bottom_radius, solid.top_radius)
        return [width, width, solid.height]
    assert isinstance(solid, SphereSolid)
    return [2 * solid.radius] * 3


def _anchored(shape: Shape, corners: Floats) -> Shape:
    """A plane's origin at the face's centroid, a cylinder's in the middle of the face."""
    if isinstance(shape, Plane):
        weight = np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1, keepdims=True
        )
        center = (weight * corners.mean(axis=1)).sum(axis=0) / weight.sum()
        return Plane(center - shape.normal * float((center - shape.origin) @ shape.normal), shape.normal)
    if isinstance(shape, Cylinder):
        along = (corners.reshape(-1, 3) - shape.origin) @ shape.axis
        middle = 0.5 * float(along.min() + along.max())
        return Cylinder(shape.origin + middle * shape.axis, shape.axis, shape.radius)
    return shape


def _coincide(face: Shape, fitted: Shape) -> bool:
    """Whether two shapes are the same up to rounding."""
    along = float(face.direction @ fitted.direction)
    if face.kind != fitted.kind or (along if isinstance(face, Plane) else abs(along)) < 0.9:
        return False
    return bool(np.abs(face.local(fitted)).max() < 1e-4)  # type: ignore[arg-type]

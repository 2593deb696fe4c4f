"""A STEP file's faces as labels on triangles: exact surfaces in mm, turned as the triangles are wound.

A face for which the reader has no surface is fitted: it is kept as a plane, cylinder, cone, sphere or torus
where its corners and normals, which lie on the true surface to single precision, agree on one; else it is
freeform.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.body import LabeledSurface
from models.formats.gltf_arrays import Primitive
from models.formats.labeled import LabeledMesh
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

_ORDER = ("cylinder", "sphere", "cone", "torus")  # the fewest parameters first
_MOST_FITTED = 400  # corners of a face that a fit looks at


@dataclass(frozen=True)
class FaceConfig:
    """When a fitted face is what the fit says."""

    distance: float = 2e-3  # [mm] of corners from the surface
    turn: float = (
        0.02  # [rad] of nine normals in ten from the surface's; where splines end in a pole they fail
    )
    least: int = 8  # corners


def labeled(runs: list[Primitive], scale: float, config: FaceConfig | None = None) -> LabeledMesh:
    """One mesh from runs of triangles, its lengths multiplied by `scale`."""
    tolerances = config or FaceConfig()
    vertices, triangles, labels, surfaces = [], [], [], list[LabeledSurface]()
    start = 0
    for run in runs:
        points = run.vertices * scale
        face = _pieces(run.triangles) if run.face is None else run.face
        described = run.described
        for number in np.unique(face):
            rows = face == number
            about = described[number] if 0 <= number < len(described) else None
            shape = _shape(about, run.model_from_node, scale) if about else None
            corners = run.triangles[rows]
            if shape is None and run.normals is not None:
                shape = _fitted(points, run.normals, np.unique(corners), tolerances)
            surfaces.append(oriented(shape, points[corners]))
        _, compact = np.unique(face, return_inverse=True)
        labels.append(compact.reshape(-1) + len(surfaces) - len(np.unique(face)))
        vertices.append(points)
        triangles.append(run.triangles + start)
        start += len(points)
    return LabeledMesh(
        frozen(np.concatenate(vertices)),
        frozen(np.concatenate(triangles), np.int64),
        frozen(np.concatenate(labels), np.int64),
        tuple(surfaces),
        runs[0].name,
    )


def oriented(shape: Shape | None, corners: Floats) -> LabeledSurface:
    """The surface behind (t, 3, 3) corners as their winding has it: planes and cones turned, holes told."""
    a, b, c = np.moveaxis(corners, 1, 0)
    out, middle = np.cross(b - a, c - a), corners.mean(axis=1)
    if isinstance(shape, Cone) and float(((middle - shape.apex) @ shape.axis).sum()) < 0:
        shape = Cone(shape.apex, -shape.axis, shape.semi_angle)
    if shape is None:
        return LabeledSurface(None, True, -1)
    agrees = float(np.einsum("ij,ij->", out, shape.normals(middle))) >= 0
    if isinstance(shape, Plane):
        return LabeledSurface(shape if agrees else Plane(shape.origin, -shape.normal), True, -1)
    return LabeledSurface(shape, agrees, -1)


def _pieces(triangles: Ints) -> Ints:
    """(t,) connected pieces of triangles that share corners: a file repeats corners where faces meet."""
    n = int(triangles.max(initial=-1)) + 1
    rows, columns = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    _, piece = connected_components(coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)), False)
    return np.asarray(np.unique(piece[triangles[:, 0]], return_inverse=True)[1], dtype=np.int64)


def _shape(about: dict[str, Any], pose: Floats, scale: float) -> Shape | None:
    """What the reader says of a face, in mm."""
    try:
        match about.get("type"):
            case "plane":
                found: Shape = Plane(_point(about, "origin", scale), about["normal"])
            case "cylinder":
                found = Cylinder(_point(about, "origin", scale), about["axis"], about["radius"] * scale)
            case "cone":
                found = Cone(_point(about, "apex", scale), about["axis"], abs(about["semi_angle"]))
            case "sphere":
                found = Sphere(_point(about, "center", scale), about["radius"] * scale)
            case "torus":
                radii = about["major_radius"] * scale, about["minor_radius"] * scale
                found = Torus(_point(about, "center", scale), about["axis"], *radii)
            case _:
                return None
    except (PalpateError, KeyError, TypeError):
        return None
    moved = pose.copy()
    moved[:3, 3] *= scale
    return found.transformed(moved)


def _point(about: dict[str, Any], key: str, scale: float) -> Floats:
    return np.asarray(about[key], dtype=float) * scale


def _fitted(points: Floats, normals: Floats, used: Ints, config: FaceConfig) -> Shape | None:
    if flat := _plane(points[used], config):
        return flat
    if len(used) < config.least:
        return None
    if len(used) > _MOST_FITTED:
        used = used[np.linspace(0, len(used) - 1, _MOST_FITTED).astype(int)]
    contacts = Contacts.of(
        points[used], normals[used], sigma=config.distance / 4, normal_sigma=config.turn / 4
    )
    for kind in _ORDER:
        found = fit(kind, contacts)
        if isinstance(found, Fit) and _explains(found.shape, points[used], normals[used], config):
            return found.shape
    return None


def _plane(points: Floats, config: FaceConfig) -> Plane | None:
    middle = points.mean(axis=0)
    normal = np.linalg.svd(points - middle, full_matrices=False)[2][-1] if len(points) > 2 else None
    if normal is None or np.abs((points - middle) @ normal).max() > config.distance / 10:
        return None
    return Plane(middle, normal)


def _explains(shape: Shape, points: Floats, normals: Floats, config: FaceConfig) -> bool:
    away = np.abs(shape.signed_distance(points)).max()
    sine = np.quantile(np.linalg.norm(np.cross(shape.normals(points), normals), axis=1), 0.9)
    return bool(away < config.distance and sine < config.turn)

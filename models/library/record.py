"""What is stored of an object: arrays, and one JSON text for what is no array.

The mesh is thinned to some `triangles`, and knows the boundary's face behind every one of them;
points along edges are thinned within `chord`.  Both keep a record small; faces, extents, areas, volume and
symmetry are those of the part as it was read.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.body import LabeledSurface
from models.boundary import labeled_boundary
from models.brep import Brep
from models.brep_json import brep_from_json
from models.freeform_symmetry import symmetry_of_solid
from models.library.field import DistanceField, distance_field
from models.library.pair_table import pair_scores
from models.library.samples import SurfaceSamples, surface_samples
from models.library.thinned import thinned
from models.part import Part
from models.solid import Solid
from models.symmetry import SymmetryGroup
from primitives.arrays import Floats, Ints, frozen

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class RecordConfig:
    """What keeps a record below 200 kB."""

    triangles: int = 2500  # of the stored mesh, about
    chord: float = 0.01  # [mm] by which thinned edges may leave their curves


def record(part: Part, config: RecordConfig | None = None) -> dict[str, NDArray[Any]]:
    """The arrays of a part."""
    config = config or RecordConfig()
    solid = part.solid
    brep, of_triangle = labeled_boundary(solid)
    group = symmetry_of_solid(solid, brep)
    vertices, triangles, label = thinned(solid, of_triangle, config.triangles)
    samples, field = surface_samples(solid), distance_field(solid)
    chord = config.chord
    lines = [_thinned(edge.points, chord) for edge in brep.edges]
    while sum(map(len, lines)) > 3000 and chord < 1.0:
        chord *= 2
        lines = [_thinned(edge.points, chord) for edge in brep.edges]
    told = brep.as_json() | {"vertices_mm": None}
    for fields in told["edges"]:
        del fields["points_mm"]
    text = {
        "faces": len(brep.faces),
        "symmetry": {"name": group.name, "order": group.order if np.isfinite(group.order) else None},
        "volume": solid.volume,
        "area": solid.area,
        "extent": solid.extent.tolist(),
        "field": [field.spacing, field.step],
        "watertight": bool((solid.neighbors >= 0).all()),
        "warnings": [*part.warnings, *brep.check()],
    }
    none = np.full(3, np.nan)
    return {
        "text": np.frombuffer(json.dumps(text, separators=(",", ":")).encode(), np.uint8),
        "brep": np.frombuffer(zlib.compress(json.dumps(told, separators=(",", ":")).encode()), np.uint8),
        "vertices": np.asarray(vertices, np.float32),
        "triangles": np.asarray(triangles, np.uint16 if len(vertices) < 65536 else np.uint32),
        "label": np.asarray(label, np.uint16),
        "corners": brep.vertices,
        "lines": np.concatenate(lines).astype(np.float32) if lines else np.empty((0, 3), np.float32),
        "line_ends": np.cumsum([len(line) for line in lines], dtype=np.int32),
        "rotations": group.rotations,
        "axis": np.stack([group.center, none if group.axis is None else group.axis]),
        "sample_points": samples.points.astype(np.float32),
        "sample_normals": samples.normals.astype(np.float32),
        "sample_face": samples.face.astype(np.uint16),
        "sample_area": samples.area.astype(np.float32),
        "sample_curvatures": samples.curvatures.astype(np.float32),
        "pairs": pair_scores(samples),
        "field": field.values,
        "field_origin": field.origin,
    }


def text_of(arrays: Arrays) -> dict[str, Any]:
    """What is no array."""
    told: dict[str, Any] = json.loads(arrays["text"].tobytes())
    return told


def brep_of(arrays: Arrays) -> Brep:
    """The boundary."""
    told = json.loads(zlib.decompress(arrays["brep"].tobytes()))
    told["vertices_mm"] = arrays["corners"]
    lines = np.split(arrays["lines"].astype(float), arrays["line_ends"][:-1])
    for fields, points in zip(told["edges"], lines, strict=False):
        fields["points_mm"] = points
        if fields["vertices"] is not None:
            points[[0, -1]] = arrays["corners"][fields["vertices"]]
    return brep_from_json(told)


def solid_of(arrays: Arrays, brep: Brep) -> Solid:
    """The solid, each triangle standing for its face's surface."""
    surfaces = tuple(LabeledSurface(face.shape, face.convex, -1) for face in brep.faces)
    triangles: Ints = arrays["triangles"].astype(np.int64)
    label: Ints = arrays["label"].astype(np.int64)
    return Solid.from_labeled(arrays["vertices"].astype(float), triangles, label, surfaces)


def symmetry_of(arrays: Arrays) -> SymmetryGroup:
    """The rotations that change nothing."""
    told = text_of(arrays)["symmetry"]
    center, axis = arrays["axis"]
    order = np.inf if told["order"] is None else float(told["order"])
    along = None if np.isnan(axis).any() else frozen(axis)
    return SymmetryGroup(told["name"], frozen(arrays["rotations"]), frozen(center), along, order)


def samples_of(arrays: Arrays) -> SurfaceSamples:
    """The samples, their normals of unit length again."""
    normals = arrays["sample_normals"].astype(float)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return SurfaceSamples(
        frozen(arrays["sample_points"].astype(float)),
        frozen(normals),
        frozen(arrays["sample_face"], np.int64),
        frozen(arrays["sample_area"].astype(float)),
        frozen(arrays["sample_curvatures"].astype(float)),
    )


def pairs_of(arrays: Arrays) -> NDArray[np.uint8]:
    """How probable the distance and angles of two of its places are; see `pair_table`."""
    return arrays["pairs"]


def field_of(arrays: Arrays) -> DistanceField:
    """The field, whose nodes stay in the file."""
    spacing, step = text_of(arrays)["field"]
    values = arrays["field"]
    return DistanceField(values, frozen(arrays["field_origin"]), spacing, step)


def _thinned(points: Floats, chord: float) -> Floats:
    """Every k-th of the points, both ends kept: as many as keep the middle of each step within `chord`."""
    best = points
    for stride in (2, 4, 8, 16, 32, 64):
        if len(points) <= stride + 1:
            break
        kept = np.unique(np.append(np.arange(0, len(points), stride), len(points) - 1))
        if len(kept) < 5 and np.allclose(points[0], points[-1]):
            break
        at = np.searchsorted(kept, np.arange(len(points)), side="right") - 1
        at = np.minimum(at, len(kept) - 2)
        start, step = points[kept[at]], points[kept[at + 1]] - points[kept[at]]
        share = np.einsum("ij,ij->i", points - start, step) / np.maximum((step**2).sum(axis=1), 1e-300)
        away = np.linalg.norm(start + np.clip(share, 0, 1)[:, None] * step - points, axis=1)
        if away.max() > chord:
            break
        best = points[kept]
    return best

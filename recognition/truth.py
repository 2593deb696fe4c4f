"""The evaluator: how far a reconstruction is from the object, and the only reader of the object's mesh.

Both surfaces are sampled evenly by area, and every sample is taken to the nearest point of the other surface.
With a the distances from model to truth and b those back (Aspert, Santa-Cruz and Ebrahimi 2002)::

    hausdorff = max(max a, max b),   rms = sqrt((mean a^2 + mean b^2) / 2),   mean = (mean a + mean b) / 2.

A face of the truth is matched to the face of the model on which most of its samples land; faces of the model that
no face of the truth is matched to are extra, and count as wrong.  Faces of the truth that no shape explains, as
lettering or a scan, are not judged; the accuracy is None where that is all of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from models.boundary import labeled_boundary
from models.brep import Face
from models.solid import Solid, iou
from primitives.arrays import Floats, Ints, frozen
from primitives.pose import inverse, quaternion_wxyz, transform_points

_RECOVERED = 30_000  # triangles of a mesh, up to which its faces are looked for


@dataclass(frozen=True)
class TruthOptions:
    """How finely to compare."""

    samples: int = 10_000  # on each surface
    least_face: int = 8  # samples on a face, however small it is


@dataclass(frozen=True)
class Truth:
    """The comparison."""

    iou: float
    hausdorff: float  # [mm]
    surface_rms: float  # [mm]
    surface_mean: float  # [mm]
    face_shape_accuracy: (
        float | None
    )  # share of the area, of the truth and of extra faces, with the right shape
    extent_errors: tuple[float, ...]  # [mm] two for each face of the truth with a match of the same shape
    missed_faces: int | None  # faces of the truth whose match in the model has another shape
    extra_faces: int | None  # faces of the model that are no face's match
    world_from_part: Floats  # (4, 4)

    def as_dict(self) -> dict[str, Any]:
        """As in `summary.json`."""
        errors = self.extent_errors
        return {
            "iou": self.iou,
            "hausdorff_mm": self.hausdorff,
            "surface_rms_mm": self.surface_rms,
            "surface_mean_mm": self.surface_mean,
            "face_shape_accuracy": self.face_shape_accuracy,
            "missed_faces": self.missed_faces,
            "extra_faces": self.extra_faces,
            "extent_error_mm": {
                "median": float(np.median(errors)) if errors else None,
                "max": max(errors) if errors else None,
            },
            "world_from_part": {
                "translation_mm": self.world_from_part[:3, 3].tolist(),
                "quaternion_wxyz": quaternion_wxyz(self.world_from_part).tolist(),
            },
        }


@dataclass(frozen=True)
class LabeledFaces:
    """The faces of a boundary, and which one each triangle of its solid belongs to."""

    faces: tuple[Face, ...]
    of_triangle: Ints  # (t,)

    @staticmethod
    def of(solid: Solid) -> LabeledFaces:
        """Those that a tree or file tells, or a mesh's triangles; a huge mesh is one face without a shape."""
        if solid.surfaces or len(solid.triangles) <= _RECOVERED:
            brep, of_triangle = labeled_boundary(solid)
            return LabeledFaces(brep.faces, of_triangle)
        whole = Face(0, None, True, solid.area, (0.0, 0.0), ())
        return LabeledFaces((whole,), frozen(np.zeros(len(solid.triangles)), np.int64))


def evaluate(
    model: Solid,
    truth: Solid,
    options: TruthOptions | None = None,
    model_faces: LabeledFaces | None = None,
    truth_faces: LabeledFaces | None = None,
) -> Truth:
    """Compare two solids placed in the world; the faces of a mesh come from whoever recovered them."""
    options = options or TruthOptions()
    mine = model_faces or LabeledFaces.of(model)
    wanted = truth_faces or LabeledFaces.of(truth)
    on_model, _ = sample_surface(model, options, mine)
    on_truth, of_truth = sample_surface(truth, options, wanted)
    a, _ = _nearest(truth, on_model.points)
    b, landed = _nearest(model, on_truth.points)
    matches = _matches(of_truth, mine.of_triangle[landed], len(wanted.faces), len(mine.faces))
    pairs = [(f, mine.faces[m]) for f, m in zip(wanted.faces, matches, strict=True) if f.shape is not None]
    right = [(face, match) for face, match in pairs if _alike(face, match)]
    extra = [face for k, face in enumerate(mine.faces) if k not in set(matches.tolist())]
    judged = sum(face.area for face, _ in pairs) + sum(face.area for face in extra)
    errors = [abs(s - t) for face, match in right for s, t in zip(match.extent, face.extent, strict=True)]
    return Truth(
        iou(model, truth),
        float(max(a.max(), b.max())),
        float(np.sqrt(0.5 * (on_model.mean(a**2) + on_truth.mean(b**2)))),
        float(0.5 * (on_model.mean(a) + on_truth.mean(b))),
        sum(face.area for face, _ in right) / judged if pairs else None,
        tuple(errors),
        len(pairs) - len(right) if pairs else None,
        len(extra) if pairs else None,
        truth.pose,
    )


@dataclass(frozen=True)
class Samples:
    """Points on a surface and the area that each stands for."""

    points: Floats  # (n, 3) [mm]
    area: Floats  # (n,) [mm^2]

    def mean(self, values: Floats) -> float:
        """Over the surface."""
        return float((self.area * values).sum() / self.area.sum())


def sample_surface(solid: Solid, options: TruthOptions, faces: LabeledFaces) -> tuple[Samples, Ints]:
    """Even samples, and the face that each is on: systematic along the area, so every run has the same ones."""
    corners = solid.vertices[solid.triangles]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    points, weights, labels = [], [], []
    total = float(areas.sum())
    for k in range(len(faces.faces)):
        mine = np.flatnonzero(faces.of_triangle == k)
        reached = np.cumsum(areas[mine])
        count = max(options.least_face, round(options.samples * float(reached[-1]) / total))
        at = (np.arange(count) + 0.5) / count * reached[-1]
        chosen = mine[np.minimum(np.searchsorted(reached, at), len(mine) - 1)]
        # the R2 sequence (Roberts 2018) over the unit square, folded onto the triangle
        u, v = np.mod(np.arange(1, count + 1)[:, None] * [0.7548776662466927, 0.5698402909980532], 1.0).T
        over = u + v > 1.0
        u, v = np.where(over, 1.0 - u, u), np.where(over, 1.0 - v, v)
        a, b, c = np.moveaxis(corners[chosen], 1, 0)
        points.append(a + u[:, None] * (b - a) + v[:, None] * (c - a))
        weights.append(np.full(count, reached[-1] / count))
        labels.append(np.full(count, k))
    return Samples(np.concatenate(points), np.concatenate(weights)), np.concatenate(labels)


def _nearest(solid: Solid, points: Floats) -> tuple[Floats, Ints]:
    found = solid.body.tree.nearest(transform_points(inverse(solid.pose), points))
    return found.distance, found.triangle


def _matches(of_truth: Ints, of_model: Ints, wanted: int, have: int) -> Ints:
    """(f,) the model's face for each of the truth's."""
    votes = np.zeros((wanted, have), dtype=np.int64)
    np.add.at(votes, (of_truth, of_model), 1)
    return np.asarray(votes.argmax(axis=1))


def _alike(face: Face, match: Face) -> bool:
    return face.kind == match.kind and face.convex == match.convex

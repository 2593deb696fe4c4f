"""Where exact surfaces meet smoothly, facets of either poke through the other: what that leaves is put right here.

Within the facets' tolerance t of each other, two tangent surfaces of relative curvature k are a band of half-width
sqrt(2 t / k) whose triangles may be of either; the true edge is where the normals are parallel (our derivation)::

    d_1(p) = d_2(p) = 0,  n_1(p) - s n_2(p) = 0,  s = +-1

`absorbed` gives islands in the band to the face that they lie on, `on_tangents` moves an edge's points there, and
`forward` leaves out those that then run back.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from models.body import Body, LabeledSurface
from models.boundaries.curves import circle_through
from primitives.arrays import Floats, Ints
from primitives.shapes import Shape

_SLACK = 4.0  # facets' tolerances that an island's corners may lie off the face that takes it
_PARALLEL = 0.12  # [rad] between normals of surfaces that may be tangent nearby
_FARTHEST = 0.04  # of the solid's size that a point may move to where they are
_LEVER = 10.0  # [mm] that weighs a normal's direction against a distance
_STEP = 1e-4  # [mm] of the difference quotient


def absorbed(face: Ints, surface: Sequence[LabeledSurface], body: Body) -> Ints:
    """(t,) faces after those that lie on a larger neighbor's surface, to within the facets', have joined it."""
    vertices, triangles, neighbors = body.vertices, body.triangles, body.neighbors
    slack = _SLACK * _facet_tolerance(body) + 1e-9
    area = np.bincount(face, body.triangle_areas)
    middles = vertices[triangles].mean(axis=1)
    order = np.argsort(face, kind="stable")
    begin = np.searchsorted(face[order], np.arange(len(area) + 1))
    out = face.copy()
    for f in np.argsort(area, kind="stable").tolist():
        mine = order[begin[f] : begin[f + 1]]
        samples = np.concatenate([middles[mine], vertices[np.unique(triangles[mine])]])
        beside, shared = np.unique(out[neighbors[mine]], return_counts=True)
        for g in beside[np.argsort(-shared, kind="stable")].tolist():
            shape = surface[g].shape
            if area[g] <= area[f] or shape is None or g == f:
                continue
            if np.abs(shape.signed_distance(samples)).max() < slack:
                out[mine] = g
                break
    return out


def on_tangents(points: Floats, shapes: Sequence[Shape], size: float) -> Floats | None:
    """(n, 3) points moved to where surfaces that are nearly parallel there touch; None where no two are."""
    pairs = [
        (i, j, sign)
        for i, j in combinations(range(len(shapes)), 2)
        if (sign := _parallel(points, shapes[i], shapes[j])) != 0
    ]
    if not pairs:
        return None
    moved = points
    for _ in range(6):
        value = _residual(moved, shapes, pairs)
        slopes = [(_residual(moved + _STEP * step, shapes, pairs) - value) / _STEP for step in np.eye(3)]
        moved = moved - (np.linalg.pinv(np.stack(slopes, axis=2), rcond=1e-2) @ value[..., None])[..., 0]
    left = np.abs(_residual(moved, shapes, pairs)).max(axis=1)
    good = (left < 1e-3) & (np.linalg.norm(moved - points, axis=1) < _FARTHEST * size)
    return moved if good.all() else None


def forward(points: Floats, tolerance: float) -> Ints:
    """Which of (n, 3) points along a line or a circle run on from all before; all of them along another curve."""
    everything = np.arange(len(points))
    chord = points[-1] - points[0]
    span = float(np.linalg.norm(chord))
    along = (points - points[0]) @ chord / max(span, 1e-300)
    if span <= tolerance or np.abs(points - points[0] - np.outer(along, chord / span)).max() > tolerance:
        if len(points) < 4:
            return everything
        center, radius, frame = circle_through(points)
        x, y, z = ((points - center) @ frame.T).T
        if np.hypot(np.hypot(x, y) - radius, z).max() > tolerance:
            return everything
        along = radius * np.unwrap(np.arctan2(y, x))
        along = (along - along[0]) * np.sign(along[-1] - along[0])
        if along[-1] <= tolerance:  # closed, and not round the middle of the circle
            return everything
    before = np.maximum.accumulate(np.concatenate([[0.0], along[:-1]]))
    kept = (along > before + 1e-9) & (along < along[-1] - 1e-9)
    kept[[0, -1]] = True
    return np.flatnonzero(kept)


def _facet_tolerance(body: Body) -> float:
    """How far any triangle's corner lies off the surface that the triangle stands for [mm]."""
    worst = 0.0
    for label in np.unique(body.face_of_triangle):
        shape = body.surfaces[label].shape if label >= 0 else None
        if shape is not None and shape.kind != "plane":
            corners = body.vertices[np.unique(body.triangles[body.face_of_triangle == label])]
            worst = max(worst, float(np.abs(shape.signed_distance(corners)).max()))
    return worst


def _parallel(points: Floats, a: Shape, b: Shape) -> int:
    """1 or -1 where two surfaces' normals are nearly alike or opposite at all points; else 0."""
    if a.kind == b.kind == "plane":
        return 0
    cosine = np.einsum("ij,ij->i", a.normals(points), b.normals(points))
    least = np.cos(_PARALLEL)
    return 1 if (cosine > least).all() else -1 if (cosine < -least).all() else 0


def _residual(points: Floats, shapes: Sequence[Shape], pairs: list[tuple[int, int, int]]) -> Floats:
    distances = [shape.signed_distance(points)[:, None] for shape in shapes]
    normals = [shape.normals(points) for shape in shapes]
    turned = [_LEVER * (normals[i] - sign * normals[j]) for i, j, sign in pairs]
    return np.concatenate([*distances, *turned], axis=1)

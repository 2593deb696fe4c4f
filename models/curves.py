"""The runs of mesh edges between two faces, and the curves that they stand for."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from models.body import LabeledSurface
from models.brep import Curve, Edge, Kind
from primitives.arrays import Floats, Ints, frozen


class Chain(NamedTuple):
    """A run of mesh edges between two faces."""

    faces: tuple[int, int]  # the first is on the left
    vertices: tuple[int, ...]  # the first again at the end where it is closed
    closed: bool  # a rim: no other face meets it anywhere


def chains(triangles: Ints, neighbors: Ints, face: Ints) -> list[Chain]:
    """All runs between different faces; they break where other than two boundary edges meet."""
    rows, sides = np.nonzero((face[neighbors] != face[:, None]) & (face[:, None] < face[neighbors]))
    start, end = triangles[rows, sides], triangles[rows, (sides + 1) % 3]
    left, right = face[rows], face[neighbors[rows, sides]]
    valence = np.bincount(np.concatenate([start, end]))
    leaving: dict[tuple[int, int, int], list[int]] = defaultdict(list)
    for a, b, f, g in zip(start.tolist(), end.tolist(), left.tolist(), right.tolist(), strict=True):
        leaving[f, g, a].append(b)
    out = [
        _follow(leaving, key, valence)
        for key in sorted(leaving, key=lambda k: (k[0], k[1]))
        for _ in range(len(leaving[key]) if valence[key[2]] != 2 else 0)
    ]
    out += [_follow(leaving, key, valence) for key in sorted(leaving) if leaving[key]]
    return sorted(out, key=lambda chain: chain.faces)


def _follow(
    leaving: dict[tuple[int, int, int], list[int]], key: tuple[int, int, int], valence: Ints
) -> Chain:
    f, g, first = key
    run = [first]
    while True:
        run.append(leaving[f, g, run[-1]].pop())
        if valence[run[-1]] != 2 or run[-1] == first:
            return Chain((f, g), tuple(run), bool(valence[first] == 2))


def edge_between(
    number: int,
    faces: tuple[int, int],
    points: Floats,
    ends: tuple[int, int] | None,
    left: LabeledSurface,
    right: LabeledSurface,
    smooth_deg: float,
    on_curve: float,
) -> Edge:
    """The edge along (n, 3) exact points between two surfaces, the first on its left."""
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    middle = (points[1:] + points[:-1]) / 2
    a, b = (s.shape.normals(middle) * (1.0 if s.convex else -1.0) for s in (left, right))
    along = steps / np.maximum(lengths, 1e-300)[:, None]
    sine, cosine = np.einsum("ij,ij->i", np.cross(a, b), along), np.einsum("ij,ij->i", a, b)
    turn = _weighted_median(np.rad2deg(np.arctan2(sine, cosine)), lengths)
    kind: Kind = "smooth" if abs(turn) < smooth_deg else "convex" if turn > 0 else "concave"
    curve, length = curve_of(points, on_curve)
    return Edge(number, faces, kind, curve, length, 180.0 - turn, frozen(points), ends)


def curve_of(points: Floats, tolerance: float) -> tuple[Curve, float]:
    """Whether (n, 3) points run along a line or a circle, within `tolerance` [mm], and how long they run."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    length = float(steps.sum())
    chord = points[-1] - points[0]
    span = float(np.linalg.norm(chord))
    if span > tolerance:
        off = points - points[0] - np.outer((points - points[0]) @ chord / span**2, chord)
        if float(np.linalg.norm(off, axis=1).max()) < tolerance:
            return "line", span
    if len(points) < 4:
        return "other", length
    center, radius, plane = _circle(points)
    flat = (points - center) @ plane.T
    off_circle = np.hypot(np.hypot(flat[:, 0], flat[:, 1]) - radius, flat[:, 2])
    if float(off_circle.max()) > tolerance:
        return "other", length
    return "circle", radius * float(2 * np.arcsin(np.clip(steps / (2 * radius), 0, 1)).sum())


def refined(edge: Edge, parts: int = 8) -> Floats:
    """(m, 3) points along an edge, a circle's closer together and still on it."""
    if edge.curve != "circle":
        return edge.points
    center, radius, _ = _circle(edge.points)
    share = np.arange(parts)[:, None, None] / parts
    chords = edge.points[:-1] * (1 - share) + edge.points[1:] * share - center
    on_circle: Floats = center + radius * chords / np.linalg.norm(chords, axis=2, keepdims=True)
    return np.concatenate([on_circle.reshape(-1, 3), edge.points[-1:]])


def loops_of(face: int, edges: list[Edge]) -> tuple[tuple[int, ...], ...]:
    """The closed runs of edges round a face, each with the face on its left."""
    rims = [(edge.id,) for edge in edges if edge.vertices is None]
    leaving: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for edge in edges:
        if edge.vertices is not None:
            start, end = edge.vertices if edge.faces[0] == face else edge.vertices[::-1]
            leaving[start].append((edge.id, end))
    runs: list[tuple[int, ...]] = []
    for first in sorted(leaving):
        while leaving[first]:
            run: list[int] = []
            at = first
            while leaving[at] and (at != first or not run):
                edge_id, at = leaving[at].pop()
                run.append(edge_id)
            runs.append(tuple(run))
    return (*rims, *runs)


def _circle(points: Floats) -> tuple[Floats, float, Floats]:
    """Center (3,), radius and frame rows (3, 3), the normal last, of the least-squares circle (Kasa 1976)."""
    middle = points.mean(axis=0)
    frame = np.linalg.svd(points - middle)[2]
    flat = (points - middle) @ frame.T
    system = np.column_stack([2 * flat[:, :2], np.ones(len(flat))])
    x, y, c = np.linalg.lstsq(system, (flat[:, :2] ** 2).sum(axis=1), rcond=None)[0]
    radius = float(np.sqrt(max(c + x * x + y * y, 1e-300)))
    center: Floats = middle + x * frame[0] + y * frame[1]
    return center, radius, frame


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, share[-1] / 2)])

"""The runs of mesh edges between two faces, and the curves that they stand for."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np

from models.brep import Curve, Edge, Kind
from primitives.arrays import Floats, Ints, frozen


class Chain(NamedTuple):
    """A run of mesh edges between two faces."""

    faces: tuple[int, int]  # the first is on the left
    vertices: tuple[int, ...]  # the first again at the end where it is closed
    triangles: tuple[tuple[int, int], ...]  # left and right of each step
    closed: bool  # a rim: no other face meets it anywhere


_THROUGH = 0.05  # of its radius from a circle's center, within which a chord passes through it
_Step = tuple[int, int, int]  # where it ends, triangles left and right


def chains(triangles: Ints, neighbors: Ints, face: Ints) -> list[Chain]:
    """All runs between different faces; they break where other than two boundary edges meet."""
    rows, sides = np.nonzero((face[neighbors] != face[:, None]) & (face[:, None] < face[neighbors]))
    start, end = triangles[rows, sides], triangles[rows, (sides + 1) % 3]
    beyond = neighbors[rows, sides]
    valence = np.bincount(np.concatenate([start, end]))
    leaving: dict[tuple[int, int, int], list[_Step]] = defaultdict(list)
    columns = (start, end, face[rows], face[beyond], rows, beyond)
    for a, b, f, g, left, right in zip(*(column.tolist() for column in columns), strict=True):
        leaving[f, g, a].append((b, left, right))
    out = [
        _follow(leaving, key, valence)
        for key in sorted(leaving, key=lambda k: (k[0], k[1]))
        for _ in range(len(leaving[key]) if valence[key[2]] != 2 else 0)
    ]
    out += [_follow(leaving, key, valence) for key in sorted(leaving) if leaving[key]]
    return sorted(out, key=lambda chain: chain.faces)


def _follow(
    leaving: dict[tuple[int, int, int], list[_Step]], key: tuple[int, int, int], valence: Ints
) -> Chain:
    f, g, first = key
    run, beside = [first], []
    while True:
        end, left, right = leaving[f, g, run[-1]].pop()
        run.append(end)
        beside.append((left, right))
        if valence[end] != 2 or end == first:
            return Chain((f, g), tuple(run), tuple(beside), bool(valence[first] == 2))


def edge_between(
    number: int,
    faces: tuple[int, int],
    points: Floats,
    ends: tuple[int, int] | None,
    normals: tuple[Floats, Floats],
    smooth_deg: float,
    on_curve: float,
) -> Edge:
    """The edge along (n, 3) exact points with (n - 1, 3) outward normals of either face, the first on its left."""
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    a, b = normals
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
    center, radius, plane = circle_through(points)
    flat = (points - center) @ plane.T
    off_circle = np.hypot(np.hypot(flat[:, 0], flat[:, 1]) - radius, flat[:, 2])
    if float(off_circle.max()) > tolerance:
        return "other", length
    return "circle", radius * float(2 * np.arcsin(np.clip(steps / (2 * radius), 0, 1)).sum())


def refined(edge: Edge, parts: int = 8) -> Floats:
    """(m, 3) points along an edge, in order, a circle's closer together and still on it.

    A chord through its center does not say which way round the circle goes.
    """
    if edge.curve != "circle":
        return edge.points
    center, radius, _ = circle_through(edge.points)
    share = np.arange(parts)[:, None] / parts
    chords = edge.points[:-1, None] * (1 - share) + edge.points[1:, None] * share - center
    away = np.linalg.norm(chords, axis=2, keepdims=True)
    if float(away.min()) < _THROUGH * radius:
        return edge.points
    on_circle: Floats = center + radius * chords / away
    return np.concatenate([on_circle.reshape(-1, 3), edge.points[-1:]])


def loops(pieces: list[Chain], triangles: Ints, neighbors: Ints, face: Ints) -> list[list[tuple[int, ...]]]:
    """For each face the closed runs of chains round it, each with the face on its left.

    What follows a chain is found by turning round its end through the face's own triangles, so that loops which
    touch at a vertex stay apart.
    """
    leaving: dict[
        tuple[int, int], int
    ] = {}  # first half-edge of a chain from either side: (triangle, vertex)
    arriving: list[tuple[int, int]] = []
    for piece in pieces:
        for side in (0, 1):
            order = 1 if side == 0 else -1
            run, beside = piece.vertices[::order], piece.triangles[::order]
            leaving[beside[0][side], run[0]] = len(arriving)
            arriving.append((beside[-1][side], run[-1]))
    out: list[list[tuple[int, ...]]] = [[] for _ in range(int(face.max()) + 1)]
    unused = set(range(len(arriving)))
    while unused:
        first = at = min(unused)
        run_of_chains: list[int] = []
        while at in unused:
            unused.remove(at)
            run_of_chains.append(at // 2)
            if pieces[at // 2].closed:
                break
            at = leaving[_next_rim(*arriving[at], triangles, neighbors, face)]
        out[pieces[first // 2].faces[first % 2]].append(tuple(run_of_chains))
    return out


def _next_rim(triangle: int, vertex: int, triangles: Ints, neighbors: Ints, face: Ints) -> tuple[int, int]:
    """The triangle of the same face whose side that leaves the vertex is on the face's rim."""
    while True:
        beyond = int(neighbors[triangle, triangles[triangle].tolist().index(vertex)])
        if face[beyond] != face[triangle]:
            return triangle, vertex
        triangle = beyond


def handles(face: Ints, triangles: Ints, neighbors: Ints, loops_of_face: list[int]) -> list[int]:
    """How many handles each face has: Euler's count of its triangles is 2 - loops - 2 handles."""
    count = len(loops_of_face)
    rim = face[neighbors] != face[:, None]
    sides = np.bincount(face, rim.sum(axis=1), count)
    rows, corners = np.nonzero(rim)
    on_rim = np.unique(np.concatenate([triangles[rows, corners], triangles[rows, (corners + 1) % 3]]))
    inner = np.unique(triangles.ravel(), return_index=True)
    owner = np.repeat(face, 3)[inner[1][~np.isin(inner[0], on_rim)]]
    euler = np.bincount(owner, minlength=count) + (sides - np.bincount(face, minlength=count)) / 2
    return [round((2 - n - e) / 2) for n, e in zip(loops_of_face, euler.tolist(), strict=True)]


def circle_through(points: Floats) -> tuple[Floats, float, Floats]:
    """Center (3,), radius and frame rows (3, 3), the normal last, of the least-squares circle (Kasa 1976)."""
    middle = points.mean(axis=0)
    frame = np.linalg.svd(points - middle, full_matrices=False)[2]
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

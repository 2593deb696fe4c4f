"""Edges too short to be any are made the vertex that their ends are.

Where four tangent faces meet in one point, as at the corners of a rounded block, facets leave two vertices with an
edge between them.  Taking it away with one of the vertices leaves Euler's count as it was (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from models.brep import Edge
from primitives.arrays import Floats, Ints, frozen

Runs = list[list[tuple[int, ...]]]


def without_short_edges(
    edges: Sequence[Edge], loops: Runs, vertices: Floats, least: float
) -> tuple[tuple[Edge, ...], Runs, Floats]:
    """The edges, the loops of each face and the (v, 3) vertices, edges not longer than `least` [mm] gone."""
    left = [[len(loop) for loop in runs] for runs in loops]
    where: list[list[tuple[int, int]]] = [[] for _ in edges]
    for face, runs in enumerate(loops):
        for number, loop in enumerate(runs):
            for i in loop:
                where[i].append((face, number))
    one = np.arange(len(vertices))
    gone: set[int] = set()
    for edge in edges:
        if edge.vertices is None or edge.length > least:
            continue
        a, b = sorted(int(one[v]) for v in edge.vertices)
        around = where[edge.id]
        if a == b or any(left[face][number] <= around.count((face, number)) for face, number in around):
            continue
        one[one == b] = a
        gone.add(edge.id)
        for face, number in around:
            left[face][number] -= 1
    if not gone:
        return tuple(edges), loops, vertices
    kept, number_of = np.unique(one, return_inverse=True)
    place = {old: new for new, old in enumerate(edge.id for edge in edges if edge.id not in gone)}
    points = vertices[kept]
    short = tuple(_moved(e, place[e.id], number_of.reshape(-1), points) for e in edges if e.id in place)
    runs_left = [[tuple(place[e] for e in loop if e in place) for loop in runs] for runs in loops]
    return short, runs_left, points


def _moved(edge: Edge, number: int, vertex_of: Ints, vertices: Floats) -> Edge:
    """The edge under its new number, its ends on the vertices that are left."""
    if edge.vertices is None:
        return replace(edge, id=number)
    first, last = (int(vertex_of[v]) for v in edge.vertices)
    points = edge.points.copy()
    points[0], points[-1] = vertices[first], vertices[last]
    return replace(edge, id=number, vertices=(first, last), points=frozen(points))

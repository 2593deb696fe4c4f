"""Whether two boundaries are put together alike, whatever their sizes: the same graph of shapes, edges and curves.

Colors are refined over both graphs; where nodes remain alike (a plate's equal holes), one is singled out in
the first graph and tried against its like in the second, and colors are refined again.  On boundaries nearly
every choice among nodes that look alike is right, or a wrong one shows at once; a budget keeps what could be
exponential from being so, and says so where it is spent.  Mirror images are alike here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.brep import Brep
from models.comparison.incidence import Colors, Incidence, incidence, joined, mixed, refined
from primitives.arrays import Ints


@dataclass(frozen=True)
class IsomorphismConfig:
    """How long to look."""

    most_trials: int = 20_000  # refinements, before the answer is `undecided`


@dataclass(frozen=True, eq=False)
class Isomorphism:
    """Which face, edge and vertex of the second boundary each of the first's answers to."""

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    vertices: tuple[int, ...]


@dataclass(frozen=True)
class Different:
    """Why two boundaries are not the same; false in a condition."""

    reason: str

    def __bool__(self) -> bool:
        return False


def same_topology(a: Brep, b: Brep, config: IsomorphismConfig | None = None) -> Isomorphism | Different:
    """Whether faces, edges and vertices answer to each other one to one, by shape, convexity, kind and curve."""
    left, right = incidence(a), incidence(b)
    if reason := counted(left, right):
        return Different(reason)
    links, half = joined(left, right), left.nodes
    start = refined(np.concatenate([left.labels, right.labels]), links)
    if not _balanced(start, half):
        return Different("faces of the same shapes meet in other ways")
    known = {(int(i), int(j)) for i, j in right.links}
    stack: list[tuple[Colors, int, int]] = [(start, -1, -1)]
    for _ in range((config or IsomorphismConfig()).most_trials):
        if not stack:
            return Different("faces of the same shapes meet in other ways")
        colors, one, other = stack.pop()
        if one >= 0:
            colors = _singled_out(colors, one, other, links)
            if not _balanced(colors, half):
                continue
        open_class = _least_open_class(colors, half)
        if open_class is not None:
            mine, theirs = open_class
            stack += [(colors, int(mine[0]), int(node)) for node in theirs[::-1]]
        elif answers := _verified(colors, left, known):
            return answers
    return Different("undecided: too many faces look alike")


def counted(left: Incidence, right: Incidence, labels: bool = True) -> str:
    """What is there in another number; empty if nothing is."""
    pairs = (
        ("faces", left.faces, right.faces),
        ("edges", left.edges, right.edges),
        ("vertices", left.vertices, right.vertices),
    )
    for name, mine, theirs in pairs:
        if mine != theirs:
            return f"{mine} {name} against {theirs}"
    if left.nodes != right.nodes or len(left.links) != len(right.links):
        return "the faces have another number of loops"
    if labels and not np.array_equal(np.sort(left.labels), np.sort(right.labels)):
        return "faces or edges of other kinds"
    return ""


def _singled_out(colors: Colors, one: int, other: int, links: Ints) -> Colors:
    marked = colors.copy()
    marked[[one, other]] = mixed(mixed(marked[[one, other]]))
    return refined(marked, links)


def _balanced(colors: Colors, half: int) -> bool:
    return np.array_equal(np.sort(colors[:half]), np.sort(colors[half:]))


def _least_open_class(colors: Colors, half: int) -> tuple[Ints, Ints] | None:
    found, counts = np.unique(colors[:half], return_counts=True)
    if not (counts > 1).any():
        return None
    color = found[np.argmin(np.where(counts > 1, counts, len(colors)))]
    return np.flatnonzero(colors[:half] == color), half + np.flatnonzero(colors[half:] == color)


def _verified(colors: Colors, left: Incidence, known: set[tuple[int, int]]) -> Isomorphism | None:
    half = left.nodes
    answer = np.empty(half, dtype=np.int64)
    answer[np.argsort(colors[:half])] = np.argsort(colors[half:])
    if any((int(i), int(j)) not in known for i, j in answer[left.links]):
        return None
    first_edge, first_vertex = left.faces, left.faces + left.edges
    return Isomorphism(
        tuple(answer[:first_edge].tolist()),
        tuple((answer[first_edge:first_vertex] - first_edge).tolist()),
        tuple((answer[first_vertex : first_vertex + left.vertices] - first_vertex).tolist()),
    )

"""A hashable signature of a boundary, for finding equal objects without comparing all pairs.

The topology is exact: equal for equal objects, unless an edge or face stands on a threshold (smooth or convex,
line or circle) and two makers call it differently.  Totals are rounded, and no rounding gives all equal objects
equal cells; so an entry is stored under its one `signature`, and looked up under all of `probes`, the cells
that its totals could fall into: within the error given, the right one is among them.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import product

import numpy as np

from models.brep import Brep
from models.comparison.incidence import digest, incidence, refined

CELL = 0.02  # relative width of a cell of totals


@dataclass(frozen=True)
class Signature:
    """Equal for equal objects, up to the rounding of `cells`."""

    counts: tuple[tuple[str, int], ...]  # faces of each shape, edges, vertices
    topology: str  # digest of the refined graph of faces, loops, edges and vertices
    cells: tuple[int, int]  # logarithms of area and of edges' length, in steps of CELL


def signature(brep: Brep) -> Signature:
    """The signature under which to store a boundary."""
    return Signature(_counts(brep), topology(brep), tuple(int(np.floor(x)) for x in _logs(brep)))  # type: ignore[arg-type]


def probes(brep: Brep, error: float = 0.002) -> frozenset[Signature]:
    """All signatures of objects whose area and edges' length are those of `brep` within `error` of each."""
    ranges = [sorted({int(np.floor(x - error / CELL)), int(np.floor(x + error / CELL))}) for x in _logs(brep)]
    same = _counts(brep), topology(brep)
    return frozenset(Signature(*same, (i, j)) for i, j in product(*ranges))


def topology(brep: Brep) -> str:
    """Equal for boundaries that are put together alike; differs for most that are not."""
    graph = incidence(brep)
    return digest(refined(graph.labels, graph.links))


def _counts(brep: Brep) -> tuple[tuple[str, int], ...]:
    kinds = Counter(face.kind for face in brep.faces)
    return (*sorted(kinds.items()), ("edges", len(brep.edges)), ("vertices", len(brep.vertices)))


def _logs(brep: Brep) -> tuple[float, float]:
    area, length = sum(f.area for f in brep.faces), sum(e.length for e in brep.edges)
    return float(np.log(max(area, 1e-12)) / CELL), float(np.log(max(length, 1e-12)) / CELL)

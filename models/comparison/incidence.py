"""A boundary as a plain graph of faces, loops, edges and vertices, and the coarsest coloring of such graphs.

Refinement (Weisfeiler and Leman 1968) gives nodes one color while they, their neighbors, their neighbors'
neighbors ... look alike; graphs whose colors differ in number are not isomorphic.  Colors are 64-bit hashes of
what was seen, the same in every run and for every order of the nodes, so they can be stored and compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from models.brep import Brep
from primitives.arrays import Ints, frozen

Colors = NDArray[np.uint64]
_STEP, _FIRST, _SECOND = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
)


@dataclass(frozen=True, eq=False)
class Incidence:
    """Nodes are the faces, then the edges, the vertices and the loops; a link says that one bounds the other."""

    faces: int
    edges: int
    vertices: int
    links: Ints  # (m, 2) nodes; face-loop, loop-edge, edge-vertex
    labels: Colors  # (n,) hash of what each node is: shape and convexity, kind and curve

    @property
    def nodes(self) -> int:
        """How many."""
        return len(self.labels)


def incidence(brep: Brep) -> Incidence:
    """The graph of a boundary, labeled with what has no size."""
    names: list[tuple[object, ...]] = [("face", f.kind, f.convex, f.handles) for f in brep.faces]
    names += [("edge", e.kind, e.curve, e.vertices is None) for e in brep.edges]
    names += [("vertex",)] * len(brep.vertices)
    first_edge, first_vertex = len(brep.faces), len(brep.faces) + len(brep.edges)
    links: list[tuple[int, int]] = []
    for face in brep.faces:
        for loop in face.loops:
            links.append((face.id, len(names)))
            links += [(len(names), first_edge + edge) for edge in loop]
            names.append(("loop",))
    for edge in brep.edges:
        links += [(first_edge + edge.id, first_vertex + v) for v in set(edge.vertices or ())]
    known = {name: _hash_of(repr(name)) for name in set(names)}
    labels = np.array([known[name] for name in names], dtype=np.uint64)
    return Incidence(
        len(brep.faces),
        len(brep.edges),
        len(brep.vertices),
        frozen(np.reshape(np.array(links, dtype=np.int64), (-1, 2)), np.int64),
        frozen(labels, np.uint64),
    )


def joined(a: Incidence, b: Incidence) -> Ints:
    """(m, 2) links of both graphs side by side, the second's nodes counted on from the first's."""
    return np.concatenate([a.links, b.links + a.nodes])


def refined(colors: Colors, links: Ints) -> Colors:
    """(n,) colors after as many rounds as tell more nodes apart; equal nodes keep equal colors."""
    ends = np.concatenate([links, links[:, ::-1]])
    count = len(np.unique(colors))
    while True:
        seen = np.zeros(len(colors), dtype=np.uint64)
        np.add.at(seen, ends[:, 0], mixed(colors[ends[:, 1]]))
        colors = mixed(colors * _FIRST + mixed(seen))
        found = len(np.unique(colors))
        if found == count:
            return colors
        count = found


def combined(*columns: NDArray[np.int64] | Colors) -> Colors:
    """(n,) one hash for each row of integers."""
    out = np.zeros(len(columns[0]), dtype=np.uint64)
    for column in columns:
        out = mixed(out * _FIRST + mixed(column.astype(np.uint64)))
    return out


def mixed(values: Colors) -> Colors:
    """The values scattered over 64 bits (splitmix64; Steele, Lea and Flood 2014)."""
    z = values + _STEP
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


def digest(colors: Colors) -> str:
    """The multiset of colors as text."""
    return blake2b(np.sort(colors).tobytes(), digest_size=12).hexdigest()


def _hash_of(text: str) -> int:
    return int.from_bytes(blake2b(text.encode(), digest_size=8).digest(), "little")

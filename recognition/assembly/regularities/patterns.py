"""Like cylinders in a row or round an axis, as bolt holes are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import networkx
import numpy as np
from scipy.spatial import KDTree

from primitives.arrays import Floats, Ints
from primitives.pose import frame_along, rotation_exp
from primitives.shapes import Cylinder, Shape
from recognition.assembly.regularities.relation import Proposal
from recognition.assembly.regularities.state import State

_MOST = 12  # places round a center
_ROWS = 3  # through one place: along, across and aslant
_ONE_WAY = 0.99  # cosine between rows from which they are one


def evenly_spaced(state: State) -> list[Proposal]:
    """Of each family the nearest neighbors that lie in a row, and those round one axis by equal turns."""
    found: list[Proposal] = []
    for family in _families(state):
        axis = state.shape(family[0]).direction
        places = np.array([state.shape(i).anchor for i in family]) @ frame_along(axis)[:, :2]
        for middle, pair in _rows(places, state.options.reach):
            found += _even(state, axis, (family[middle], *(family[k] for k in pair)), 2)
        for center in _centers(state, family):
            away = places - state.shape(center).anchor @ frame_along(axis)[:, :2]
            for ring in _rings(away, state.options.reach):
                around = list(zip(ring, np.roll(ring, -1), strict=True))
                for pair in around if len(ring) > 2 else around[:1]:
                    found += _even(state, axis, (center, *(family[k] for k in pair)), len(ring))
    return found


def _families(state: State) -> list[list[int]]:
    """Parallel cylinders, all solid or all hollow, whose radii differ by less than the reach; one of an axis."""
    like, shapes = networkx.Graph(), state.shapes()
    rounds = [i for i, shape in enumerate(shapes) if isinstance(shape, Cylinder)]
    first = [
        i
        for i in rounds
        if not any(state.has("coaxial", (j, i)) and _like(state, j, i) for j in rounds if j < i)
    ]
    like.add_edges_from((i, j) for i in first for j in first if i < j and _like(state, i, j))
    return sorted(sorted(group) for group in networkx.connected_components(like))


def _like(state: State, i: int, j: int) -> bool:
    a, b = state.shape(i).sizes[0], state.shape(j).sizes[0]
    near = abs(a - b) < state.options.reach * max(a, b)
    return near and state.convex[i] == state.convex[j] and state.has("parallel", (i, j))


def _centers(state: State, family: Sequence[int]) -> list[int]:
    """Other cylinders along the same way, of each axis one."""
    found: list[int] = []
    for i, shape in enumerate(state.shapes()):
        along = isinstance(shape, Cylinder) and i not in family and state.has("parallel", (i, family[0]))
        if along and not any(state.has("coaxial", (i, other)) for other in (*found, *family)):
            found.append(i)
    return found


def _rows(places: Floats, reach: float) -> Iterator[tuple[int, tuple[int, int]]]:
    """A place in the middle of two others of (n, 2), the nearest such of each way through it."""
    tree = KDTree(places)
    for middle, place in enumerate(places):
        arms = places - place
        far = np.linalg.norm(arms, axis=1)
        off, other = (np.asarray(found) for found in tree.query(place - arms))
        ways: list[Floats] = []
        for k in np.argsort(far):
            m, long = int(other[k]), float(far[k])
            if k == middle or m in (k, middle) or off[k] >= reach * long or len(ways) == _ROWS:
                continue
            if not any(abs(float(arms[k] @ way)) > _ONE_WAY * long for way in ways):
                ways.append(arms[k] / long)
                yield middle, (int(k), m)


def _rings(away: Floats, reach: float) -> Iterator[Ints]:
    """The rows of (n, 2) places about one center that lie about as far from it, in order round it."""
    far = np.linalg.norm(away, axis=1)
    order = np.argsort(far)
    breaks = [k + 1 for k, (a, b) in enumerate(pairwise(order)) if far[b] - far[a] > reach * far[b]]
    for ring in np.split(order, breaks):
        if 2 <= len(ring) <= _MOST and far[ring[0]] > 0.0:
            yield ring[np.argsort(np.arctan2(away[ring, 1], away[ring, 0]))]


def _even(state: State, axis: Floats, faces: tuple[int, ...], count: int) -> list[Proposal]:
    """That of three axes the third is the second, turned about the first by one of `count` equal parts."""
    across, turn = frame_along(axis)[:, :2], rotation_exp(2.0 * np.pi / count * axis)

    def turned(middle: Shape, one: Shape, other: Shape) -> Floats:
        out: Floats = (other.anchor - middle.anchor - turn @ (one.anchor - middle.anchor)) @ across
        return out

    middle, one, other = (state.shape(i) for i in faces)
    room = state.options.reach * float(np.linalg.norm((one.anchor - middle.anchor) @ across))
    near = float(np.linalg.norm(turned(middle, one, other))) < room
    return [Proposal("evenly spaced", faces, turned, 2, 2.0 * room)] if near else []

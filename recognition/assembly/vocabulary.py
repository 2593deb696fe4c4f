"""The primitives that surfaces can bound, each as the cells that it holds.

A box takes a slab of each of three perpendicular directions; a slab lies between two parallel planes, or ends at
one and is open beyond.  Round surfaces take a slab along their axis, a ring the sides of one or two planes through
its axis, which leave a bend of it.  A conjunction of sides of planes that is
neither is a prism or a polyhedron; those are grown from one cell, dropping side after side while that pays.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, groupby

import numpy as np

from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.pose import frame_along
from primitives.shapes import Cylinder, Plane, Shape, Sphere, Torus
from recognition.assembly.arrangement import distinct_rows
from recognition.assembly.step_kernels import cumulative, greatest_boxes, kept_sides, lot_sums

_PARALLEL = 1e-3  # [rad] within which directions are one
_KEPT = 1024  # candidates whose cells are remembered: a list is replayed with one of them changed
_ACROSS = 0.02  # [rad] from upright on a round surface's axis, within which a plane ends it
_THROUGH = 0.1  # of a tube's radius, within which a plane runs through its ring's axis
_CROSSED = 0.998  # most cosine between two planes through a ring's axis, that leave a bend between them
Slab = tuple[int | None, int | None]  # the planes below and above, None where it is open
Axes = tuple[int | None, int | None, int | None]  # indices of directions


@dataclass(frozen=True)
class Candidate:
    """One primitive: a round surface with its slab, a box of three slabs, or sides of planes."""

    kind: str  # "cube", "cylinder", "cone", "sphere", "torus" or "prism" (of any sides)
    body: int | None = None
    frame: int | None = None  # index of the box's frame
    slabs: tuple[Slab, ...] = ()
    sides: tuple[tuple[int, bool], ...] = ()  # of a prism or a ring: planes, and whether it lies outside each

    @property
    def price(self) -> float:
        """In leaves: what a person would rather not read costs more."""
        return (
            1.0 + 0.1 * len(self.sides) if self.kind != "prism" else 1.2 + 0.1 * max(0, len(self.sides) - 3)
        )


@dataclass(frozen=True)
class Direction:
    """Parallel planes in order."""

    axis: Floats  # (3,)
    planes: tuple[int, ...]  # by rising height along the axis
    bin: Ints  # (c,) how many of them each cell lies above


class Vocabulary:
    """All candidates over the cells of an arrangement."""

    def __init__(self, shapes: Sequence[Shape], outside: Bools) -> None:
        self.shapes, self.outside = shapes, outside
        self.directions = _directions(shapes, outside)
        self.frames = list(_frames(self.directions))
        self._bins = [self._bins_of(axes) for axes in self.frames]
        self._held = lru_cache(maxsize=_KEPT)(self._held_by)
        self._round = list(self._round_candidates())
        self._lots, self._held_lots = self._alike_cells()
        self._planes = [i for i, shape in enumerate(shapes) if isinstance(shape, Plane)]
        self._beyond = frozen(outside[:, self._planes], bool)

    def _bins_of(self, axes: Axes) -> Ints:
        """(c, 3) the bin of each cell along three directions, 0 along none."""
        none = np.zeros(len(self.outside), dtype=np.int64)
        return frozen(
            np.stack([none if k is None else self.directions[k].bin for k in axes], axis=1), np.int64
        )

    def mask(self, candidate: Candidate) -> Bools:
        """(c,) the cells that a candidate holds."""
        return self._held(candidate)

    def _held_by(self, candidate: Candidate) -> Bools:
        inside = np.ones(len(self.outside), dtype=bool)
        if candidate.body is not None:
            inside &= ~self.outside[:, candidate.body]
        for plane, out in candidate.sides:
            inside &= self.outside[:, plane] == out
        if candidate.kind == "cube":
            assert candidate.frame is not None
            axes = self.frames[candidate.frame]
            for axis, slab in zip(axes, candidate.slabs, strict=True):
                if axis is not None:
                    inside &= _within(self.directions[axis], slab)
        elif candidate.slabs and candidate.body is not None:
            for end, above in zip(candidate.slabs[0], (True, False), strict=True):
                if end is not None:
                    inside &= self._above(end, candidate.body) == above
        return frozen(inside, bool)

    def across(self, body: int) -> tuple[int, ...]:
        """The planes across a round surface's axis, by rising height along it."""
        axis, anchor = self.shapes[body].direction, self.shapes[body].anchor
        heights: dict[int, float] = {}
        for k, plane in enumerate(self.shapes):
            if isinstance(plane, Plane) and float(np.linalg.norm(np.cross(plane.normal, axis))) < _ACROSS:
                heights[k] = float((plane.origin - anchor) @ plane.normal) / float(axis @ plane.normal)
        return tuple(sorted(heights, key=lambda k: heights[k]))

    def _above(self, plane: int, body: int) -> Bools:
        """(c,) which cells lie above a plane along a round surface's axis."""
        up = float(self.shapes[plane].direction @ self.shapes[body].direction) > 0.0
        return np.asarray(self.outside[:, plane] == up)

    def best(self, worth: Floats, most: int) -> list[tuple[float, Candidate]]:
        """The candidates whose cells are worth most, best first."""
        totals = self._round_totals(worth)
        found = [(float(totals[i]), self._round[i]) for i in _greatest(totals, most)]
        for number in range(len(self.frames)):
            found += self._best_boxes(number, worth, most)
        found.sort(key=lambda pair: -pair[0])
        return found[: 2 * most]

    def rounds(self, worth: Floats, most: int) -> list[Candidate]:
        """Round ones alone."""
        return [self._round[i] for i in _greatest(self._round_totals(worth), most)]

    def of_each(self, worth: Floats, most: int) -> list[Candidate]:
        """Round ones alone, the best of each of a few bodies: other ends of one body crowd out no other body."""
        ranked = self.rounds(worth, len(self._round))
        first: dict[int | None, Candidate] = {}
        for candidate in ranked:
            first.setdefault(candidate.body, candidate)
        return list(first.values())[:most]

    def _alike_cells(self) -> tuple[Ints, list[Floats]]:
        """(c, b) which lot of cells each is in for each round body, and the (k, lots) that its candidates hold.

        Ends of one round surface tell few cells apart, so that what they hold is added up lot by lot.  Lots are
        counted on from body to body.
        """
        columns, held, count = list[Ints](), list[Floats](), 0
        for _, own in groupby(self._round, lambda candidate: candidate.body):
            lots, lot = distinct_rows(np.stack([self.mask(candidate) for candidate in own], axis=1))
            columns.append((lot + count).astype(np.int32))
            held.append(frozen(lots.T, float))
            count += len(lots)
        return (frozen(np.stack(columns, axis=1), np.int32) if columns else np.empty((0, 0), np.int64)), held

    def _round_totals(self, worth: Floats) -> Floats:
        """What the cells of each round candidate are worth together."""
        if not self._held_lots:
            return np.empty(0)
        ends = np.cumsum([held.shape[1] for held in self._held_lots])
        lots = np.split(lot_sums(self._lots, worth, int(ends[-1])), ends[:-1])
        return np.concatenate([held @ lot for held, lot in zip(self._held_lots, lots, strict=True)])

    def grown(self, cell: int, worth: Floats) -> Candidate | None:
        """Sides of planes round a cell, as few as are worth most."""
        if not self._planes:
            return None
        some, own = np.flatnonzero(worth), self._beyond[cell]
        kept = kept_sides(self._beyond[some] != own, worth[some])
        sides = tuple((self._planes[k], bool(own[k])) for k in np.flatnonzero(kept))
        return Candidate("prism", sides=sides)

    def _round_candidates(self) -> Iterator[Candidate]:
        for i, shape in enumerate(self.shapes):
            if isinstance(shape, Sphere):
                yield Candidate("sphere", i)
            elif isinstance(shape, Torus):
                yield Candidate("torus", i)
                yield from (Candidate("torus", i, sides=sides) for sides in self._bends(i, shape))
            elif not isinstance(shape, Plane):
                kind = "cylinder" if isinstance(shape, Cylinder) else "cone"
                planes = self.across(i)
                for slab in _slabs(planes):
                    yield Candidate(kind, i, slabs=(slab,) if planes else ())

    def _bends(self, ring: int, shape: Torus) -> Iterator[tuple[tuple[int, bool], ...]]:
        """The sides of one and of two planes through a ring's axis."""
        through = [
            k
            for k, plane in enumerate(self.shapes)
            if isinstance(plane, Plane)
            and abs(float(plane.normal @ shape.axis)) < _ACROSS
            and abs(float((shape.center - plane.origin) @ plane.normal)) < _THROUGH * shape.minor_radius
        ]
        halves = [(plane, outside) for plane in through for outside in (False, True)]
        yield from ((half,) for half in halves)
        for one, other in combinations(halves, 2):
            if abs(float(self.shapes[one[0]].direction @ self.shapes[other[0]].direction)) < _CROSSED:
                yield one, other

    def _best_boxes(self, number: int, worth: Floats, most: int) -> list[tuple[float, Candidate]]:
        """All boxes of a frame at once, from the cumulative sums over its bins."""
        axes = self.frames[number]
        a, b, c = (1 if k is None else len(self.directions[k].planes) + 1 for k in axes)
        counts = (a, b, c)
        ends = [_ends(n) for n in counts]
        some = np.flatnonzero(worth)
        sums = cumulative(self._bins[number][some], worth[some], counts)
        order, totals = greatest_boxes(sums, *ends, most)
        # an end that is open says less than one at a plane, so of equal boxes the more open stands
        spans = np.unravel_index(order, [len(e) for e in ends])
        openness = sum(
            (e[i, 0] == 0) * 1.0 + (e[i, 1] == n) for e, i, n in zip(ends, spans, counts, strict=True)
        )
        out = []
        for row in np.lexsort((-openness, -totals))[:most]:
            box = zip(axes, (e[span[row]] for e, span in zip(ends, spans, strict=True)), strict=True)
            slabs = tuple((None, None) if k is None else self._slab(self.directions[k], s) for k, s in box)
            out.append((float(totals[row]), Candidate("cube", frame=number, slabs=slabs)))
        return out

    @staticmethod
    def _slab(direction: Direction, span: Ints) -> Slab:
        planes = direction.planes
        low, high = int(span[0]), int(span[1])
        return (None if low == 0 else planes[low - 1]), (None if high > len(planes) else planes[high - 1])


@lru_cache
def _ends(count: int) -> Ints:
    """(n, 2) first and last of all spans of so many bins."""
    return frozen(list(combinations(range(count + 1), 2)), np.int64)


def _greatest(totals: Floats, most: int) -> Ints:
    return np.argsort(-np.round(totals, 3), kind="stable")[:most]


def _within(direction: Direction, slab: Slab) -> Bools:
    low = 0 if slab[0] is None else direction.planes.index(slab[0]) + 1
    high = len(direction.planes) if slab[1] is None else direction.planes.index(slab[1])
    return np.asarray((direction.bin >= low) & (direction.bin <= high))


def _slabs(planes: Sequence[int]) -> list[Slab]:
    """All of them, the more open first: an end laid into a wall would leave a skin there."""
    ends: list[int | None] = [None, *planes]
    out: list[Slab] = [(low, high) for i, low in enumerate(ends) for high in (*planes[i:], None)]
    return sorted(out, key=lambda slab: sum(end is not None for end in slab))


def _directions(shapes: Sequence[Shape], outside: Bools) -> list[Direction]:
    axes: list[Floats] = []
    members: list[list[int]] = []
    for i, shape in enumerate(shapes):
        if not isinstance(shape, Plane):
            continue
        for axis, group in zip(axes, members, strict=True):
            if np.linalg.norm(np.cross(axis, shape.normal)) < _PARALLEL:
                group.append(i)
                break
        else:
            normal = shape.normal
            axes.append(normal if normal[np.argmax(np.abs(normal))] > 0 else -normal)
            members.append([i])
    out = []
    for axis, group in zip(axes, members, strict=True):
        order = sorted(group, key=lambda i, a=axis: float(shapes[i].anchor @ a))  # type: ignore[misc]
        above = [outside[:, i] == (shapes[i].direction @ axis > 0) for i in order]
        out.append(Direction(axis, tuple(order), np.sum(above, axis=0).astype(np.int64)))
    return out


def _frames(directions: list[Direction]) -> Iterator[Axes]:
    """Perpendicular directions by threes, then pairs and single ones that are in no three."""

    def upright(a: int, b: int) -> bool:
        return bool(abs(float(directions[a].axis @ directions[b].axis)) < _PARALLEL)

    everyone = range(len(directions))
    threes = [t for t in combinations(everyone, 3) if all(upright(a, b) for a, b in combinations(t, 2))]
    yield from threes
    held = {pair for t in threes for pair in combinations(t, 2)}
    twos = [p for p in combinations(everyone, 2) if upright(*p) and p not in held]
    yield from ((a, b, None) for a, b in twos)
    paired = {k for t in (*threes, *twos) for k in t}
    yield from ((k, None, None) for k in everyone if k not in paired)


def frame_of(directions: Sequence[Direction], axes: Axes) -> Floats:
    """(3, 3) rotation whose columns are the directions of a box's frame.

    Directions that are upright only nearly are turned no farther than they must (Schonemann 1966).
    """
    first = directions[axes[0]].axis if axes[0] is not None else np.eye(3)[2]
    if axes[1] is None:
        turned = frame_along(first)
        return np.stack([turned[:, 2], turned[:, 0], turned[:, 1]], axis=1)
    second = directions[axes[1]].axis
    left, _, right = np.linalg.svd(np.stack([first, second, np.cross(first, second)], axis=1))
    return np.asarray(left @ right)

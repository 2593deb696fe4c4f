"""Rounded edges of a body that stands: where a convex round face touches two flat ones that meet at an outer edge.

A face that only touches those beside it bounds no cell of its own, and where a box is rounded all over, cells
leave a heap of bars.  So the body is made of its other faces first, and its edges are rounded then: a square bar
is taken away along each, and a round one put into what that leaves; a ball, where such edges meet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from models.csg import Cube
from models.csg import Cylinder as Bar
from models.csg import Sphere as Ball
from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.pose import frame_along, pose
from primitives.shapes import Cylinder, Plane, Shape, Sphere
from recognition.assembly.piece import Piece, along, tree_of
from recognition.assembly.rounded_rims import Rim

ROUNDED = "edges are rounded where round faces touch the flat ones beside them"
_TOUCH = 0.12  # of its radius, within which a rounding touches the faces beside it,
_OFF = 0.15  # [mm] and more
_SQUARE = 0.1  # most cosine between those faces
_ACROSS = 0.02  # and to its axis
_TURNED = 0.9  # cosine between two axes, below which a body is rounded another way, too
_SIDE = (
    0.15,
    0.05,
)  # of its radius behind both faces, where material is along an edge, and before them, where none is
_STEP = 0.25  # [mm] along an edge
_HALVINGS = 10  # of that
_PAST = 1.0  # [mm] before its faces, that what is taken away of an edge reaches
_MEET = 0.3  # of the largest radius, within which edges end at one corner,
_THREE = (
    3  # and between how many faces a ball rounds that: less material than two edges leave, but none past them
)
_BETTER = 0.5  # of the distance of what was felt of the roundings, that is left at most


@dataclass(frozen=True)
class Rounding:
    """Of one edge."""

    number: int  # of its surface
    shape: Cylinder
    flats: tuple[int, int]  # numbers of the flat ones
    normals: tuple[Floats, Floats]  # theirs

    @property
    def radius(self) -> float:
        """[mm]."""
        return float(self.shape.radius)

    def at(self, deep: float) -> Floats:
        """(3,) [mm] beside the axis' anchor, so deep behind both flat faces."""
        return np.asarray(self.shape.anchor + (self.radius - deep) * (self.normals[0] + self.normals[1]))

    def place(self, height: float) -> Floats:
        """(3,) [mm] on its axis."""
        return np.asarray(self.shape.anchor + height * self.shape.direction)


@dataclass(frozen=True)
class _Stretch:
    """Of an edge that a body has."""

    of: Rounding
    low: float  # [mm] along its axis
    high: float


def roundings(shapes: Sequence[Shape], convex: Sequence[bool]) -> list[Rounding]:
    """Those of a body that is rounded more than one way: along one, they are as good as its walls."""
    found = [
        rounding
        for k, shape in enumerate(shapes)
        if convex[k] and isinstance(shape, Cylinder) and (rounding := _between(k, shape, shapes)) is not None
    ]
    turned = any(abs(float(r.shape.direction @ found[0].shape.direction)) < _TURNED for r in found)
    return found if turned else []


def balls(shapes: Sequence[Shape], convex: Sequence[bool], found: Sequence[Rounding]) -> list[int]:
    """Numbers of the spheres that round a corner where such edges meet."""
    kept = []
    for k, shape in enumerate(shapes):
        if isinstance(shape, Sphere) and convex[k]:
            off = [np.cross(shape.center - r.shape.anchor, r.shape.direction) for r in found]
            beside = sum(float(np.linalg.norm(o)) < _near(r.radius) for o, r in zip(off, found, strict=True))
            kept += [k] if beside > 1 else []
    return kept


def _between(number: int, bar: Cylinder, shapes: Sequence[Shape]) -> Rounding | None:
    """The rounding between two flat faces across each other, whose planes it touches from inside."""
    beside = [
        (k, shape.normal)
        for k, shape in enumerate(shapes)
        if isinstance(shape, Plane)
        and abs(float(shape.normal @ bar.direction)) < _ACROSS
        and abs(float((bar.anchor - shape.origin) @ shape.normal) + bar.radius) < _near(bar.radius)
    ]
    for (i, one), (j, other) in combinations(beside, 2):
        if abs(float(one @ other)) < _SQUARE:
            return Rounding(number, bar, (i, j), (one, other))
    return None


def _near(radius: float) -> float:
    return _TOUCH * radius + _OFF


def rounded(
    pieces: tuple[Piece, ...],
    found: Sequence[Rounding],
    ends: Sequence[Rim],
    places: Floats,
    facet: float,
) -> tuple[Piece, ...] | None:
    """The pieces of a body with those that round its edges and `ends`, `facet` [mm] being its mesh's error.

    They come after all that is added, so that what is taken away of the body is taken of them, too.  None where
    (n, 3) places that were felt of the roundings lie hardly nearer then: the body has no such edges.
    """
    solid = Solid.from_csg(tree_of(pieces), facet)
    stretches = [stretch for rounding in found for stretch in _stretches(rounding, solid)]
    ends = [rim for rim in ends if rim.on(solid)]
    if not stretches and not ends:
        return None
    corners = _corners(stretches) if stretches else []
    last = max(k for k, piece in enumerate(pieces) if piece.operation != "subtract") + 1
    cut = [*(_cut(stretch) for stretch in stretches), *(rim.cut(ROUNDED) for rim in ends)]
    bars = [bar for stretch in stretches if (bar := _bar(stretch, corners)) is not None]
    bars += [piece for rim in ends for piece in rim.filled(ROUNDED)]
    filled = [Piece("sphere", "add", Ball(r), pose(translation=at), None, (), ROUNDED) for at, r in corners]
    whole = (*pieces[:last], *cut, *bars, *filled, *pieces[last:])
    made = Solid.from_csg(tree_of(whole), facet)
    before, after = (float(np.abs(body.signed_distance(places)).mean()) for body in (solid, made))
    return whole if after < _BETTER * before else None


def _stretches(rounding: Rounding, solid: Solid) -> Iterator[_Stretch]:
    """The parts of an edge that a body has: material behind both faces, and none before them."""
    inner, outer = rounding.at(_SIDE[0] * rounding.radius), rounding.at(-_SIDE[1] * rounding.radius)
    axis = rounding.shape.direction

    def on(heights: Floats) -> Bools:
        beside = heights[:, None] * axis
        return np.asarray(
            (solid.signed_distance(inner + beside) < 0.0) & (solid.signed_distance(outer + beside) > 0.0)
        )

    middle = float((solid.bounds.mean(axis=0) - rounding.shape.anchor) @ axis)
    half = 0.5 * float(np.linalg.norm(np.ptp(solid.bounds, axis=0))) + _STEP
    heights = np.arange(middle - half, middle + half, _STEP)
    there = np.concatenate([[False], on(heights), [False]])
    first, last = np.flatnonzero(~there[:-1] & there[1:]), np.flatnonzero(there[:-1] & ~there[1:]) - 1
    for low, high in zip(heights[first], heights[last], strict=True):
        if high - low > 2.0 * rounding.radius:
            yield _Stretch(rounding, _end(on, low, -_STEP), _end(on, high, _STEP))


def _end(on: Callable[[Floats], Bools], height: float, step: float) -> float:
    """[mm] where an edge ends, less than a step away."""
    for _ in range(_HALVINGS):
        step *= 0.5
        height += step if on(np.array([height + step]))[0] else 0.0
    return height


def _corners(stretches: Sequence[_Stretch]) -> list[tuple[Floats, float]]:
    """Middle (3,) [mm] and radius [mm] of the ball at each corner of three faces where some of them end."""
    ends = [(s.of, s.of.at(0.0) + h * s.of.shape.direction) for s in stretches for h in (s.low, s.high)]
    places, largest = np.array([at for _, at in ends]), max(s.of.radius for s in stretches)
    found: list[tuple[Floats, float]] = []
    for near in sorted({tuple(sorted(n)) for n in KDTree(places).query_ball_point(places, _MEET * largest)}):
        met = [ends[k][0] for k in near]
        faces = {k: n for r in met for k, n in zip(r.flats, r.normals, strict=True)}
        if len(met) > 1 and len(faces) == _THREE:
            radius = float(np.mean([r.radius for r in met]))
            found.append((places[list(near)].mean(axis=0) - radius * sum(faces.values()), radius))
    return found


def _cut(stretch: _Stretch) -> Piece:
    """What is taken away along an edge."""
    r, (one, other), axis = stretch.of.radius, stretch.of.normals, stretch.of.shape.direction
    middle = stretch.of.place(0.5 * (stretch.low + stretch.high)) + 0.5 * (r + _PAST) * (one + other)
    cube, frame = Cube((r + _PAST, r + _PAST, stretch.high - stretch.low)), frame_along(axis, one)
    return Piece("cube", "subtract", cube, pose(frame, middle), None, ((None, None),) * 3, ROUNDED)


def _bar(stretch: _Stretch, corners: Sequence[tuple[Floats, float]]) -> Piece | None:
    """What is put into that: up to the balls at its corners; None where these leave no room."""
    rounding, ends = stretch.of, [stretch.low, stretch.high]
    for at, radius in corners:
        away = at - rounding.shape.anchor
        height = float(away @ rounding.shape.direction)
        if np.linalg.norm(away - height * rounding.shape.direction) < _near(radius):
            near = int(abs(height - stretch.high) < abs(height - stretch.low))
            ends[near] = (
                height if abs(height - (stretch.low, stretch.high)[near]) < 2.0 * radius else ends[near]
            )
    if ends[1] - ends[0] < _STEP:
        return None
    bar = Bar(rounding.radius, ends[1] - ends[0])
    where = along(rounding.shape.anchor, rounding.shape.direction, *ends)
    return Piece("cylinder", "add", bar, where, rounding.number, ((None, None),), ROUNDED)

"""Fillets added to a body that stands: where a concave round face touches two others that meet at an inner edge.

No cell is bounded by a fillet alone, for its face only touches those beside it.  What fills the edge is a bar
about a boss as thick as the fillet is high, less a ring; between two flat faces it is a square bar less a round
one.  It is added where contacts of the fillet are in the air before, and on the body then (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from models.csg import Cube
from models.csg import Cylinder as Bar
from models.csg import Torus as Ring
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import pose
from primitives.shapes import Cylinder, Plane, Shape, Torus
from recognition.assembly.made import Known
from recognition.assembly.piece import Piece, along, tree_of, upright

FILLETED = "a fillet that no cells ask for is added where a face rises before a wall"
_TOUCH = 0.12  # of its radius, within which a fillet touches the faces beside it,
_OFF = 0.15  # [mm] and more
_ALONG = 0.999  # least cosine between axes that are one
_AIR = 0.05  # of its radius, that the middles of its contacts are off a body that lacks it, at least
_BETTER = 0.5  # of their distance, that is left at most
_FAR = 0.3  # [mm] from a body, from where a place that was felt lies off it
_STRAYS = 0.005  # share of them, by which more may
_LOOKED_AT = 2000  # of them


def filleted(pieces: tuple[Piece, ...], known: Known, facet: float) -> tuple[Piece, ...]:
    """The pieces of a body with those of the fillets that contacts ask for, `facet` [mm] being its mesh's error.

    They come after all that is added, so that what is taken away of the body is taken of them, too.
    """
    solid: Solid | None = None
    for number, (shape, places) in enumerate(zip(known.shapes, known.places, strict=True)):
        for new in _tried(number, shape, places, known.shapes) if len(places) else ():
            solid = solid or Solid.from_csg(tree_of(pieces), facet)
            before = float(np.abs(solid.signed_distance(places)).mean())
            if before < _AIR * _radius(shape):
                break
            last = max(k for k, piece in enumerate(pieces) if piece.operation != "subtract") + 1
            whole = (*pieces[:last], *new, *pieces[last:])
            made = Solid.from_csg(tree_of(whole), facet)
            after = float(np.abs(made.signed_distance(places)).mean())
            if after < _BETTER * before and _off(made, known.felt) <= _off(solid, known.felt) + _STRAYS:
                pieces, solid = whole, made
                break
    return pieces


def _off(solid: Solid, felt: Floats) -> float:
    """Share of (n, 3) felt places that lie off a body."""
    some = felt[np.unique(np.linspace(0, len(felt) - 1, _LOOKED_AT).astype(np.int64))] if len(felt) else felt
    return float(np.mean(np.abs(solid.signed_distance(some)) > _FAR)) if len(felt) else 0.0


def _radius(shape: Shape) -> float:
    """[mm] of a fillet."""
    return shape.minor_radius if isinstance(shape, Torus) else float(getattr(shape, "radius", np.inf))


def _tried(
    number: int, shape: Shape, places: Floats, shapes: Sequence[Shape]
) -> Iterator[tuple[Piece, Piece]]:
    """What may be added, and taken away of it again."""
    if isinstance(shape, Torus):
        yield from _round(number, shape, shapes)
    elif isinstance(shape, Cylinder):
        yield from _straight(number, shape, places, shapes)


def _round(number: int, ring: Torus, shapes: Sequence[Shape]) -> Iterator[tuple[Piece, Piece]]:
    """Round a boss that stands on a flat face."""
    near = _TOUCH * ring.minor_radius + _OFF
    bosses = [
        k
        for k, shape in enumerate(shapes)
        if isinstance(shape, Cylinder)
        and abs(float(shape.direction @ ring.direction)) > _ALONG
        and np.linalg.norm(np.cross(shape.anchor - ring.anchor, ring.direction)) < near
        and abs(ring.radius - ring.minor_radius - shape.radius) < near
    ]
    for k, floor in enumerate(shapes):
        if not bosses or not isinstance(floor, Plane) or abs(float(floor.normal @ ring.direction)) < _ALONG:
            continue
        high = float((ring.anchor - floor.origin) @ floor.normal)
        if abs(high - ring.minor_radius) > near:
            continue
        foot = ring.anchor - high * floor.normal
        bar = Bar(float(ring.radius), float(high))
        add = Piece(
            "cylinder", "add", bar, along(foot, floor.normal, 0.0, high), None, ((k, None),), FILLETED
        )
        whole = Ring(float(ring.radius), float(high))
        where = pose(upright(ring.direction), ring.anchor)
        yield add, Piece("torus", "subtract", whole, where, number, (), FILLETED)


def _straight(
    number: int, bar: Cylinder, places: Floats, shapes: Sequence[Shape]
) -> Iterator[tuple[Piece, Piece]]:
    """Between two flat faces across each other."""
    near = _TOUCH * bar.radius + _OFF
    beside = [
        (k, shape)
        for k, shape in enumerate(shapes)
        if isinstance(shape, Plane)
        and abs(float(shape.normal @ bar.direction)) < 1.0 - _ALONG
        and abs(float((bar.anchor - shape.origin) @ shape.normal) - bar.radius) < near
    ]
    at = (places - bar.anchor) @ bar.direction
    low, high = float(at.min()), float(at.max())
    for (i, one), (j, other) in combinations(beside, 2):
        if abs(float(one.normal @ other.normal)) > _TOUCH:
            continue
        frame = np.column_stack([bar.direction, one.normal, np.cross(bar.direction, one.normal)])
        sides = [float((bar.anchor - plane.origin) @ plane.normal) for plane in (one, other)]
        way = frame[:, 2] * np.sign(float(frame[:, 2] @ other.normal))
        middle = (
            bar.anchor + 0.5 * (low + high) * bar.direction - 0.5 * (sides[0] * one.normal + sides[1] * way)
        )
        cube = Cube((high - low, sides[0], sides[1]))
        ends = ((None, None), (i, None), (j, None))
        add = Piece("cube", "add", cube, pose(frame, middle), None, ends, FILLETED)
        round_ = Bar(float(bar.radius), high - low + 2.0)
        where = along(bar.anchor, bar.direction, low - 1.0, high + 1.0)
        yield add, Piece("cylinder", "subtract", round_, where, number, ((None, None),), FILLETED)

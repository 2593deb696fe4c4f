"""A tree with no more digits than an uncertainty supports: lengths to the decimal of one sigma, angles likewise.

An angle moves what it turns by its lever, so that sigma_angle = sigma / lever, the lever being how far the turned
solid reaches from its origin.  A turn within its sigma of one of the 24 that take axes to axes becomes that turn;
others are three turns about x, y and z in whole steps of degrees.  What a primitive's own symmetry leaves free (a
cylinder's roll) is not written down.  Of a primitive that is square to the axes the places of its sides are
rounded, not its size and its middle, so that sides which are flush stay so.  Our derivation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import permutations, product
from math import floor, log10

import numpy as np

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Operation,
    Placed,
    Polyhedron,
    Primitive,
    Prism,
    Sphere,
    Torus,
)
from models.normal.normal_leaf import normal_leaf
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import pose, rotation_exp, rotation_log

_FINEST = 12  # decimals that are ever kept
_SQUARE_TURNS = [
    turn
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
    if np.linalg.det(turn := np.eye(3)[list(order)] * np.array(signs)) > 0
]


def rounded(tree: Csg, sigma: float) -> Csg:
    """The tree in the digits that one sigma of `sigma` [mm] supports; its structure and names stay."""
    if not (np.isfinite(sigma) and sigma > 0):
        raise PalpateError(f"the uncertainty must be a positive length in mm, not {sigma}")
    return _rounded(tree, sigma)


def _rounded(tree: Csg, sigma: float) -> Csg:
    match tree:
        case Placed():
            return _moved(tree, sigma)
        case Operation():
            return type(tree)(tuple(_rounded(child, sigma) for child in tree.children), tree.name)
        case Primitive():
            return _sized(tree, sigma)
    return tree


def _moved(tree: Placed, sigma: float) -> Csg:
    child, placed = tree.child, tree.pose
    if isinstance(child, Sphere | Cylinder | Cone | Torus):
        name = child.name
        child, placed = normal_leaf(child, placed)
        child = child.named(name)
    turn = _turn(placed[:3, :3], sigma / float(np.abs(child.bounds()).max()))
    if isinstance(child, Cube | Cylinder | Cone | Prism) and (np.abs(turn).max(axis=0) == 1.0).all():
        made, shift = _flush(child, turn, placed[:3, 3], sigma)
    else:
        made, shift = _rounded(child, sigma), np.array([_steps(x, sigma) for x in placed[:3, 3].tolist()])
    if not shift.any() and np.array_equal(turn, np.eye(3)):
        return made.named(tree.name) if tree.name else made
    moved = made.placed(pose(turn, shift))
    return moved.named(tree.name) if tree.name else moved


def _turn(turn: Floats, sigma: float) -> Floats:
    """A (3, 3) rotation, known to `sigma` [rad], in round degrees about x, then y, then z."""
    for square in _SQUARE_TURNS:
        if np.linalg.norm(rotation_log(square.T @ turn)) <= sigma:
            return np.asarray(square)
    x = np.arctan2(turn[2, 1], turn[2, 2])
    y = np.arctan2(-turn[2, 0], np.hypot(turn[2, 1], turn[2, 2]))
    z = np.arctan2(turn[1, 0], turn[0, 0])
    if abs(turn[2, 0]) > 1 - 1e-9:
        x, z = 0.0, np.arctan2(-turn[0, 1], turn[1, 1])
    out = np.eye(3)
    for axis, angle in zip(np.eye(3), (x, y, z), strict=True):
        degrees = _steps(float(np.degrees(angle)), float(np.degrees(sigma)))
        out = rotation_exp(axis * np.radians(degrees)) @ out
    return np.asarray(np.round(out, _FINEST) + 0.0)


def _flush(
    primitive: Cube | Cylinder | Cone | Prism, turn: Floats, middle: Floats, sigma: float
) -> tuple[Csg, Floats]:
    """A primitive turned by quarters about its (3,) middle, and that, so that its sides end in whole steps."""
    at = np.array([_steps(x, sigma) for x in middle.tolist()])
    spans = primitive.size if isinstance(primitive, Cube) else (0.0, 0.0, primitive.height)
    sizes = []
    for axis, span in zip(turn.T, spans, strict=True):
        low, high = (_steps(float(middle @ axis) + end * span, sigma) for end in (-0.5, 0.5))
        sizes.append(_short(high - low))
        if high > low:
            at = np.where(axis == 0.0, at, _short(0.5 * (low + high)) * axis)
    made = _sized(primitive, sigma)
    match made:
        case Cube():
            x, y, z = (new or old for new, old in zip(sizes, made.size, strict=True))
            return Cube((x, y, z), made.name), at
        case Cylinder() | Cone():
            return replace(made, height=sizes[2] or made.height), at
        case Prism() if isinstance(primitive, Prism):
            corners = _corners(primitive, turn, middle, at, sigma)
            tall = replace(made, height=sizes[2] or made.height)
            return _kept(lambda: replace(tall, outline=corners), tall), at
    return made, at


def _corners(
    prism: Prism, turn: Floats, middle: Floats, at: Floats, sigma: float
) -> tuple[tuple[float, float], ...]:
    """The outline about `at` of a prism, known about its (3,) middle, whose corners are in whole steps."""
    world = np.array(prism.outline) @ turn[:, :2].T + middle
    placed = np.array([[_steps(x, sigma) for x in corner] for corner in world.tolist()])
    return tuple((_short(x), _short(y)) for x, y in ((placed - at) @ turn[:, :2]).tolist())


def _sized(primitive: Primitive, sigma: float) -> Primitive:
    name = primitive.name

    def size(value: float) -> float:
        return _steps(value, sigma) or _steps(value, value)

    match primitive:
        case Cube():
            x, y, z = map(size, primitive.size)
            return Cube((x, y, z), name)
        case Cylinder():
            return Cylinder(size(primitive.radius), size(primitive.height), name)
        case Cone():
            low, high = _steps(primitive.bottom_radius, sigma), _steps(primitive.top_radius, sigma)
            if low == high:
                wider = max(primitive.bottom_radius, primitive.top_radius)
                return Cylinder(low or size(wider), size(primitive.height), name)
            return Cone(low, high, size(primitive.height), name)
        case Sphere():
            return Sphere(size(primitive.radius), name)
        case Torus():
            return Torus(size(primitive.major_radius), size(primitive.minor_radius), name)
        case Prism():
            outline = tuple((_steps(x, sigma), _steps(y, sigma)) for x, y in primitive.outline)
            return _kept(lambda: Prism(outline, size(primitive.height), name), primitive)
        case Polyhedron():
            points = tuple(
                (_steps(x, sigma), _steps(y, sigma), _steps(z, sigma)) for x, y, z in primitive.points
            )
            return _kept(lambda: Polyhedron(points, primitive.faces, name), primitive)
    return primitive


def _kept(make: Callable[[], Primitive], primitive: Primitive) -> Primitive:
    """What rounding made, or the primitive itself where its corners no longer make a solid."""
    try:
        return make()
    except PalpateError:
        return primitive


def _short(value: float) -> float:
    """Less what adding and subtracting has left behind its digits."""
    return round(value, _FINEST) + 0.0


def _steps(value: float, sigma: float) -> float:
    """The value in whole steps of the decimal that sigma begins with."""
    return round(value, min(-floor(log10(sigma)), _FINEST)) + 0.0

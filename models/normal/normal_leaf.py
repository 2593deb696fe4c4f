"""One way to write each placed primitive: its own symmetries are taken out of its pose.

A cylinder turned about its axis or end for end is the same solid, a cube may have its sides named in any order,
and a prism's outline may begin anywhere; of all poses that give the same solid the one nearest to no turn is
kept (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np

from models.csg import Cone, Cube, Cylinder, Polyhedron, Primitive, Prism, Sphere, Torus
from primitives.arrays import Floats
from primitives.pose import hat, pose, transform_points

DIGITS = 9  # decimals [mm, 1] to which normal forms are rounded, so that they compare
_OVER = np.diag([1.0, -1.0, -1.0])
_PERMUTED = [np.eye(3)[list(order)].T for order in permutations(range(3))]
_TURNS = [
    turn
    for p in _PERMUTED
    for signs in product((1.0, -1.0), repeat=3)
    if np.linalg.det(turn := p * np.array(signs)) > 0
]  # the 24 turns of a cube onto itself

Leaf = tuple[Primitive, Floats]  # with its (4, 4) pose


def normal_leaf(primitive: Primitive, placed: Floats) -> Leaf:
    """The same solid, without a name, in the pose that stands for all its poses."""
    turn, shift = placed[:3, :3], placed[:3, 3]
    match primitive:
        case Sphere():
            return Sphere(primitive.radius), pose(None, shift)
        case Cylinder():
            return Cylinder(primitive.radius, primitive.height), pose(_axis_turn(turn, True), shift)
        case Torus():
            ring = Torus(primitive.major_radius, primitive.minor_radius)
            return ring, pose(_axis_turn(turn, True), shift)
        case Cone():
            low, high = primitive.bottom_radius, primitive.top_radius
            turn = turn if low > high else turn @ _OVER
            cone = Cone(max(low, high), min(low, high), primitive.height)
            return cone, pose(_axis_turn(turn, False), shift)
        case Cube():
            return min(_cubes(primitive, placed), key=_plainness)
        case Prism():
            return min(_prisms(primitive, placed), key=_plainness)
        case Polyhedron():
            return _moved(primitive, placed), np.eye(4)
    return primitive.named(""), placed


def _axis_turn(turn: Floats, either_way: bool) -> Floats:
    """The least turn that takes z to the turned z, or to its opposite where that is as good."""
    axis = turn[:, 2] / np.linalg.norm(turn[:, 2])
    if either_way and tuple(np.round(axis[::-1], 7)) < (0, 0, 0):
        axis = -axis
    cosine = float(axis[2])
    if cosine < -1 + 1e-12:
        return _OVER
    around = hat(np.array([-axis[1], axis[0], 0.0]))
    return np.asarray(np.eye(3) + around + around @ around / (1 + cosine))


def _cubes(cube: Cube, placed: Floats) -> Iterator[Leaf]:
    for turn in _TURNS:
        size = np.abs(turn.T @ np.array(cube.size))
        yield Cube(tuple(size.tolist())), pose(placed[:3, :3] @ turn, placed[:3, 3])


def _prisms(prism: Prism, placed: Floats) -> Iterator[Leaf]:
    """With the outline about its middle, each of its corners in turn on the x axis, either side up."""
    outline = np.array(prism.outline)
    middle = outline.mean(axis=0)
    home = transform_points(placed, np.array([[*middle, 0.0]]))[0]
    for over in (np.eye(3), _OVER):
        corners = (outline - middle) @ over[:2, :2].T
        corners = corners if over[1, 1] > 0 else corners[::-1]
        farthest = np.linalg.norm(corners, axis=1)
        for i in np.flatnonzero(farthest >= farthest.max() * (1 - 1e-9)):
            c, s = corners[i] / farthest[i]
            turned = np.roll(corners @ np.array([[c, -s], [s, c]]), -i, axis=0)
            back = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            made = Prism(tuple(map(tuple, turned.tolist())), prism.height)
            yield made, pose(placed[:3, :3] @ over.T @ back, home)


def _moved(solid: Polyhedron, placed: Floats) -> Polyhedron:
    """In place, its corners in order of their coordinates."""
    corners = np.round(transform_points(placed, np.array(solid.points)), DIGITS) + 0.0
    order = np.lexsort(corners.T[::-1])
    place = np.argsort(order)
    faces = [tuple(int(place[i]) for i in face) for face in solid.faces]
    starts = [face.index(min(face)) for face in faces]
    faces = sorted(face[k:] + face[:k] for face, k in zip(faces, starts, strict=True))
    return Polyhedron(tuple(map(tuple, corners[order].tolist())), tuple(faces))


def _plainness(leaf: Leaf) -> tuple[object, ...]:
    """Least for the simplest way to write a solid: sizes first where they tell, then the least turn."""
    primitive, placed = leaf
    outline = np.round(getattr(primitive, "outline", ()), 7) + 0.0
    turn = np.round(placed[:3, :3], 7) + 0.0
    return (tuple(map(tuple, -outline)), -round(float(np.trace(turn)), 6), tuple(map(tuple, -turn)))

from math import pi

import numpy as np
import pytest

from models import parts
from models.csg import Cone, Csg, Cube, Cylinder, Polyhedron, Prism, Sphere, Torus
from models.normal.normal_form import normal_form, same_tree
from primitives.pose import inverse, pose, random_rotation

A, B, C = Cube((10, 20, 30)), Sphere(7).at(1, 2, 3), Cylinder(4, 50).turned("x", 0.3)
L_SHAPE = ((0, 0), (30, 0), (30, 10), (10, 10), (10, 20), (0, 20))
WEDGE = Polyhedron(((0, 0, 0), (9, 0, 0), (0, 8, 0), (0, 0, 7)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)))
SAME: list[tuple[Csg, Csg]] = [
    (A | B | C, C | (B | A)),
    (A & B & C, (C & A) & B),
    (A - B - C, A - (C | B)),
    ((A - B) - C, A - C - B),
    (A | A, A),
    (A.named("left"), A),
    (A.at(1, 0, 0).turned("z", 1).turned("z", -1).at(-1, 0, 0), A),
    ((A | B).at(4, 5, 6), A.at(4, 5, 6) | B.at(4, 5, 6)),
    (Cylinder(5, 10), Cylinder(5, 10).turned("z", 1.1).turned("x", pi)),
    (Cylinder(5, 10).turned("y", pi / 2), Cylinder(5, 10).turned("y", -pi / 2).turned("x", 0.4)),
    (Cone(5, 2, 10).turned("x", 0.7), Cone(2, 5, 10).turned("z", 2).turned("x", 0.7 + pi)),
    (Torus(9, 2).at(0, 0, 1), Torus(9, 2).turned("x", pi).turned("z", 0.3).at(0, 0, 1)),
    (Sphere(3).turned("x", 1), Sphere(3)),
    (Cube((1, 2, 3)), Cube((3, 2, 1)).turned("y", pi / 2)),
    (Cube((2, 2, 3)), Cube((2, 2, 3)).turned("z", -pi / 2).turned("x", pi)),
    (Prism(L_SHAPE, 5), Prism(tuple((x + 3, y) for x, y in L_SHAPE), 5).at(-3, 0, 0)),
    (Prism(L_SHAPE, 5), Prism(tuple((-y, x) for x, y in L_SHAPE), 5).turned("z", -pi / 2)),
    (Prism(L_SHAPE, 5), Prism(tuple((x, -y) for x, y in L_SHAPE), 5).turned("x", pi)),
    (Prism(L_SHAPE, 5), Prism((*L_SHAPE[2:], *L_SHAPE[:2]), 5)),
    (WEDGE.at(1, 0, 0), Polyhedron(tuple((x + 1, y, z) for x, y, z in WEDGE.points), WEDGE.faces[::-1])),
]
OTHER: list[tuple[Csg, Csg]] = [
    (A | B, A & B),
    (A - B, B - A),
    (A - B, A),
    (A, A.at(0, 0, 0.01)),
    (Cylinder(5, 10), Cylinder(5.01, 10)),
    (Cone(5, 2, 10), Cone(2, 5, 10)),
    (Torus(9, 2), Torus(9, 2.01)),
    (Torus(9, 2), Torus(9, 2).turned("x", 0.01)),
    (Cube((1, 2, 3)), Cube((1, 3, 2))),
    (Prism(L_SHAPE, 5), Prism(tuple((x, -y) for x, y in L_SHAPE), 5)),
    (WEDGE, WEDGE.turned("z", pi / 2)),
    (
        Prism(((0, 0), (10, 0), (10, 10), (5, 4), (0, 10)), 5),
        Prism(((0, 0), (5, 4), (10, 0), (10, 10), (0, 10)), 5),
    ),
]


@pytest.mark.parametrize(("a", "b"), SAME)
def test_ways_to_write_one_tree_have_one_normal_form(a: Csg, b: Csg) -> None:
    assert same_tree(a, b)
    assert normal_form(a) == normal_form(b)


@pytest.mark.parametrize(("a", "b"), OTHER)
def test_different_trees_differ(a: Csg, b: Csg) -> None:
    assert not same_tree(a, b, 1e-3)
    assert normal_form(a) != normal_form(b)


@pytest.mark.parametrize(
    "name", ["bracket", "flange", "wedge", "hex_bolt", "o_ring", "pyramid_stand", "handwheel"]
)
def test_equality_survives_a_motion_there_and_back(name: str) -> None:
    tree, rng = parts.build(name), np.random.default_rng(3)
    moved = pose(random_rotation(rng), rng.normal(0, 50, 3))
    there = tree.placed(moved)
    assert not same_tree(there, tree, 1e-3)
    assert same_tree(there.placed(inverse(moved)), tree)
    assert same_tree(normal_form(there), there)


def test_the_tolerance_is_a_length_at_the_solid() -> None:
    tree = parts.build("flange")
    for shift, same in ((0.009, True), (0.011, False)):
        assert same_tree(tree.at(shift, 0, 0), tree, 0.01) == same


def test_a_child_repeated_within_the_tolerance_counts_once() -> None:
    assert same_tree(A | B | A.at(1e-8, 0, 0), A | B)
    assert not same_tree(A | B | A.at(1, 0, 0), A | B)


def test_no_two_built_in_parts_are_the_same_tree() -> None:
    forms = {normal_form(parts.build(name)) for name in parts.names()}
    assert len(forms) == len(parts.names())

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models import csg
from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Difference,
    Intersection,
    Polyhedron,
    Prism,
    Sphere,
    Torus,
    Union,
)
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import from_quaternion, pose, transform_points

lengths = st.floats(0.5, 80)
placements = st.tuples(*[st.floats(-1, 1)] * 4, *[st.floats(-30, 30)] * 3).filter(
    lambda x: np.linalg.norm(x[:4]) > 0.1
)


def _star(radii: list[float], height: float) -> Prism:
    """A prism whose outline is seen whole from the origin, convex or not."""
    turn = 2 * pi / len(radii) * np.arange(len(radii))
    return Prism(tuple((r * np.cos(a), r * np.sin(a)) for r, a in zip(radii, turn, strict=True)), height)


def _pyramid(x: float, y: float, z: float) -> Polyhedron:
    base = ((-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0))
    return Polyhedron((*base, (0.0, 0.0, z)), ((3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)))


primitives = st.one_of(
    st.builds(lambda r, x: Torus(r + x, r), st.floats(0.5, 20), st.floats(0.5, 40)),
    st.builds(_star, st.lists(st.floats(3, 40), min_size=4, max_size=9), lengths),
    st.builds(_pyramid, lengths, lengths, lengths),
    st.builds(lambda x, y, z: Cube((x, y, z)), lengths, lengths, lengths),
    st.builds(Cylinder, lengths, lengths),
    st.builds(lambda a, b, h: Cone(a, a + b, h), st.floats(0, 40), lengths, lengths),
    st.builds(lambda b, h: Cone(b, 0, h), lengths, lengths),
    st.builds(Sphere, lengths),
)
placed = st.builds(lambda p, x: p.placed(from_quaternion(x[:4], x[4:])), primitives, placements)
trees = st.recursive(
    placed,
    lambda kids: st.builds(
        lambda kind, a, b: kind((a, b)), st.sampled_from([Union, Intersection, Difference]), kids, kids
    ),
    max_leaves=4,
)


def _cloud(tree: Csg, n: int = 200, seed: int = 0) -> np.ndarray:
    low, high = tree.bounds()
    return np.random.default_rng(seed).uniform(low - 5, high + 5, (n, 3))


@given(trees)
def test_repr_builds_an_equal_tree(tree: Csg) -> None:
    again = eval(repr(tree), vars(csg))
    assert again == tree
    assert hash(again) == hash(tree)


def test_repr_of_turns_and_names_is_short() -> None:
    tree = Cylinder(5, 20, name="pin").turned("y", pi / 2).at(1, 2, 3) | Cube((1, 2, 3))
    assert repr(tree) == (
        "(Cylinder(5.0, 20.0, name='pin').turned((0.0, 1.0, 0.0), 1.5707963267949).at(1.0, 2.0, 3.0)"
        " | Cube((1.0, 2.0, 3.0)))"
    )


@given(trees)
def test_bounds_hold_every_inside_point(tree: Csg) -> None:
    low, high = tree.bounds()
    points = np.random.default_rng(1).uniform(-120, 120, (400, 3))
    inside = points[tree.signed_distance(points) < 0]
    assert ((inside >= low - 1e-9) & (inside <= high + 1e-9)).all()


@given(placed)
def test_bounds_of_a_primitive_are_tight(tree: Csg) -> None:
    solid = Solid.from_csg(tree, tolerance=0.05)
    np.testing.assert_allclose(tree.bounds(), solid.bounds, atol=0.15)


@settings(deadline=None, max_examples=25)
@given(primitives)
def test_primitive_distance_agrees_with_its_mesh(tree: Csg) -> None:
    points = _cloud(tree)
    meshed = Solid.from_csg(tree, tolerance=0.01).signed_distance(points)
    np.testing.assert_allclose(tree.signed_distance(points), meshed, atol=0.011)


@given(trees, st.floats(0.2, 5.0))
def test_a_scaled_tree_has_every_distance_times_the_factor(tree: Csg, factor: float) -> None:
    points = _cloud(tree)
    np.testing.assert_allclose(
        tree.scaled(factor).signed_distance(factor * points), factor * tree.signed_distance(points), atol=1e-8
    )


@pytest.mark.parametrize("factor", [0.0, -1.0, np.nan, np.inf])
def test_a_solid_is_scaled_by_a_positive_number(factor: float) -> None:
    with pytest.raises(PalpateError, match="positive"):
        (Cube((1.0, 2.0, 3.0)) - Sphere(0.5)).scaled(factor)


@given(trees)
def test_signed_distance_never_grows_faster_than_one(tree: Csg) -> None:
    a, b = _cloud(tree, seed=1), _cloud(tree, seed=2)
    change = np.abs(tree.signed_distance(a) - tree.signed_distance(b))
    assert (change <= np.linalg.norm(a - b, axis=1) + 1e-9).all()


@given(trees, placements)
def test_signed_distance_moves_with_the_tree(tree: Csg, x: tuple[float, ...]) -> None:
    moved, points = from_quaternion(x[:4], x[4:]), _cloud(tree)
    there = tree.placed(moved).signed_distance(transform_points(moved, points))
    np.testing.assert_allclose(there, tree.signed_distance(points), atol=1e-9)


@given(trees, trees)
def test_difference_is_intersection_with_the_complement(a: Csg, b: Csg) -> None:
    points = _cloud(a)
    left = (a - b).signed_distance(points)
    np.testing.assert_array_equal(left, np.maximum(a.signed_distance(points), -b.signed_distance(points)))


def test_leaves_carry_pose_and_sign() -> None:
    tree = (Cube((1, 1, 1)) - (Sphere(2).at(0, 0, 1) - Cylinder(3, 4))).at(5, 0, 0)
    leaves = list(tree.leaves())
    assert [leaf.adds for leaf in leaves] == [True, False, True]
    np.testing.assert_array_equal(leaves[1].part_from_primitive, pose(None, (5, 0, 1)))


def test_operators_of_one_kind_stay_flat() -> None:
    a, b, c = Cube((1, 1, 1)), Sphere(1), Cylinder(1, 1)
    assert (a | b | c).children == (a, b, c)
    assert (a - b - c).children == (a, b, c)


def test_placements_compose_to_one() -> None:
    moved = Sphere(1).at(1, 0, 0).turned("z", pi / 2).at(0, 0, 2)
    assert moved.child == Sphere(1)
    np.testing.assert_allclose(moved.pose[:3, 3], [0, 1, 2], atol=1e-15)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Cube((0, 1, 1)),
        lambda: Cube((1, 1)),  # type: ignore[arg-type]
        lambda: Sphere(-1),
        lambda: Sphere(float("nan")),
        lambda: Cylinder(1, float("inf")),
        lambda: Cone(3, 3, 4),
        lambda: Cone(-1, 2, 4),
        lambda: Cube((1, 1, 1)).placed(2 * np.eye(4)),
        lambda: Cube((1, 1, 1)).placed(np.diag([1.0, 1.0, -1.0, 1.0])),
        lambda: Union((Sphere(1),)),
        lambda: Torus(5, 5),
        lambda: Torus(5, -1),
        lambda: Prism(((0, 0), (10, 0), (5, 0)), 4),
        lambda: Prism(((0, 0), (10, 10), (10, 0), (0, 10)), 4),
        lambda: Prism(((0, 0), (10, 0), (0, float("nan"))), 4),
        lambda: Prism(((0, 0), (10, 0, 3), (0, 9)), 4),  # type: ignore[arg-type]
        lambda: Prism(((0, 0), (10, 0), (0, 10)), 0),
        lambda: Polyhedron(((0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)), ((0, 2, 1), (0, 1, 3), (1, 2, 3))),
        lambda: Polyhedron(
            ((0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)), ((0, 1, 2), (0, 1, 3), (1, 2, 3), (2, 0, 3))
        ),
        lambda: Polyhedron(
            ((0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 7))
        ),
        lambda: Polyhedron(
            ((0, 0, 0), (9, 0, 0), (9, 9, 2), (0, 9, 0), (4, 4, 9)),
            ((3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
        ),
    ],
)
def test_impossible_sizes_and_places_are_refused(make) -> None:
    with pytest.raises(PalpateError):
        make()

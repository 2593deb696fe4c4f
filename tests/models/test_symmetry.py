from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.boundary import boundary
from models.csg import Cone, Csg, Cube, Cylinder, Sphere, Torus
from models.solid import Solid
from models.symmetry import SymmetryGroup, nearest_pose, pose_error, symmetry
from primitives.pose import pose, random_rotation, rotation_exp, turn_about


def group_of(tree: Csg) -> SymmetryGroup:
    return symmetry(boundary(Solid.from_csg(tree)))


def ring(n: int, radius: float = 30.0) -> Csg:
    tree: Csg = Cylinder(42, 10)
    for i in range(n):
        tree = tree - Cylinder(4, 30).at(radius, 0, 0).turned("z", 2 * pi * i / n)
    return tree


def tetrahedron() -> Csg:
    """A cube's corners cut alternately: the four planes of a tetrahedron."""
    solid: Csg = Cube((60, 60, 60))
    for corner in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)):
        direction = np.array(corner) / np.sqrt(3)
        axis = np.cross([0, 0, 1], direction)
        angle = float(np.arccos(direction[2]))
        solid = solid & Cube((300, 300, 300)).at(0, 0, -135).turned(axis, angle)
    return solid


@pytest.mark.parametrize(
    ("tree", "name", "order"),
    [
        (Cube((40, 40, 40)), "O", 24),
        (Cube((40, 40, 40)) & Sphere(28), "O", 24),
        (Cube((40, 40, 30)), "D4", 8),
        (Cube((40, 50, 30)), "D2", 4),
        (tetrahedron(), "T", 12),
        (ring(3), "D3", 6),
        (ring(7), "D7", 14),
        (ring(6) | Cylinder(10, 30).at(0, 0, 15), "C6", 6),
        (ring(1), "C2", 2),
        (Cube((40, 50, 30)) - Cylinder(5, 30).at(0, 0, 10), "C2", 2),
        (Cube((40, 50, 30)) - Cylinder(5, 30).at(3, 4, 10), "C1", 1),
        (Cylinder(20, 40), "D_inf", np.inf),
        (Torus(30, 8), "D_inf", np.inf),
        (Cone(20, 10, 30), "C_inf", np.inf),
        (Sphere(20), "K", np.inf),
        (Sphere(20) - Sphere(10), "K", np.inf),
        (Sphere(20) - Sphere(5).at(3, 4, 5), "C_inf", np.inf),
        (Cylinder(16, 90) | Cylinder(12, 90).turned("y", pi / 2), "D2", 4),
    ],
)
def test_the_group_has_its_name_and_order(tree: Csg, name: str, order: float) -> None:
    group = group_of(tree)
    assert (group.name, group.order) == (name, order)


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 1000))
def test_the_group_turns_with_the_part(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = pose(random_rotation(rng), rng.uniform(-90, 90, 3))
    group = group_of((ring(5) | Cylinder(10, 30).at(0, 0, 15)).placed(motion))
    assert group.name == "C5"
    assert group.axis is not None
    assert abs(group.axis @ motion[:3, 2]) == pytest.approx(1, abs=1e-6)
    assert np.linalg.norm(np.cross(group.center - motion[:3, 3], motion[:3, 2])) < 1e-3


@pytest.mark.parametrize("tree", [Cube((40, 40, 40)), tetrahedron(), ring(4)])
def test_rotations_form_a_group_about_the_center(tree: Csg) -> None:
    group = group_of(tree)
    turns = group.rotations[:, :3, :3]
    np.testing.assert_allclose(turns[0], np.eye(3), atol=1e-12)
    products = np.einsum("aij,bjk->abik", turns, turns).reshape(-1, 3, 3)
    away = np.linalg.norm(products[:, None] - turns[None], axis=(2, 3)).min(axis=1)
    assert away.max() < 1e-4
    centers = group.rotations @ np.append(group.center, 1.0)
    np.testing.assert_allclose(centers[:, :3], np.broadcast_to(group.center, (len(turns), 3)), atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000), angle=st.floats(0.0, 0.3), which=st.integers(0, 23))
def test_pose_error_is_the_same_for_all_symmetric_poses(seed: int, angle: float, which: int) -> None:
    rng = np.random.default_rng(seed)
    true = pose(random_rotation(rng), rng.uniform(-90, 90, 3))
    axis = random_rotation(rng)[:, 0]
    estimated = true @ CUBE.rotations[which]
    off = turn_about((true @ np.append(CUBE.center, 1.0))[:3], axis, angle) @ estimated
    off[:3, 3] += (3.0, 4.0, 0.0)
    error = pose_error(CUBE, off, true)
    assert error.angle == pytest.approx(angle, abs=1e-6)
    assert error.distance == pytest.approx(5.0, abs=1e-6)


CUBE = group_of(Cube((40, 40, 40)).at(10, 0, 0))


def test_turns_about_an_axis_of_revolution_cost_nothing() -> None:
    group = group_of(Cylinder(20, 40).at(5, 6, 7))
    true = pose(rotation_exp([0.3, -0.2, 0.5]), (1, 2, 3))
    flipped = turn_about((5, 6, 7), (1, 0, 0), pi) @ turn_about((5, 6, 7), (0, 0, 1), 1.234)
    tilted = turn_about((5, 6, 7), (0, 1, 0), 0.1)
    error = pose_error(group, true @ tilted @ flipped, true)
    assert error.angle == pytest.approx(0.1, abs=1e-9)
    assert error.distance == pytest.approx(0.0, abs=1e-4)
    one_way = group_of(Cone(20, 10, 30))
    assert pose_error(one_way, turn_about(one_way.center, (1, 0, 0), pi), np.eye(4)).angle == pytest.approx(
        pi
    )


def test_a_ball_has_no_orientation() -> None:
    group = group_of(Sphere(20).at(9, 0, 0))
    wanted = pose(rotation_exp([1.0, 2.0, 0.5]), (4, 5, 6))
    estimated = pose(rotation_exp([-0.4, 0.1, 0.2]), (4, 5, 6))
    assert pose_error(group, estimated, wanted).angle == pytest.approx(0, abs=1e-9)
    same = nearest_pose(group, estimated, wanted)
    center = np.append(group.center, 1.0)
    np.testing.assert_allclose(same @ center, estimated @ center, atol=1e-9)


@pytest.mark.parametrize(
    "node", [Sphere(20).at(9, 0, 0), Cone(20, 10, 30), Cylinder(5, 20), Cube((20, 30, 40))]
)
def test_the_nearest_to_many_poses_is_the_nearest_to_each(node: Csg) -> None:
    group, rng = group_of(node), np.random.default_rng(3)
    many = pose(rotation_exp(rng.standard_normal((6, 3))), rng.standard_normal((6, 3)))
    at = nearest_pose(group, pose(rotation_exp([1.0, 2.0, 0.5]), (4, 5, 6)), many)
    for wanted, near in zip(many, at, strict=True):
        one = nearest_pose(group, pose(rotation_exp([1.0, 2.0, 0.5]), (4, 5, 6)), wanted)
        np.testing.assert_allclose(near, one, atol=1e-12)

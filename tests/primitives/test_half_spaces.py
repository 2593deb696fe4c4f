"""The intersection of half-spaces: distances, rays, and samples on its boundary."""

import numpy as np
import pytest

from primitives.half_spaces import HalfSpaces
from primitives.pose import pose, random_rotation
from primitives.shapes import Cone, Cylinder, Plane, Sphere

BOX = np.array([[-100.0] * 3, [100.0] * 3])


def block(half=(20.0, 15.0, 10.0)):
    axes = np.eye(3)
    return [Plane(s * h * axes[i], s * axes[i]) for i, h in enumerate(half) for s in (-1.0, 1.0)]


def test_block_distance_is_the_box_distance_inside():
    points = np.random.default_rng(0).uniform(-1, 1, (500, 3)) * [20, 15, 10]
    expected = (np.abs(points) - [20, 15, 10]).max(axis=1)
    assert np.allclose(HalfSpaces.of(block()).signed_distance(points), expected)


def test_distance_outside_never_exceeds_the_true_distance():
    points = np.random.default_rng(1).uniform(-60, 60, (500, 3))
    true = np.linalg.norm(np.maximum(np.abs(points) - [20, 15, 10], 0.0), axis=1)
    assert (HalfSpaces.of(block()).signed_distance(points) <= true + 1e-12)[true > 0].all()


def test_no_surface_at_all_contains_everything():
    assert HalfSpaces.of([]).contains(np.zeros((3, 3))).all()


def test_samples_stand_for_the_area_of_a_block_in_any_pose():
    rng = np.random.default_rng(2)
    for _ in range(5):
        world = pose(random_rotation(rng), rng.uniform(-30, 30, 3))
        body = HalfSpaces.of([s.transformed(world) for s in block()])
        samples = body.sample_boundary(BOX, 0.5)
        area = np.bincount(samples.face, samples.area)
        assert area == pytest.approx([600, 600, 800, 800, 1200, 1200], rel=0.04)
        assert np.abs(body.signed_distance(samples.points)).max() < 1e-9
        assert np.allclose(body.normals(samples.points), samples.normals)


@pytest.mark.parametrize(
    ("shapes", "areas"),
    [
        ([Sphere(np.array([5.0, 0, 0]), 30.0)], [4 * np.pi * 900]),
        (
            [
                Cylinder(np.zeros(3), np.array([0, 0, 1.0]), 15.0),
                Plane(np.array([0, 0, 20.0]), np.array([0, 0, 1.0])),
                Plane(np.array([0, 0, -20.0]), np.array([0, 0, -1.0])),
            ],
            [2 * np.pi * 15 * 40, np.pi * 225, np.pi * 225],
        ),
        (
            [
                Cone(np.array([0, 0, 30.0]), np.array([0, 0, -1.0]), np.arctan(0.5)),
                Plane(np.zeros(3), np.array([0, 0, -1.0])),
            ],
            [np.pi * 15 * np.hypot(15, 30), np.pi * 225],
        ),
    ],
)
def test_samples_stand_for_the_area_of_curved_bodies(shapes, areas):
    samples = HalfSpaces.of(shapes).sample_boundary(BOX, 1.5)
    assert np.bincount(samples.face, samples.area) == pytest.approx(areas, rel=0.03)


def test_no_point_of_the_boundary_is_farther_from_a_sample_than_the_spacing():
    body = HalfSpaces.of(block())
    samples = body.sample_boundary(BOX, 4.0)
    rng = np.random.default_rng(3)
    points = rng.uniform(-1, 1, (2000, 3)) * [20, 15, 10]
    side = rng.integers(0, 3, 2000)
    points[np.arange(2000), side] = np.array([20, 15, 10])[side] * rng.choice([-1, 1], 2000)
    nearest = np.linalg.norm(points[:, None] - samples.points[None], axis=2).min(axis=1)
    assert nearest.max() <= 4.0


def test_one_surface_is_sampled_to_the_box_and_no_further():
    samples = HalfSpaces.of([Plane(np.zeros(3), np.array([0, 0, 1.0]))]).sample_boundary(BOX, 10.0)
    assert samples.area.sum() == pytest.approx(200**2, rel=1e-9)
    assert np.abs(samples.points).max() < 100


def test_a_hole_is_kept_clear():
    hole = Cylinder(np.zeros(3), np.array([0, 0, 1.0]), 5.0)
    body = HalfSpaces.of([*block(), hole], [True] * 6 + [False])
    samples = body.sample_boundary(BOX, 1.0)
    assert not body.contains(np.zeros((1, 3)))[0]
    assert np.bincount(samples.face, samples.area)[6] == pytest.approx(2 * np.pi * 5 * 20, rel=0.03)
    inner = samples.face == 6
    assert (np.einsum("ij,ij->i", samples.normals[inner], samples.points[inner]) < 0).all()


def test_rays_meet_a_block_where_the_slab_method_says():
    rng = np.random.default_rng(4)
    directions = rng.standard_normal((400, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = rng.uniform(-15, 15, (400, 3)) - 80 * directions
    half = np.array([20.0, 15.0, 10.0])
    t1, t2 = (-half - origins) / directions, (half - origins) / directions
    enter, leave = np.minimum(t1, t2).max(axis=1), np.maximum(t1, t2).min(axis=1)
    expected = np.where(enter <= leave, enter, np.inf)
    hits = HalfSpaces.of(block()).cast_rays(origins, directions)
    assert np.allclose(hits.distance, expected)
    assert ((hits.element >= 0) == np.isfinite(expected)).all()


def test_a_ray_passes_the_near_side_of_a_cylinder_that_is_cut_away():
    cut = Plane(np.zeros(3), np.array([1.0, 0, 0]))
    rod = Cylinder(np.zeros(3), np.array([0, 0, 1.0]), 10.0)
    hits = HalfSpaces.of([rod, cut]).cast_rays(np.array([[50.0, 0, 0]]), np.array([[-1.0, 0, 0]]))
    assert hits.distance[0] == pytest.approx(50.0)
    assert hits.element[0] == 1

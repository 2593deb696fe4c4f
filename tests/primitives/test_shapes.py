import numpy as np
import pytest

from primitives import pose
from primitives.errors import PalpateError
from primitives.shapes import Cone, Cylinder, Plane, Sphere, Torus, parameters


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def moved_by(rng):
    return pose.pose(pose.random_rotation(rng), rng.normal(size=3) * 30)


def test_parametrized_points_have_no_distance(shape, on_surface, rng):
    assert np.abs(shape.signed_distance(on_surface(shape, 300, rng))).max() < 1e-12


def test_distance_is_that_of_the_nearest_of_many_surface_points(shape, on_surface, rng):
    surface = on_surface(shape, 40000, rng)
    points = surface[:20] + rng.normal(size=(20, 3))
    brute = np.sqrt(((points[:, None] - surface[None]) ** 2).sum(axis=2)).min(axis=1)
    exact = np.abs(shape.signed_distance(points))
    assert (exact <= brute + 1e-9).all()
    assert np.median(brute - exact) < 0.1


def test_normal_is_the_gradient_of_distance(shape, rng):
    points = rng.normal(size=(200, 3)) * 10
    h = 1e-6 * np.eye(3)
    gradient = np.stack(
        [(shape.signed_distance(points + e) - shape.signed_distance(points - e)) / 2e-6 for e in h], 1
    )
    assert np.abs(gradient - shape.normals(points)).max() < 1e-6


def test_projection_lands_on_the_surface(shape, rng):
    points = rng.normal(size=(200, 3)) * 10
    assert np.abs(shape.signed_distance(shape.project(points))).max() < 1e-9


def test_curvature_is_the_turn_of_the_normal(shape, on_surface, rng):
    points = on_surface(shape, 100, rng)
    normals, curvatures = shape.normals(points), shape.principal_curvatures(points)
    for i in range(100):
        tangents = pose.frame_along(normals[i])[:, :2]
        ahead = points[i] + 1e-5 * tangents.T
        back = points[i] - 1e-5 * tangents.T
        weingarten = (shape.normals(ahead) - shape.normals(back)) @ tangents / 2e-5
        assert np.allclose(
            np.linalg.eigvalsh((weingarten + weingarten.T) / 2)[::-1], curvatures[i], atol=1e-6
        )


def test_retraction_and_local_step_undo_each_other(shape, rng):
    for _ in range(20):
        step = rng.normal(size=shape.dof) * 0.05
        assert np.allclose(shape.local(shape.retract(step)), step, atol=1e-12)


def test_distance_moves_with_the_shape(shape, rng):
    points, motion = rng.normal(size=(50, 3)) * 20, moved_by(rng)
    there = pose.transform_points(motion, points)
    assert np.allclose(
        shape.transformed(motion).signed_distance(there), shape.signed_distance(points), atol=1e-10
    )


@pytest.mark.parametrize("far", [0.0, 1e3, 1e6])
def test_rays_stop_at_the_first_crossing(shape, rng, far):
    # from well outside toward the shape; the oracle walks along the ray and watches the sign of the distance
    target = shape.anchor + 25 * shape.direction + rng.uniform(-8, 8, (300, 3))
    direction = rng.normal(size=(300, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origin = target - (60 + far) * direction
    hits = shape.cast_rays(origin, direction)
    found = np.isfinite(hits.distance)
    at = origin[found] + hits.distance[found, None] * direction[found]
    assert np.abs(shape.signed_distance(at)).max(initial=0) < 1e-8 * (1 + far)
    walk = np.linspace(0, 120, 1201) if not far else far + np.linspace(0, 120, 1201)
    for i in range(100):
        along = shape.signed_distance(origin[i] + walk[:, None] * direction[i])
        crossing = np.flatnonzero(along[:-1] * along[1:] < 0)
        if len(crossing):
            assert hits.distance[i] <= walk[crossing[0] + 1] + 1e-6
            if not far:
                assert abs(hits.distance[i] - walk[crossing[0]]) < 0.1 or along[: crossing[0]].min() < 0.05


def test_rays_inside_hit_from_within_and_rays_away_miss():
    ball = Sphere([0, 0, 0], 2.0)
    hits = ball.cast_rays(np.array([[0.0, 0, 0], [3.0, 0, 0]]), np.array([[1.0, 0, 0], [1.0, 0, 0]]))
    assert hits.distance[0] == pytest.approx(2.0)
    assert np.isinf(hits.distance[1])
    assert hits.element.tolist() == [0, -1]
    assert (hits.normals[1] == 0).all()


def test_torus_hole_lets_rays_through_and_tangent_rays_touch():
    ring = Torus([0, 0, 0], [0, 0, 1], 10.0, 3.0)
    start = np.array([[0.0, 0, 50], [13.0, 0, 50], [-50.0, 0, 0], [12.999, 0, 50], [13.001, 0, 50]])
    along = np.array([[0.0, 0, -1], [0, 0, -1.0], [1.0, 0, 0], [0, 0, -1.0], [0, 0, -1.0]])
    distance = ring.cast_rays(start, along).distance
    assert np.isinf(distance[0])
    assert distance[1] == pytest.approx(50.0, abs=1e-3)
    assert distance[2] == pytest.approx(37.0, abs=1e-9)
    assert distance[3] == pytest.approx(50 - np.sqrt(9 - 2.999**2), abs=1e-8)
    assert np.isinf(distance[4])


def test_cone_has_one_nappe():
    cone = Cone([0, 0, 0], [0, 0, 1], np.pi / 4)
    hits = cone.cast_rays(np.array([[-50.0, 0, -5], [-50, 0, 5]]), np.array([[1.0, 0, 0], [1.0, 0, 0]]))
    assert np.isinf(hits.distance[0])
    assert hits.distance[1] == pytest.approx(45.0)
    assert cone.signed_distance(np.array([[0.0, 0, -4]]))[0] == pytest.approx(4.0)


@pytest.mark.parametrize("axis", [[0, 0, 1.0], [0, 0, -1.0], [1.0, 0, 0], [1e-9, 0, -1.0], [0.3, -0.5, 0.2]])
def test_frame_is_a_rotation_with_the_axis_last(axis):
    rod = Cylinder([0, 0, 0], axis, 1.0)
    assert np.allclose(rod.frame.T @ rod.frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(rod.frame) == pytest.approx(1.0)
    assert np.allclose(rod.frame[:, 2], rod.axis)


def test_areas_are_those_of_textbooks():
    assert Plane([0, 0, 0], [0, 0, 1]).area((3.0, 4.0)) == 12.0
    assert Cylinder([0, 0, 0], [0, 0, 1], 2.0).area((5.0, 4 * np.pi)) == pytest.approx(20 * np.pi)
    assert Cone([0, 0, 0], [0, 0, 1], np.arctan(0.75)).area((0.0, 4.0)) == pytest.approx(np.pi * 3 * 5)
    assert Sphere([0, 0, 0], 3.0).area() == pytest.approx(36 * np.pi)
    assert Torus([0, 0, 0], [0, 0, 1], 5.0, 2.0).area() == pytest.approx(40 * np.pi**2)
    assert Plane([0, 0, 0], [0, 0, 1]).area() == np.inf


@pytest.mark.parametrize(
    "broken",
    [
        lambda: Sphere([0, 0, 0], 0.0),
        lambda: Sphere([0, 0, 0], np.nan),
        lambda: Sphere([0, np.inf, 0], 1.0),
        lambda: Plane([0, 0, 0], [0, 0, 0]),
        lambda: Cylinder([0, 0, 0], [0, 0, 1], -1.0),
        lambda: Cone([0, 0, 0], [0, 0, 1], np.pi / 2),
        lambda: Torus([0, 0, 0], [0, np.nan, 1], 3.0, 1.0),
    ],
)
def test_impossible_shapes_are_refused_in_one_line(broken):
    with pytest.raises(PalpateError) as caught:
        broken()
    assert "\n" not in str(caught.value)


def test_arrays_cannot_be_written(shape):
    with pytest.raises(ValueError, match="read-only"):
        shape.anchor[0] = 1.0


def test_parameters_carry_what_the_shape_has_and_no_more(shape):
    expected = {
        "plane": {"origin_mm", "axis"},
        "cylinder": {"origin_mm", "axis", "radius_mm"},
        "cone": {"origin_mm", "axis", "semi_angle_deg"},
        "sphere": {"origin_mm", "radius_mm"},
        "torus": {"origin_mm", "axis", "radius_mm", "minor_radius_mm"},
    }
    assert set(parameters(shape)) == expected[shape.kind]

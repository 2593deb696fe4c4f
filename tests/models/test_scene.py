import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models import parts
from models.csg import Cube, Cylinder, Sphere
from models.scene import Scene, table_under
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import pose, random_rotation
from primitives.surface import TriangleSurface


def test_a_scene_feels_the_nearest_and_hits_the_first() -> None:
    near, far = Solid.from_csg(Sphere(5)), Solid.from_csg(Cube((10, 10, 10))).placed(pose(None, (30, 0, 0)))
    scene = Scene([near, far])
    points = np.array([[0.0, 0, 0], [30, 0, 0], [20, 0, 0], [10, 0, 0]])
    np.testing.assert_allclose(scene.signed_distance(points), [-5, -5, 5, 5], atol=0.01)
    hits = scene.cast_rays(
        np.array([[-50.0, 0, 0], [80, 0, 0], [0, 0, 50]]), np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0]])
    )
    np.testing.assert_allclose(hits.distance, [45, 45, np.inf], atol=0.01)
    assert scene.solid_of(hits.element).tolist() == [0, 1, -1]
    np.testing.assert_allclose(hits.normals[:2], [[-1, 0, 0], [1, 0, 0]], atol=0.01)
    np.testing.assert_allclose(scene.normals(points[2:]), [[-1, 0, 0], [1, 0, 0]], atol=0.02)


def test_a_scene_numbers_triangles_through() -> None:
    scene = Scene(
        [Solid.from_csg(Cube((10, 10, 10))), Solid.from_csg(Cube((9, 9, 9))).placed(pose(None, (40, 0, 0)))]
    )
    rng = np.random.default_rng(5)
    origins = rng.normal(size=(300, 3))
    origins *= 60 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-15, 15, (300, 3)) - origins
    rays = origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)
    hits = scene.cast_rays(*rays)
    distance, triangle = scene.first_hits(*(x.astype(np.float32) for x in rays))
    np.testing.assert_array_equal(hits.element, triangle)
    reached = rays[0][triangle >= 0] + distance[triangle >= 0, None] * rays[1][triangle >= 0]
    corner = scene.vertices[scene.triangles[triangle[triangle >= 0]]]
    a, b, c = np.moveaxis(corner, 1, 0)
    normal = np.cross(b - a, c - a)
    assert np.abs(np.einsum("ij,ij->i", normal, reached - a)).max() < 1e-2


BALLS = [
    Solid.from_csg(Sphere(r), 0.02).placed(pose(None, c))
    for r, c in ((9, (0, 0, 0)), (5, (20, 3, 1)), (7, (4, 25, 6)))
]


def test_a_scene_is_a_surface_made_of_triangles() -> None:
    assert isinstance(Scene(BALLS), TriangleSurface)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_distance_and_normal_are_those_of_the_union_in_closed_form(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-30, 45, (50, 3))
    centers, radii = np.array([b.pose[:3, 3] for b in BALLS]), np.array([9, 5, 7])
    away = np.linalg.norm(points[:, None] - centers, axis=2) - radii
    scene = Scene(BALLS)
    np.testing.assert_allclose(scene.signed_distance(points), away.min(axis=1), atol=0.03)
    clear = np.sort(away, axis=1)[:, 1] - away.min(axis=1) > 0.1
    out = points - centers[away.argmin(axis=1)]
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    assert (np.einsum("ij,ij->i", scene.normals(points), out)[clear] > 0.99).all()


def test_rays_meet_the_scene_where_they_meet_the_union_of_its_solids() -> None:
    trees = [Cylinder(10, 30), Cube((12, 14, 16)).turned((1, 2, 3), 0.7).at(30, 5, 0)]
    scene, union = Scene([Solid.from_csg(t) for t in trees]), Solid.from_csg(trees[0] | trees[1])
    rng = np.random.default_rng(1)
    origins = rng.uniform(-1, 1, (500, 3)) * 20 + [15, 0, 70]
    directions = rng.uniform(-1, 1, (500, 3)) * [20, 15, 10] + [15, 0, 0] - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    ours, theirs = scene.cast_rays(origins, directions), union.cast_rays(origins, directions)
    assert (np.isfinite(ours.distance) == np.isfinite(theirs.distance)).mean() > 0.99
    both = np.isfinite(ours.distance) & np.isfinite(theirs.distance)
    assert both.sum() > 200
    assert np.quantile(np.abs(ours.distance[both] - theirs.distance[both]), 0.99) < 1e-3


@pytest.mark.parametrize("name", ["bracket", "sphere", "pulley"])
def test_a_part_lies_on_its_table(name: str) -> None:
    rng = np.random.default_rng(3)
    part = Solid.from_csg(parts.build(name), 0.02).placed(pose(random_rotation(rng), (5, -7, 30)))
    table = table_under(part)
    assert table.bounds[1, 2] == pytest.approx(part.bounds[0, 2])
    assert (table.bounds[0, :2] < part.bounds[0, :2] - 100).all()
    assert (table.bounds[1, :2] > part.bounds[1, :2] + 100).all()
    scene = Scene([part, table])
    beside = np.array([[table.bounds[0, 0] + 10, table.bounds[0, 1] + 10, table.bounds[1, 2] + 4]])
    assert scene.signed_distance(beside) == pytest.approx([4], abs=1e-6)
    np.testing.assert_allclose(scene.normals(beside), [[0, 0, 1]], atol=1e-9)
    np.testing.assert_allclose(scene.bounds[0], table.bounds[0])


def test_neighbors_of_triangles_stay_within_their_solid() -> None:
    scene = Scene(BALLS)
    mine = scene.solid_of(np.arange(len(scene.triangles)))
    assert (scene.solid_of(scene.neighbors.ravel()).reshape(-1, 3) == mine[:, None]).all()


def test_a_scene_of_nothing_is_refused() -> None:
    with pytest.raises(PalpateError, match="needs a solid"):
        Scene([])

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.meshing.facets import facets
from models.solid import TOLERANCE, Solid, iou
from primitives.errors import PalpateError
from primitives.pose import pose, random_rotation, rotate, transform_points
from primitives.surface import TriangleSurface

CLOSED_FORMS = [
    (Cube((60, 40, 12)), 60 * 40 * 12),
    (Cylinder(20, 40), pi * 400 * 40),
    (Cone(20, 10, 30), pi * 10 * (400 + 200 + 100)),
    (Cone(20, 0, 30), pi * 400 * 10),
    (Cone(0, 20, 30), pi * 400 * 10),
    (Sphere(25), 4 / 3 * pi * 25**3),
    (Cube((40, 40, 20)) - Cylinder(10, 40), 40 * 40 * 20 - pi * 100 * 20),
    (Cylinder(10, 20) | Cylinder(5, 60), pi * (100 * 20 + 25 * 40)),
    (Sphere(40).at(0, 0, -24) & Sphere(40).at(0, 0, 24), 2 * pi * 16**2 * (3 * 40 - 16) / 3),
    (Cylinder(10, 80) & Cylinder(10, 80).turned("x", pi / 2), 16 / 3 * 1000),
]
MIXED = (Cylinder(20, 40) & Cube((60, 30, 60))) - Cylinder(5, 99).turned("x", pi / 2)


@pytest.mark.parametrize(("tree", "volume"), CLOSED_FORMS)
def test_volume_agrees_with_the_closed_form(tree: Csg, volume: float) -> None:
    assert Solid.from_csg(tree).volume == pytest.approx(volume, rel=2e-5)


@pytest.mark.parametrize(
    "tree", [Cylinder(20, 40), Cone(30, 10, 30), Cone(20, 0, 30), Sphere(25), Cylinder(0.5, 2)]
)
@pytest.mark.parametrize("tolerance", [TOLERANCE, 0.05])
def test_facets_stay_within_the_tolerance(tree: Csg, tolerance: float) -> None:
    made = facets(tree, tolerance)
    corners = made.vertices[made.triangles]
    weights = np.random.default_rng(0).dirichlet(np.ones(3) / 2, 30)
    points = np.concatenate([np.einsum("wc,tcd->wtd", weights, corners), np.moveaxis(corners, 1, 0)])
    points = np.concatenate([points, corners.mean(axis=1)[None]])
    for number, shape in enumerate(made.surfaces):
        away = shape.signed_distance(points[:, made.surface == number].reshape(-1, 3))
        assert np.abs(away).max() <= tolerance * 1.01


def test_parts_are_counted_whatever_their_cavities() -> None:
    ball = Sphere(10.0)
    assert Solid.from_csg(ball - Sphere(5.0)).parts == 1
    assert Solid.from_csg((ball - Sphere(5.0)) | ball.at(30, 0, 0)).parts == 2


def test_a_fifty_millimeter_sphere_stays_below_a_hundred_thousand_triangles() -> None:
    assert len(Solid.from_csg(Sphere(50)).triangles) < 100_000


def test_every_triangle_lies_on_the_surface_it_names() -> None:
    solid = Solid.from_csg(MIXED)
    corners = solid.vertices[solid.triangles]
    for number in np.unique(solid.face_of_triangle):
        away = solid.surfaces[number].shape.signed_distance(
            corners[solid.face_of_triangle == number].reshape(-1, 3)
        )
        assert np.abs(away).max() < 1.5 * TOLERANCE


def test_every_triangle_faces_as_its_surface_says() -> None:
    solid = Solid.from_csg(MIXED)
    middle = solid.vertices[solid.triangles].mean(axis=1)
    exact = solid.body.exact_normals(middle, np.arange(len(middle)))
    assert (np.einsum("ij,ij->i", exact, solid.body.triangle_normals) > 0.999).all()


def test_holes_are_concave_and_bosses_convex() -> None:
    kinds = {(s.shape.kind, s.convex, s.leaf) for s in Solid.from_csg(Cylinder(20, 10) - Sphere(8)).surfaces}
    assert ("sphere", False, 1) in kinds
    assert ("cylinder", True, 0) in kinds


def test_neighbors_share_the_edge_they_name() -> None:
    solid = Solid.from_csg(MIXED)
    for corner in range(3):
        edge = np.stack([solid.triangles[:, corner], solid.triangles[:, (corner + 1) % 3]], axis=1)
        other = solid.triangles[solid.neighbors[:, corner]]
        assert (other[:, :, None] == edge[:, None, :]).any(axis=1).all()


def test_a_solid_is_a_triangle_surface() -> None:
    assert isinstance(Solid.from_csg(Cube((1, 1, 1))), TriangleSurface)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_distance_normals_and_hits_move_with_the_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world_from_part = pose(random_rotation(rng), rng.uniform(-200, 200, 3))
    part = Solid.from_csg(MIXED, tolerance=0.05)
    placed = part.placed(world_from_part)
    points = rng.uniform(-30, 30, (50, 3))
    there = transform_points(world_from_part, points)
    np.testing.assert_allclose(placed.signed_distance(there), part.signed_distance(points), atol=1e-9)
    turned = np.abs(placed.normals(there) - rotate(world_from_part, part.normals(points))).max(axis=1)
    assert (turned < 1e-6).mean() >= 0.7  # a point with two nearest points may take either


def test_normals_are_those_of_the_exact_surface() -> None:
    outward = np.random.default_rng(0).normal(size=(100, 3))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    normals = Solid.from_csg(Sphere(25), tolerance=0.01).normals(25 * outward)
    np.testing.assert_allclose(normals, outward, atol=1e-4)


def test_center_and_bounds_follow_the_pose() -> None:
    placed = Solid.from_csg(Cone(20, 0, 40)).placed(pose(None, (100, 0, 0)))
    np.testing.assert_allclose(placed.center, [100, 0, -10], atol=1e-3)
    np.testing.assert_allclose(placed.bounds, [[80, -20, -20], [120, 20, 20]], atol=0.003)


def test_iou_of_half_overlapping_cubes_is_a_third() -> None:
    cube = Solid.from_csg(Cube((10, 10, 10)))
    assert iou(cube, cube) == pytest.approx(1)
    assert iou(cube, cube.placed(pose(None, (5, 0, 0)))) == pytest.approx(1 / 3)
    assert iou(cube, cube.placed(pose(None, (50, 0, 0)))) == 0


def test_booleans_respect_where_solids_are_placed() -> None:
    cube = Solid.from_csg(Cube((10, 10, 10)))
    moved = cube.placed(pose(None, (5, 0, 0)))
    volumes = [cube.boolean(moved, kind).volume for kind in ("union", "intersection", "difference")]
    np.testing.assert_allclose(volumes, [1500, 500, 500])


def test_a_mesh_makes_the_same_solid() -> None:
    solid = Solid.from_csg(MIXED)
    again = Solid.from_mesh(solid.vertices, solid.triangles)
    assert again.volume == pytest.approx(solid.volume, rel=1e-9)
    assert iou(again, solid) == pytest.approx(1, abs=1e-6)


def test_nothing_left_and_open_meshes_are_refused() -> None:
    with pytest.raises(PalpateError, match="no material left"):
        Solid.from_csg(Cube((1, 1, 1)) & Cube((1, 1, 1)).at(5, 0, 0))
    with pytest.raises(PalpateError, match="not a closed solid"):
        Solid.from_mesh(np.eye(3), [[0, 1, 2]])

import numpy as np
import pytest

from models import raycast
from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.raycast import EmbreeCaster, PortableCaster
from models.rays.triangle_tree import TriangleTree
from models.solid import Solid
from primitives import shapes
from primitives.pose import pose, random_rotation, transform_points

needs_embree = pytest.mark.skipif(not raycast.has_embree(), reason="embreex is not installed")
CORNERED = (Cylinder(20, 40) & Cube((60, 30, 60))) - Sphere(12).at(0, 0, 20)


def _rays(n: int, seed: int, reach: float = 60) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    origins = rng.normal(size=(n, 3))
    origins *= reach / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-15, 15, (n, 3)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _casters(solid: Solid) -> dict[str, raycast.RayCaster]:
    portable: dict[str, raycast.RayCaster] = {
        "portable": PortableCaster(TriangleTree(solid.body.vertices, solid.body.triangles))
    }
    if raycast.has_embree():
        portable["embree"] = EmbreeCaster(solid.body.vertices, solid.body.triangles)
    return portable


@pytest.mark.parametrize(
    ("tree", "shape"),
    [
        (Sphere(25), shapes.Sphere(np.zeros(3), 25)),
        (Cylinder(20, 4000), shapes.Cylinder(np.zeros(3), np.array([0.0, 0, 1]), 20)),
        (Cone(0, 2000, 4000), shapes.Cone(np.array([0.0, 0, -2000]), np.array([0.0, 0, 1]), np.arctan(0.5))),
    ],
)
def test_hits_agree_with_analytic_rays(tree: Csg, shape: shapes.Shape) -> None:
    origins, directions = _rays(500, 1, 3000 if isinstance(tree, Cone) else 60)
    solid = Solid.from_csg(tree)
    exact = shape.cast_rays(origins, directions)
    outside = shape.signed_distance(origins) > 1
    square = np.abs(np.einsum("ij,ij->i", exact.normals, directions)) > 0.3
    rows = outside & square & (np.abs(origins[:, 2] + exact.distance * directions[:, 2]) < 1990)
    assert rows.sum() > 50
    tolerance = 0.02 if isinstance(tree, Cone) else 0.008
    for caster in _casters(solid).values():
        distance, triangle = caster.first_hits(origins.astype(np.float32), directions.astype(np.float32))
        np.testing.assert_allclose(distance[rows], exact.distance[rows], atol=tolerance)
        assert (triangle[rows] >= 0).all()


@needs_embree
def test_portable_and_embree_casters_agree() -> None:
    solid = Solid.from_csg(CORNERED)
    origins, directions = (x.astype(np.float32) for x in _rays(5000, 2))
    casters = _casters(solid)
    (a, i), (b, j) = (casters[k].first_hits(origins, directions) for k in ("embree", "portable"))
    assert ((i < 0) == (j < 0)).mean() > 0.999
    both = (i >= 0) & (j >= 0)
    assert np.abs(a[both] - b[both]).max() < 1e-3
    assert (i == j)[both].mean() > 0.99


def test_misses_are_infinite_and_minus_one() -> None:
    solid = Solid.from_csg(Cube((10, 10, 10)))
    origins, up = (
        np.array([[0, 0, 50], [0, 0, 50]], np.float32),
        np.array([[0, 0, 1], [0, 0, -1]], np.float32),
    )
    for caster in _casters(solid).values():
        distance, triangle = caster.first_hits(origins, up)
        assert distance[0] == np.inf
        assert triangle[0] == -1
        assert distance[1] == pytest.approx(45)


def test_rays_through_edges_and_corners_hit() -> None:
    solid = Solid.from_csg(Cube((10, 10, 10)))
    grid = np.linspace(-5, 5, 21)[1:-1]
    x, y = np.meshgrid(grid, grid)
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, 20)], axis=1).astype(np.float32)
    down = np.tile(np.array([0, 0, -1], np.float32), (x.size, 1))
    for caster in _casters(solid).values():
        np.testing.assert_allclose(caster.first_hits(origins, down)[0], 15, atol=1e-5)


def test_posed_hits_are_right_to_a_micrometer_across_the_workspace() -> None:
    rng = np.random.default_rng(3)
    part = Solid.from_csg(Cube((60, 40, 12)))
    for _ in range(20):
        world_from_part = pose(random_rotation(rng), rng.uniform(-250, 250, 3))
        origins, directions = _rays(200, 4)
        exact = part.cast_rays(origins, directions)
        moved = transform_points(world_from_part, origins)
        found = part.placed(world_from_part).cast_rays(moved, directions @ world_from_part[:3, :3].T)
        rows = np.isfinite(exact.distance) & np.isfinite(found.distance)
        assert rows.sum() > 20
        square = np.abs(np.einsum("ij,ij->i", exact.normals, directions)) > 0.3
        rows &= square
        assert np.abs(exact.distance[rows] - found.distance[rows]).max() < 1e-3


def test_the_portable_caster_is_chosen_without_embree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(raycast, "EmbreeScene", None)
    solid = Solid.from_csg(Cube((10, 10, 10)))
    assert isinstance(solid.body.caster, PortableCaster)

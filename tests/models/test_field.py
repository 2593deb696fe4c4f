"""The body where a field is negative, and polyhedra that are meshes."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from models.boundary import boundary
from models.csg import Cube, Polyhedron
from models.solid import Solid
from primitives.errors import PalpateError

HALF = np.array([12.0, 12.0, 12.0])


def ball(places):
    return np.linalg.norm(places, axis=1) - 10.0


def test_the_body_of_a_field_closes_within_the_square_of_its_grid():
    coarse, fine = (Solid.from_field(ball, -HALF, HALF, step) for step in (2.0, 1.0))
    true = 4.0 / 3.0 * np.pi * 1000.0
    assert abs(fine.volume / true - 1.0) < 0.02
    assert abs(fine.volume - true) < 0.4 * abs(coarse.volume - true)
    assert fine.parts == 1


def test_a_body_thinner_than_the_grid_is_found_and_one_that_is_not_there_is_told():
    thin = np.array([12.0, 12.0, 1.5])
    slab = Solid.from_field(lambda p: np.abs(p[:, 2]) - 0.5, -thin, thin, 40.0)
    assert slab.bounds[1, 2] < 1.5
    with pytest.raises(PalpateError, match="not a closed solid"):
        Solid.from_field(lambda p: np.ones(len(p)), -HALF, HALF, 2.0)


def test_a_polyhedron_of_very_many_planes_is_one_freeform_face():
    def hull_of(count):
        ways = np.random.default_rng(0).normal(size=(count, 3))
        hull = ConvexHull(ways / np.linalg.norm(ways, axis=1, keepdims=True) * 20.0)
        a, b, c = np.moveaxis(hull.points[hull.simplices], 1, 0)
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
        faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
        return Polyhedron(tuple(map(tuple, hull.points.tolist())), tuple(map(tuple, faces.tolist())))

    few = boundary(Solid.from_csg(hull_of(40)))
    assert {face.kind for face in few.faces} == {"plane"}
    cut = boundary(Solid.from_csg(hull_of(400) - Cube((60.0, 60.0, 20.0)).at(0.0, 0.0, 20.0)))
    assert sorted(face.kind for face in cut.faces) == ["freeform", "plane"]

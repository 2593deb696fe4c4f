"""Contacts that all lie on one round face are known for that, and say little of how large the rest is."""

import numpy as np
import pytest

from models.csg import Cone, Cube, Cylinder, Sphere
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence, match
from recognition.matching.round_face import round_face

NOISE, TURN = 0.3, np.deg2rad(3.0) / np.sqrt(2.0)


def _felt(points, normals, seed=0, bare=False):
    rng = np.random.default_rng(seed)
    world = pose(random_rotation(rng), rng.uniform(-50.0, 50.0, 3))
    turned = normals + TURN * rng.standard_normal(normals.shape)
    turned = rotate(world, turned / np.linalg.norm(turned, axis=1, keepdims=True))
    there = transform_points(world, points) + NOISE * rng.standard_normal(points.shape)
    return Contacts.of(there, None if bare else turned, NOISE, TURN)


def _on(tree, count, seed=0):
    """Even over the surface of a solid."""
    body, rng = Solid.from_csg(tree).body, np.random.default_rng(seed)
    a, b, c = np.moveaxis(body.vertices[body.triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    t = rng.choice(len(area), count, p=area / area.sum())
    r, w = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    points = (1 - r) * a[t] + r * (1 - w) * b[t] + r * w * c[t]
    return points, body.exact_normals(points, t)


def _side(tree, count, seed=0):
    """Of these the ones on faces that are round."""
    points, normals = _on(tree, 20 * count, seed)
    rows = np.flatnonzero(np.abs(normals[:, 2]) < 0.95)[:count]
    return points[rows], normals[rows]


@pytest.mark.parametrize("tree", [Cylinder(15.0, 60.0), Cone(12.0, 24.0, 40.0), Sphere(20.0)])
@pytest.mark.parametrize("count", [8, 20, 100])
def test_a_round_face_is_known(tree, count):
    assert round_face(_felt(*_side(tree, count)))


def test_points_alone_know_it_where_there_are_enough():
    points, normals = _side(Cylinder(15.0, 60.0), 40)
    assert round_face(_felt(points, normals, bare=True))
    assert not round_face(_felt(points[:8], normals[:8], bare=True))


@pytest.mark.parametrize("tree", [
    Cube((40.0, 30.0, 20.0)),
    Cylinder(15.0, 20.0),
    Cylinder(15.0, 40.0) | Cylinder(9.0, 40.0).at(0.0, 0.0, 30.0),
])  # fmt: skip
@pytest.mark.parametrize("count", [20, 50])
def test_a_body_with_other_faces_is_not(tree, count):
    assert not round_face(_felt(*_on(tree, count)))


def test_noise_that_nobody_told_says_nothing():
    contacts = _felt(*_side(Cylinder(15.0, 60.0), 30))
    assert Evidence(contacts).round_face
    assert not Evidence(contacts, scale_known=False).round_face


def test_a_rod_that_is_only_part_of_an_object_is_not_believed_to_be_all_of_it():
    small = Cylinder(15.0, 60.0)
    large = small | Cube((160.0, 120.0, 60.0)).at(0.0, 0.0, -60.0)
    library = Library.of({"rod": Solid.from_csg(small), "rod on a block": Solid.from_csg(large)})
    for seed in range(3):
        points, normals = _side(small, 50, seed)
        top = points[:, 2] > points[:, 2].min() + 5.0
        belief = match(Evidence(_felt(points[top], normals[top], seed)), library)
        assert belief.probabilities["rod"] < 0.97
        assert belief.probabilities["rod on a block"] > 0.02

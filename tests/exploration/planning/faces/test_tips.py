"""Tips of turned parts, of which few contacts were felt."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.faces.tips import tipped
from primitives.cone import Cone
from primitives.cylinder import Cylinder
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.pose import random_rotation
from primitives.sphere import Sphere

UP = np.eye(3)[2]


def felt(shape, places, rng, noise=0.03):
    """Contacts of a shape under (n, 2) places beside the z axis, two or three to a touch."""
    down = np.column_stack([places, np.full(len(places), 60.0)])
    on = shape.project(down)
    normals = shape.normals(on) + rng.normal(0.0, 0.03, on.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = on + noise * rng.standard_normal(on.shape)
    return Contacts.of(points, normals, 0.03, 0.03, touch=np.arange(len(on)) // 3)


def flank(rng):
    """A cone about the z axis that was felt all round."""
    turn, high = rng.uniform(0.0, 2.0 * np.pi, 80), rng.uniform(0.0, 45.0, 80)
    cone = Cone([0.0, 0.0, 60.0], -UP, np.arctan(25.0 / 60.0))
    points = cone.project(np.column_stack([25.0 * np.cos(turn), 25.0 * np.sin(turn), high]))
    contacts = Contacts.of(points, cone.normals(points), 0.02, 0.02, touch=np.arange(80) // 4)
    return Face(0, fit("cone", contacts), contacts)


def moved(graph, rng):
    """The same graph at some attitude, fitted again."""
    turn, faces = random_rotation(rng), []
    for face in graph.faces:
        contacts = replace(
            face.contacts, points=face.contacts.points @ turn.T, normals=face.contacts.normals @ turn.T
        )
        faces.append(Face(face.id, fit(face.fit.kind, contacts), contacts))
    return PatchGraph(tuple(faces)), turn


@pytest.mark.parametrize("seed", range(6))
def test_a_cap_that_was_read_as_a_cylinder_is_a_sphere_on_the_axis(seed):
    rng = np.random.default_rng(seed)
    cap = Sphere([0.0, 0.0, 18.0], 36.0)
    contacts = felt(cap, rng.uniform(-5.5, 5.5, (12, 2)), rng)
    read = fit("cylinder", contacts)
    assert isinstance(read, Fit)
    graph, turn = moved(PatchGraph((flank(rng), Face(1, read, contacts))), rng)
    found = tipped(graph).faces[1].fit
    assert found.kind == "sphere"
    assert found.convex
    assert np.linalg.norm((turn.T @ found.shape.center)[:2]) < 0.1
    assert found.shape.radius == pytest.approx(36.0, rel=0.15)


def test_a_ridge_across_the_axis_and_a_bump_beside_it_stay_what_they_are():
    rng = np.random.default_rng(9)
    ridge = felt(Cylinder([0.0, 0.0, 40.0], [1.0, 0.0, 0.0], 9.0), rng.uniform(-6.0, 6.0, (12, 2)), rng)
    beside = felt(
        Sphere([20.0, 0.0, 40.0], 9.0), rng.uniform(-5.0, 5.0, (12, 2)) + np.array([20.0, 0.0]), rng
    )
    for contacts in (ridge, beside):
        graph = PatchGraph((flank(rng), Face(1, fit("cylinder", contacts), contacts)))
        assert tipped(graph).faces[1] is graph.faces[1]


def test_many_contacts_and_those_that_nobody_felt_tell_for_themselves():
    rng = np.random.default_rng(10)
    many = felt(Sphere([0.0, 0.0, 18.0], 36.0), rng.uniform(-5.5, 5.5, (40, 2)), rng)
    for contacts in (many, replace(many.select(np.arange(12)), touch=np.full(12, NOT_FELT))):
        read = Face(1, fit("cylinder", contacts), contacts)
        assert tipped(PatchGraph((flank(rng), read))).faces[1] is read

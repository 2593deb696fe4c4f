"""A boss on a lever, felt by two touches that named no face."""

import numpy as np
import pytest

from exploration.planning.faces.coaxial import coaxial_face
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose, random_rotation, rotate, transform_points

Z = np.eye(3)[2]


def contacts(radius, turns, rng, world, side=1.0, touch=0, high=(12.0, 22.0)):
    """Of a cylinder round z, four of each touch, at its turn."""
    turn = np.repeat(turns, 4) + np.tile([-0.06, -0.02, 0.02, 0.06], len(turns))
    ways = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(len(turn))])
    points = (radius + 0.02 * rng.standard_normal((len(turn), 1))) * ways
    points[:, 2] = rng.uniform(*high, len(turn))
    touches = touch + np.repeat(np.arange(len(turns)), 4)
    return Contacts.of(transform_points(world, points), rotate(world, side * ways), 0.03, 0.03, touch=touches)


def lever(rng, world):
    base = contacts(20.0, np.linspace(0.0, 3.0, 12), rng, world, high=(1.0, 11.0))
    return PatchGraph((ranked_face(0, base, MergeOptions()),), ())


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_two_touches_round_a_known_axis_are_a_cylinder(side):
    rng = np.random.default_rng(1)
    world = pose(random_rotation(rng), [10.0, -20.0, 30.0])
    graph = lever(rng, world)
    stray = Contacts.of(transform_points(world, [[3.0, 40.0, 5.0]]), rotate(world, [Z]), 0.03, 0.03, touch=90)
    loose = Contacts.concatenate([contacts(15.0, [0.3, 1.8], rng, world, side, 50), stray])
    face = coaxial_face(graph, loose)
    assert len(face.contacts) == 8
    assert face.id == 1
    assert face.fit.convex == (side > 0)
    assert face.fit.shape.radius == pytest.approx(15.0, abs=0.1)
    axis = graph.faces[0].fit.shape.axis
    assert abs(face.fit.shape.axis @ axis) > 0.9999


def test_one_touch_or_two_beside_each_other_or_of_other_radii_are_none():
    rng, world = np.random.default_rng(2), np.eye(4)
    graph = lever(rng, world)
    assert coaxial_face(graph, contacts(15.0, [0.3], rng, world)) is None
    assert coaxial_face(graph, contacts(15.0, [0.3, 0.5], rng, world)) is None
    apart = [contacts(15.0 + k, [1.8 * k], rng, world, touch=k) for k in (0, 1)]
    assert coaxial_face(graph, Contacts.concatenate(apart)) is None
    assert coaxial_face(graph, Contacts.of([])) is None
    assert coaxial_face(PatchGraph((), ()), contacts(15.0, [0.3, 1.8], rng, world)) is None

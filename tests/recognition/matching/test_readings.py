"""A coarse mesh may be what it was made for, or just what it is."""

import numpy as np
import pytest

from models.csg import Cylinder
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence, match
from recognition.matching.readings import Weighed, read_both

RADIUS, HALF, FACETS = 20.0, 30.0, 32
NOISE, TURN = 0.3, 0.037


def _prism():
    around = 2.0 * np.pi * np.arange(FACETS) / FACETS
    ring = RADIUS * np.column_stack([np.cos(around), np.sin(around)])
    ends = [np.column_stack([ring, np.full(FACETS, z)]) for z in (-HALF, HALF)]
    vertices = np.vstack([*ends, [0.0, 0.0, -HALF], [0.0, 0.0, HALF]])
    k = np.arange(FACETS)
    n, low, high = (k + 1) % FACETS, np.full(FACETS, 2 * FACETS), np.full(FACETS, 2 * FACETS + 1)
    sides = [np.column_stack([k, n, n + FACETS]), np.column_stack([k, n + FACETS, k + FACETS])]
    caps = [np.column_stack([n, k, low]), np.column_stack([k + FACETS, n + FACETS, high])]
    return Solid.from_mesh(vertices, np.vstack([*sides, *caps]))


LIBRARY = Library.of({"mesh": _prism(), "rod": Solid.from_csg(Cylinder(RADIUS, 2.0 * HALF))})


def _felt(flat, seed):
    """Contacts all over the side and one end, with normals as facets have them, or as the round face has."""
    rng = np.random.default_rng(seed)
    around, height = rng.uniform(0.0, 2.0 * np.pi, 30), rng.uniform(-HALF, HALF, 30)
    fold = 2.0 * np.pi / FACETS
    facing = (np.floor(around / fold) + 0.5) * fold if flat else around
    normals = np.column_stack([np.cos(facing), np.sin(facing), np.zeros(30)])
    points = np.column_stack([RADIUS * np.cos(around), RADIUS * np.sin(around), height])
    points[:6] = np.column_stack([rng.uniform(-12.0, 12.0, (6, 2)), np.full(6, HALF)])
    normals[:6] = [0.0, 0.0, 1.0]
    world = pose(random_rotation(rng), rng.normal(size=3) * 40.0)
    turned = normals + TURN * rng.standard_normal(normals.shape)
    turned = rotate(world, turned / np.linalg.norm(turned, axis=1, keepdims=True))
    there = transform_points(world, points) + NOISE * rng.standard_normal(points.shape)
    return Evidence(Contacts.of(there, turned, NOISE, TURN))


def test_a_part_that_has_the_facets_is_told_from_one_that_is_round():
    for seed in range(3):
        assert match(_felt(True, seed), LIBRARY).probabilities["mesh"] > 0.9


def test_a_round_part_is_still_what_the_mesh_stands_for():
    alone = {"mesh": LIBRARY["mesh"]}
    for seed in range(3):
        assert match(_felt(False, seed), alone).probabilities["mesh"] > 0.9


def test_the_two_readings_are_one_half_each_and_each_contact_is_as_the_likelier_has_it():
    bent = Weighed(np.array([[0.0, 1.0]]), np.array([-3.0]), np.array([-9.0]))
    flat = Weighed(np.array([[5.0, 6.0]]), np.array([-1.0]), np.array([-9.0]))
    both = read_both([bent, flat])
    assert both.known[0] == pytest.approx(np.log(0.5 * np.exp(-3.0) + 0.5 * np.exp(-1.0)))
    assert both.unlike[0] == pytest.approx(-9.0)
    assert both.each.tolist() == [[5.0, 6.0]]
    assert read_both([bent]) is bent

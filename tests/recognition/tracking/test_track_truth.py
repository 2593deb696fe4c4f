"""The evaluator, asked about samples whose distance from the object is known."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.tracking.truth import edge_truth, surface_truth

AWAY = pose(random_rotation(np.random.default_rng(5)), [30.0, -20.0, 10.0])


def test_points_on_a_rim_are_on_it_and_points_beside_it_as_far_as_they_are():
    solid = Solid.from_csg(Cylinder(20.0, 30.0)).placed(AWAY)
    t = np.linspace(0, 2 * np.pi, 100)
    for off in (0.0, 0.05, 0.3):
        ring = np.column_stack([(20 + off) * np.cos(t), (20 + off) * np.sin(t), np.full(100, 15.0)])
        told = edge_truth(solid, transform_points(AWAY, ring))
        assert told["rms_mm"] == pytest.approx(off, abs=1e-3)
        assert told["share_within_0_1_mm"] == (off < 0.1)
        assert told["dihedral_deg"] == pytest.approx(90.0, abs=0.1)
        assert told["edges"] == 1


def test_each_side_of_a_face_is_compared_with_its_own_edge():
    solid = Solid.from_csg(Cube((40.0, 30.0, 20.0)))
    x, y = np.linspace(-18, 18, 30), np.linspace(-13, 13, 30)
    points = [np.column_stack([x, 0 * x + s * 15.0, 0 * x + 10.0]) for s in (1, -1)]
    points += [np.column_stack([0 * y + s * 20.0, y, 0 * y + 10.2]) for s in (1, -1)]
    told = edge_truth(solid, np.concatenate(points))
    assert told["edges"] == 4
    assert told["max_mm"] == pytest.approx(0.2, abs=1e-9)


def test_edges_that_are_drawn_by_their_ends_alone_were_tracked_too():
    solid = Solid.from_csg(Cube((100.0, 12.0, 8.0))).placed(AWAY)
    x = np.linspace(-46.0, 46.0, 93)
    long = [np.column_stack([s * x, 0 * x - 6.0, 0 * x + s * 4.0]) for s in (1.0, -1.0)]
    short = [np.array([[s * 50.0, -6.0, s * 4.0], [s * 50.0, -6.0, -s * 4.0]]) for s in (1.0, -1.0)]
    around = [transform_points(AWAY, trace) for pair in zip(long, short, strict=True) for trace in pair]
    told = edge_truth(solid, *around)
    assert (told["edges"], told["length_mm"]) == (4, pytest.approx(216.0))
    assert told["max_mm"] == pytest.approx(0.0, abs=1e-9)


def test_what_has_no_edge_has_no_truth_of_one():
    assert edge_truth(Solid.from_csg(Sphere(20.0)), np.zeros((3, 3))) is None


def test_contacts_are_compared_with_the_exact_surface_and_not_with_its_facets():
    solid = Solid.from_csg(Sphere(20.0), 0.2).placed(AWAY)
    way = np.random.default_rng(1).normal(size=(50, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    contacts = Contacts.of(transform_points(AWAY, 20.03 * way), rotate(AWAY, way))
    told = surface_truth(solid, contacts)
    assert told["rms_mm"] == pytest.approx(0.03, abs=1e-6)
    assert told["shape"] == "sphere"
    assert told["normal_rms_deg"] < 0.5

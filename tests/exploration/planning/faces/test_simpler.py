"""Flat sides that stray contacts bend."""

import numpy as np

from exploration.planning.faces.simpler import simpler
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cone


def side(strays, rng):
    """Of a plate with rounded corners: 100 mm long, 4 mm high, and a few contacts round its corner."""
    flat = np.column_stack([np.zeros(150), rng.uniform(0.0, 100.0, 150), rng.uniform(-2.0, 2.0, 150)])
    turn = rng.uniform(0.2, 0.5, strays)
    corner = np.column_stack(
        [3.0 - 3.0 * np.cos(turn), 101.0 + 3.0 * np.sin(turn), rng.uniform(0.5, 2.0, strays)]
    )
    ways = np.column_stack([-np.cos(turn), np.sin(turn), np.full(strays, 0.3)])
    normals = np.concatenate([np.tile([-1.0, 0.0, 0.0], (150, 1)), ways])
    normals += 0.02 * rng.standard_normal(normals.shape)
    points = np.concatenate([flat, corner]) + 0.03 * rng.standard_normal((150 + strays, 1)) * [1.0, 0.0, 0.0]
    return Contacts.of(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), 0.05, 0.03)


def test_a_side_that_a_few_contacts_of_its_corner_bend_into_a_cone_is_flat():
    contacts = side(8, np.random.default_rng(2))
    bent = fit("cone", contacts)
    assert bent
    (face,) = simpler(PatchGraph((Face(0, bent, contacts),))).faces
    assert face.fit.kind == "plane"
    assert abs(face.fit.shape.direction[0]) > 0.9999
    assert face.fit.inliers[:150].mean() > 0.95


def test_a_cone_stays_one():
    rng, cone = np.random.default_rng(3), Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.6)
    turn, up = rng.uniform(0.0, 2.0, 80), rng.uniform(20.0, 40.0, 80)
    points = cone.project(np.column_stack([0.7 * up * np.cos(turn), 0.7 * up * np.sin(turn), up]))
    contacts = Contacts.of(points, cone.normals(points), 0.03, 0.03)
    face = Face(0, fit("cone", contacts), contacts)
    assert simpler(PatchGraph((face,))).faces[0] is face

"""Rounded ends of bars, from what a pad felt of them on its way over."""

import numpy as np
import pytest

from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.rounded_ends import rounded_ends

UP = np.array([0.0, 0.0, 1.0])
TURNS = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
RADIUS, ROUND, HIGH = 30.0, 8.0, 20.0


def ways(turns):
    return np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])


def bar():
    """Its end and its wall, as far as they go."""
    disc = np.array([[x, y, HIGH] for x in range(-18, 19, 6) for y in range(-18, 19, 6)], dtype=float)
    end = ranked_face(0, Contacts.of(disc, np.tile(UP, (len(disc), 1)), 0.02), MergeOptions())
    out = np.tile(ways(TURNS), (5, 1))
    wall = RADIUS * out + np.linspace(-25.0, HIGH - ROUND, 5).repeat(12)[:, None] * UP
    return [end, ranked_face(1, Contacts.of(wall, out, 0.02), MergeOptions())]


def rounding(lean, turns):
    """(n, 3) places of the rounding, and (n, 3) normals."""
    lean, turns = (lot.ravel() for lot in np.meshgrid(lean, turns))
    normals = np.sin(lean)[:, None] * ways(turns) + np.cos(lean)[:, None] * UP
    return (RADIUS - ROUND) * ways(turns) + (HIGH - ROUND) * UP + ROUND * normals, normals


def face_of(kind, points, normals):
    lot = Contacts.of(points, normals, 0.02)
    return Face(2, fit(kind, lot), lot)


def rings(graph):
    return [face for face in graph.faces if face.fit and face.fit.kind == "torus"]


def test_a_piece_that_passed_for_a_cylinder_across_the_axis_is_of_a_ring_about_it():
    side = rounding(np.deg2rad([20.0, 40.0, 60.0]), np.linspace(-0.3, 0.3, 5))
    graph = PatchGraph((*bar(), face_of("cylinder", *side)))
    (ring,) = rings(rounded_ends(graph))
    assert ring.fit.shape.minor_radius == pytest.approx(ROUND, abs=0.05)
    assert ring.fit.shape.radius == pytest.approx(RADIUS - ROUND, abs=0.05)
    assert (ring.contacts.touch != NOT_FELT).sum() == 15
    assert all(face.id != 2 for face in rounded_ends(graph).faces)


def test_a_cone_and_a_ring_that_is_known_stay():
    lean = np.deg2rad(45.0)
    bevel = np.concatenate([ways(TURNS) * (RADIUS - s) + (HIGH - 6.0 + s) * UP for s in (0.5, 3.0, 5.5)])
    normals = np.tile(np.sin(lean) * ways(TURNS) + np.cos(lean) * UP, (3, 1))
    cone = PatchGraph((*bar(), face_of("cone", bevel, normals)))
    assert rounded_ends(cone) is cone
    whole = PatchGraph((*bar(), face_of("torus", *rounding(np.deg2rad([15.0, 45.0, 75.0]), TURNS))))
    assert rounded_ends(whole) is whole

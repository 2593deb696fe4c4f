"""Holes whose floors lean against their mouths."""

import numpy as np
import pytest

from exploration.planning.inferring.slanting import slanting
from exploration.planning.open.holes import Hole
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.pose import frame_along

Z = np.eye(3)[2]
STRAIGHT = Hole(np.array([0.0, 0.0, -15.0]), Z, 9.0, 30.0, 0.02)  # from its mouth at the origin


def floor(lean, deep=28.0, touch=0, wide=5.0, aside=0.0):
    """Felt across the way of a hole that comes out at the origin and leans by so many radians."""
    way = np.array([np.sin(lean), 0.0, np.cos(lean)])
    turn = frame_along(way)
    at = np.random.default_rng(2).uniform(-wide, wide, (20, 2)) + np.array([aside, 0.0])
    points = at @ turn[:, :2].T - deep * way
    return ranked_face(3, Contacts.of(points, np.tile(way, (20, 1)), touch=touch), MergeOptions()), way


@pytest.mark.parametrize("lean", [0.15, 0.3, 0.5])
def test_a_hole_runs_along_the_normal_of_the_floor_that_was_felt_in_it(lean):
    face, way = floor(lean)
    hole = slanting(STRAIGHT, [face])
    assert np.allclose(hole.axis, way, atol=1e-3)
    assert hole.depth == pytest.approx(28.0, abs=0.1)
    assert np.allclose(hole.middle + 0.5 * hole.depth * hole.axis, 0.0, atol=1e-6)
    assert hole.radius == STRAIGHT.radius


def test_it_stays_upright_where_no_floor_says_otherwise():
    upright, beside, shallow, heard = (
        floor(0.0)[0],
        floor(0.3, aside=8.0)[0],
        floor(0.3, deep=10.0)[0],
        floor(0.3, touch=NOT_FELT)[0],
    )
    for face in (upright, beside, shallow, heard):
        assert slanting(STRAIGHT, [face]) is STRAIGHT

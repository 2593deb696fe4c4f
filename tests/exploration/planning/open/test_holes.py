"""Holes that slant into one of the two faces that they come out of."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.open.holes import holes_of
from exploration.planning.open.round_rims import RoundRim

Z = np.eye(3)[2]
NOWHERE = np.empty((0, 3))


def ends(lean, radius=5.0):
    """A hole along z from a flat face up to one that leans by so much [rad], whose rim passes for a circle."""
    below = RoundRim(np.array([3.0, 2.0, 0.0]), -Z, radius, 0.02, 0, True)
    axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
    above = RoundRim(np.array([3.2, 2.0, 30.0]), axis, radius * (0.5 + 0.5 / np.cos(lean)), 0.02, 1, True)
    return below, above


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("lean", [0.25, 0.5, 0.8])
def test_the_narrower_of_two_rims_tells_how_a_slanting_hole_runs(lean, order):
    (hole,), left = holes_of(ends(lean)[::order], NOWHERE)
    assert not left
    assert np.allclose(hole.axis, -Z)
    assert hole.radius == 5.0
    assert abs(hole.depth - 30.0) < 0.1


def mouth(angle, height, up=0.0, radius=5.0):
    """A hole's mouth in the side of a round body, that looks up a little."""
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    axis = np.cos(up) * way + np.sin(up) * Z
    return RoundRim(20.0 * way + height * Z, axis, radius, 0.3, 0, True, bent=True)


def test_two_mouths_in_a_cones_side_are_one_hole_and_those_of_three_screws_are_none():
    (hole,), left = holes_of([mouth(0.0, 7.0, 0.25), mouth(np.pi, 7.0, 0.25, 5.3)], NOWHERE)
    assert not left
    assert abs(hole.axis @ Z) < 1e-9
    assert abs(hole.depth - 40.0) < 1e-9
    assert np.allclose(hole.middle, 7.0 * Z)
    three = [mouth(angle, 7.0) for angle in (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0)]
    assert holes_of(three, NOWHERE) == ([], three)
    assert holes_of([mouth(0.0, 7.0), mouth(np.pi, 7.0, radius=7.0)], NOWHERE)[0] == []


def test_two_rims_that_lean_are_no_hole_where_they_do_not_meet_or_the_other_is_too_wide():
    below, above = ends(0.5)
    beside = replace(above, center=above.center + np.array([4.0, 0.0, 0.0]))
    wide = replace(above, radius=7.0)
    narrow = replace(above, radius=4.0)
    for other in (beside, wide, narrow, replace(above, measured=False)):
        holes, left = holes_of([below, other], NOWHERE)
        assert not holes
        assert [rim.face for rim in left] == [0, 1]

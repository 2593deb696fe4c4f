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


def test_two_rims_that_lean_are_no_hole_where_they_do_not_meet_or_the_other_is_too_wide():
    below, above = ends(0.5)
    beside = replace(above, center=above.center + np.array([4.0, 0.0, 0.0]))
    wide = replace(above, radius=7.0)
    narrow = replace(above, radius=4.0)
    for other in (beside, wide, narrow, replace(above, measured=False)):
        holes, left = holes_of([below, other], NOWHERE)
        assert not holes
        assert [rim.face for rim in left] == [0, 1]

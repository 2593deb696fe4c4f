"""Floors of round holes that no array came to, where the object was felt closed behind them."""

import numpy as np
import pytest

from exploration.planning.inferring.blind_holes import floor_of
from exploration.planning.open.holes import Hole
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]
HOLE = Hole(-20.0 * Z, Z, 8.0, 40.0, 0.1)  # from z = 0 down to z = -40


def flat(height, up, inside, half=20.0):
    """A face of a grid of contacts 2 mm apart, where `inside` of (n, 2) places says so."""
    grid = np.stack(np.meshgrid(*[np.arange(-half, half + 1.0, 2.0)] * 2), axis=-1).reshape(-1, 2)
    grid = grid[inside(grid)]
    points = np.column_stack([grid, np.full(len(grid), height)])
    return ranked_face(0, Contacts.of(points, np.tile(up * Z, (len(points), 1))), MergeOptions())


def everywhere(places):
    return np.ones(len(places), dtype=bool)


def test_a_hole_that_was_felt_closed_behind_has_a_floor_where_an_array_got_to():
    floor = floor_of(HOLE, [flat(-46.0, -1.0, everywhere)])
    assert floor is not None
    assert (floor.touch == NOT_FELT).all()
    assert floor.points[:, 2] == pytest.approx(-40.0)
    assert np.hypot(*floor.points[:, :2].T).max() < HOLE.radius
    assert (floor.normals == Z).all()


@pytest.mark.parametrize(
    "behind",
    [
        [flat(-46.0, -1.0, lambda at: np.hypot(*at.T) > 9.0)],  # only round it: it may come out there
        [flat(-46.0, -1.0, lambda at: at[:, 0] > 3.0)],  # a pad that hung over its rim on one side
        [flat(-46.0, 1.0, everywhere)],  # looks up at it: another part of the object, farther down
        [flat(-20.0, -1.0, everywhere)],  # an array was behind it
        [
            flat(-46.0, -1.0, everywhere),
            flat(-41.0, 1.0, lambda at: np.hypot(*at.T) < 7.0),
        ],  # a floor was felt
        [],
    ],
)
def test_but_none_where_it_may_go_through_or_its_floor_is_known(behind):
    assert floor_of(HOLE, behind) is None

"""Where an object was not looked at yet, and where nothing is left to look at."""

import numpy as np

from exploration.planning.known.swept_cells import SweptCells
from exploration.planning.open.views import best_view
from primitives import pose as se3

BOX = np.array([-100.0, -100.0, -100.0, 100.0, 100.0, 100.0])
LOW, HIGH = np.array([-15.0, -10.0, -40.0]), np.array([15.0, 10.0, 0.0])
STEPS = np.linspace(-30.0, 30.0, 31)


def sheet(z, facing):
    """A flat face at a height, and which way it looks."""
    places = np.array([[x, y, z] for x in STEPS for y in STEPS])
    return places, np.tile([0.0, 0.0, facing], (len(places), 1))


def test_cells_are_swept_where_the_housing_was_and_not_before_the_skin():
    swept = SweptCells(BOX)
    for x in np.arange(-30.0, 31.0, 2.0):
        swept.pass_through(se3.pose(np.diag([1.0, -1.0, -1.0]), [x, 0.0, 10.0]), LOW, HIGH)
    assert swept.holds(np.array([[0.0, 0.0, 16.0], [25.0, 4.0, 40.0]])).all()
    assert not swept.holds(np.array([[0.0, 0.0, 8.0], [0.0, 20.0, 16.0], [0.0, 0.0, 500.0]])).any()
    assert swept.holds_box(se3.pose(translation=[0.0, 0.0, 40.0]), LOW / 2, HIGH)
    assert not swept.holds_box(se3.pose(translation=[0.0, 10.0, 40.0]), LOW / 2, HIGH)


def test_a_plate_felt_on_one_side_is_looked_at_from_behind_until_that_was_swept():
    swept, half = SweptCells(BOX), np.array([15.0, 10.0])
    places, facing = sheet(0.0, 1.0)
    cells = swept.unseen_between(BOX[:3], BOX[3:])
    swept.set_aside(cells[(cells[:, 2] > 0.0) | (np.abs(cells[:, :2]).max(axis=1) > 32.0)])
    seen = 0
    while (view := best_view(places, facing, swept, half, np.eye(3))) is not None:
        assert view.target[2, 2] > 0.6  # upward
        assert (view.unseen[:, 2] < 0.0).all()
        swept.set_aside(view.unseen)
        seen += 1
    assert 1 < seen < 40
    behind, back = sheet(-0.5, -1.0)
    whole = np.concatenate([places, behind]), np.concatenate([facing, back])
    assert best_view(*whole, swept, half, np.eye(3)) is None


def test_what_is_not_worth_a_look_is_not_taken_for_empty():
    swept = SweptCells(BOX)
    cells = swept.unseen_between(BOX[:3], BOX[3:])
    swept.set_aside(cells)
    assert not len(swept.unseen_between(BOX[:3], BOX[3:]))
    assert not len(swept.between(BOX[:3], BOX[3:]))
    assert not swept.holds(cells).any()


def test_the_end_of_a_post_is_looked_at_though_the_plate_round_it_was_felt_from_that_side():
    swept, half = SweptCells(BOX), np.array([15.0, 10.0])
    places, facing = sheet(0.0, 1.0)
    turns = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    out = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(12)])
    flank = np.concatenate([8.0 * out + [0.0, 0.0, z] for z in np.arange(4.0, 30.0, 4.0)])
    whole = np.concatenate([places, flank]), np.concatenate([facing, np.tile(out, (7, 1))])
    cells = swept.unseen_between(BOX[:3], BOX[3:])
    beside = np.hypot(cells[:, 0], cells[:, 1]) > 12.0
    swept.set_aside(cells[(cells[:, 2] < -1.0) | beside & (cells[:, 2] > 0.0) | (cells[:, 2] > 38.0)])
    view = best_view(*whole, swept, half, np.eye(3))
    assert view is not None
    np.testing.assert_allclose(view.target[:3, 2], [0.0, 0.0, -1.0], atol=1e-9)
    assert np.hypot(*view.target[:2, 3]) < 15.0
    top = np.array([[x, y, 28.0] for x in (-6.0, -2.0, 2.0, 6.0) for y in (-4.0, 0.0, 4.0)])
    felt = np.concatenate([whole[0], top]), np.concatenate([whole[1], np.tile([0.0, 0.0, 1.0], (12, 1))])
    assert best_view(*felt, swept, half, np.eye(3)) is None


def test_nothing_is_looked_at_through_the_table_that_it_stands_on():
    swept, half = SweptCells(BOX), np.array([15.0, 10.0])
    places, facing = sheet(20.0, 1.0)
    cells = swept.unseen_between(BOX[:3], BOX[3:])
    swept.set_aside(cells[(cells[:, 2] > 16.0) | (np.abs(cells[:, :2]).max(axis=1) > 32.0)])
    table = np.array([[x, y, 0.0] for x in np.arange(-80.0, 81.0, 4.0) for y in np.arange(-80.0, 81.0, 4.0)])
    free, beside = (best_view(places, facing, swept, half, np.eye(3), other) for other in (None, table))
    assert free is not None
    assert free.target[2, 2] > 0.9  # from right under it
    assert beside is None or beside.target[2, 2] < 0.1
    if beside is not None:
        assert (beside.unseen[:, 2] > 0.0).all()

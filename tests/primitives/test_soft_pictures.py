"""Slopes of soft pictures, against what pictures of moved corners show."""

import numpy as np
import pytest

from primitives.soft_pictures import drawn, following, normal_equations, slopes, softened, within

STEP, SHAPE, SOFT = 0.5, (70, 80), 1.1
BENT = np.array([[8.0, 9.0], [26.0, 7.0], [27.0, 20.0], [18.0, 21.0], [17.0, 31.0], [7.0, 29.0]])
HOLE = np.array([[11.0, 13.0], [11.0, 18.0], [15.0, 17.5]])
RIMS = [BENT, HOLE]


def samples(rims, per_edge=60):
    """Places on edges, ways out, shares and ends, as `slopes` wants them."""
    start, after = np.concatenate(rims), following(rims)
    edge = np.repeat(np.arange(len(start)), per_edge)
    along = np.tile((np.arange(per_edge) + 0.5) / per_edge, len(start))
    line = (start[after] - start)[edge]
    out = np.column_stack([line[:, 1], -line[:, 0]]) / per_edge
    return start[edge] + along[:, None] * line, out, along, np.column_stack([edge, after[edge]])


def picture(corners):
    rims = [corners[: len(BENT)], corners[len(BENT) :]]
    return softened(drawn(rims, SHAPE, STEP, 16), SOFT, STEP)


@pytest.mark.parametrize("corner", range(9))
@pytest.mark.parametrize("axis", [0, 1])
def test_slopes_are_what_a_small_move_of_a_corner_changes(corner, axis):
    numbers, trust = np.arange(np.prod(SHAPE)).reshape(SHAPE), np.ones(SHAPE)
    slope = slopes(*samples(RIMS), 9, numbers, trust, SOFT, STEP)[:, 9 * axis + corner].reshape(SHAPE)
    corners, move = np.concatenate(RIMS), np.zeros((9, 2))
    move[corner, axis] = 0.1
    change = (picture(corners + move) - picture(corners - move)) / 0.2
    assert np.abs(slope - change).max() < 0.1 * np.abs(change).max()  # a cell shows a mean, not its middle
    assert (slope * change).sum() == pytest.approx((change**2).sum(), rel=0.05)


def test_cells_that_do_not_count_are_left_out_and_trust_weighs_the_others():
    numbers = np.full(SHAPE, -1)
    numbers[20:30, 10:40] = np.arange(300).reshape(10, 30)
    trust = np.random.default_rng(1).uniform(0.2, 1.0, SHAPE)
    whole = slopes(*samples(RIMS), 9, np.arange(np.prod(SHAPE)).reshape(SHAPE), np.ones(SHAPE), SOFT, STEP)
    some = slopes(*samples(RIMS), 9, numbers, trust, SOFT, STEP)
    expected = (whole.reshape(*SHAPE, 18) * trust[:, :, None])[20:30, 10:40].reshape(300, 18)
    np.testing.assert_allclose(some, expected, atol=1e-12)


def test_normal_equations_are_those_of_dense_matrices():
    rng = np.random.default_rng(2)
    slope = rng.standard_normal((200, 12)) * (rng.random((200, 12)) < 0.3)
    off = rng.standard_normal(200)
    squares, sides = normal_equations(slope, off)
    np.testing.assert_allclose(squares, slope.T @ slope, atol=1e-12)
    np.testing.assert_allclose(sides, slope.T @ off, atol=1e-12)


def test_cells_within_reach_are_those_whose_middles_are():
    places = np.random.default_rng(3).uniform(-3.0, 40.0, (12, 2))
    i, j = np.meshgrid(*map(np.arange, SHAPE), indexing="ij")
    middles = STEP * np.stack([i, j], axis=-1)
    away = np.linalg.norm(middles[:, :, None] - places, axis=-1).min(axis=-1)
    np.testing.assert_array_equal(within(places, 2.3, SHAPE, STEP), away <= 2.3)


def test_no_rims_make_an_empty_picture():
    assert not drawn([], SHAPE, STEP).any()

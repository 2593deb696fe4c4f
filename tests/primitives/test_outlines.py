"""Outlines in a plane: traced round masks, simplified, and how far inside them places lie."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from primitives.outlines import depth_inside, simplified, traced

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
HOLE = SQUARE[::-1] * 0.4 + 3.0
AT = st.floats(-5.0, 15.0)


@given(AT, AT)
def test_depth_in_a_square_with_a_hole_is_that_to_the_nearest_side_and_negative_in_the_hole(x, y):
    to_square = np.abs(np.array([x, y]) - 5.0) - 5.0
    to_hole = np.abs(np.array([x, y]) - 5.0) - 2.0

    def box(d):
        return float(np.linalg.norm(np.maximum(d, 0.0)) + min(d.max(), 0.0))

    wanted = -max(box(to_square), -box(to_hole))
    (depth,) = depth_inside([SQUARE, HOLE], np.array([[x, y]]))
    assert abs(depth - wanted) < 1e-9 or abs(abs(depth) - abs(wanted)) < 1e-9 > min(abs(depth), 1.0)


def test_without_rims_all_lies_outside():
    assert (depth_inside([], np.zeros((3, 2))) == -np.inf).all()


def test_a_round_mask_is_traced_and_simplified_to_its_circle():
    x, y = np.meshgrid(np.arange(60), np.arange(60))
    (rim,) = traced(np.hypot(x - 30, y - 30) < 20.0)
    corners = simplified(rim, 0.7)[:-1]
    assert len(corners) < 0.5 * len(rim)
    away = np.linalg.norm(corners - 30.5, axis=1)
    assert np.abs(away - 20.0).max() < 1.0

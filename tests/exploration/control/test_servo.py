import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from exploration.control.servo import ServoGains, hybrid_twist

GAINS = ServoGains()
small = st.floats(-0.5, 0.5)
place = st.floats(-10.0, 10.0)


def test_no_error_means_no_motion():
    twist = hybrid_twist(GAINS.press, np.zeros(2), np.zeros(2), np.zeros(2))
    np.testing.assert_allclose(twist, 0.0)


@given(small, small, place, place)
def test_tilting_lowers_the_slope_and_leaves_the_pivot_at_rest(gx, gy, cx, cy):
    slope, pivot = np.array([gx, gy]), np.array([cx, cy])
    vx, vy, vz, wx, wy, _ = hybrid_twist(GAINS.press, slope, pivot, np.zeros(2))
    change = np.array([-wy, wx])  # of the slope, by turning the pad
    assert change @ slope <= 0.0
    assert abs(vz + wx * cy - wy * cx) < 1e-9
    assert (vx, vy) == (0.0, 0.0)


@given(st.floats(-3.0, 3.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_commands_stay_within_their_bounds(depth, gx, gy):
    twist = hybrid_twist(depth, np.array([gx, gy]), np.zeros(2), np.zeros(2))
    assert abs(twist[2]) <= GAINS.press_speed + 1e-9
    assert np.hypot(twist[3], twist[4]) <= GAINS.tilt_speed + 1e-9


def test_too_shallow_a_press_moves_the_pad_forward():
    assert hybrid_twist(0.0, np.zeros(2), np.zeros(2), np.zeros(2))[2] > 0.0

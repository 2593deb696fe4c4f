"""What a trace is: made from samples of known curves."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from primitives.arrays import frozen
from primitives.evidence import EdgeTrace
from primitives.pose import random_rotation
from recognition.tracking.traced import (
    angles_between,
    circle_through,
    comes_round,
    corners_of,
    described,
    from_corner_to_corner,
    loop_gap,
    whole_edges,
)

UP = np.array([0.0, 0.0, 1.0])


def trace_of(points, closed=False, normal=UP):
    points = np.asarray(points, dtype=float)
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normals = np.tile(normal, (len(points), 1))
    return EdgeTrace(
        frozen(points), frozen(along), frozen(normals), frozen(np.full(len(points), 0.02)), closed, 0, 0
    )


def straight(a, b, count=30):
    return trace_of(np.linspace(a, b, count))


def arc(radius, begin, end, count=200, **more):
    t = np.linspace(begin, end, count)
    return trace_of(radius * np.column_stack([np.cos(t), np.sin(t), 0 * t]), **more)


@given(st.floats(5.0, 80.0), st.floats(0.5, 6.0), st.integers(0, 2**31))
def test_a_circle_through_its_own_samples_is_that_circle(radius, angle, seed):
    rng = np.random.default_rng(seed)
    turn, center = random_rotation(rng), rng.uniform(-100, 100, 3)
    t = np.linspace(0.0, angle, 60)
    points = radius * np.column_stack([np.cos(t), np.sin(t), 0 * t]) @ turn.T + center
    found, r, axis, rms = circle_through(points, turn[:, 2])
    assert r == pytest.approx(radius, rel=1e-5)
    assert np.allclose(found, center, atol=1e-3)
    assert axis @ turn[:, 2] == pytest.approx(1.0, abs=1e-6)
    assert rms < 1e-4


def test_a_straight_trace_is_a_line_whatever_its_noise_and_an_arc_a_circle():
    rng = np.random.default_rng(0)
    line = straight([0, 0, 0], [40, 0, 0])
    noisy = trace_of(line.points + rng.normal(0, 0.02, line.points.shape))
    assert described(noisy).curve == "line"
    assert described(noisy).length == pytest.approx(40.0, abs=0.2)
    bent = described(arc(25.0, 0.0, 1.0))
    assert bent.curve == "circle"
    assert bent.radius == pytest.approx(25.0)


def test_a_closed_circle_is_as_long_as_it_is_round_though_its_start_was_passed():
    ring = described(arc(20.0, 0.0, 2 * np.pi + 0.2, closed=True))
    assert ring.length == pytest.approx(40.0 * np.pi, rel=1e-4)


def test_a_short_straight_trace_that_calls_itself_closed_is_neither_round_nor_a_loop():
    rng = np.random.default_rng(0)
    points = np.linspace([0, 0, 0], [9, 0, 0], 12)
    starved = trace_of(points + rng.normal(0, 0.01, points.shape), closed=True)
    found = described(starved)
    assert (found.curve, found.radius) == ("line", None)
    assert not comes_round([starved])
    assert comes_round([arc(20.0, 0.0, 2 * np.pi + 0.2, closed=True)])
    corners = np.array([[0, 0, 0], [30, 0, 0], [15, 26, 0], [0, 0, 0]])
    assert comes_round([straight(a, b) for a, b in pairwise(corners)])


def test_an_ellipse_is_neither_line_nor_circle():
    t = np.linspace(0, 2 * np.pi, 200)
    assert described(trace_of(np.column_stack([30 * np.cos(t), 20 * np.sin(t), 0 * t]))).curve == "other"


@pytest.mark.parametrize("aside", [0.0, 0.05, 0.4])
def test_the_gap_of_a_loop_is_what_its_end_lies_beside_its_start(aside):
    t = np.linspace(0, 2 * np.pi + 0.1, 400)
    r = 30.0 + aside * (t / (2 * np.pi))
    assert loop_gap([trace_of(np.column_stack([r * np.cos(t), r * np.sin(t), 0 * t]))]) == pytest.approx(
        aside, abs=0.01
    )


def test_a_square_begun_in_the_middle_of_a_side_has_four_edges_and_four_corners():
    c = np.array([[20, 20, 0], [-20, 20, 0], [-20, -20, 0], [20, -20, 0]], dtype=float)
    middle = np.array([20.0, 0, 0])
    inset = 0.1  # traces end short of the corners
    ends = [(middle, c[0]), (c[0], c[1]), (c[1], c[2]), (c[2], c[3]), (c[3], np.array([20.0, 3.0, 0]))]
    traces = [straight(a + inset * (b - a), b - inset * (b - a)) for a, b in ends]
    whole = whole_edges(traces, [None, 1.0, 1.0, 1.0, 1.5], True)
    assert len(whole) == 4
    assert whole[0][1] == 1.5  # the first part was not measured, the last was
    found = corners_of([trace for trace, _ in whole], True)
    assert np.allclose(found, c, atol=1e-9)


def test_an_open_outline_keeps_its_edges_apart():
    traces = [straight([0, 0, 0], [20, 0, 0]), straight([20, 0, 0], [20, 20, 0])]
    assert len(whole_edges(traces, [None, None], False)) == 2
    assert np.allclose(corners_of(traces, False), [[20, 0, 0]])


@pytest.mark.parametrize("closed", [False, True])
def test_an_edge_is_as_long_as_its_corners_lie_apart_whether_or_not_the_outline_closed(closed):
    c = np.array([[0, 0, 0], [60, 0, 0], [60, 90, 0], [0, 90, 0], [0, 0, 0]], dtype=float)
    ways = [(b - a) / np.linalg.norm(b - a) for a, b in pairwise(c)]
    traces = [straight(a + 4.0 * way, b - 4.0 * way) for (a, b), way in zip(pairwise(c), ways, strict=True)]
    edges = [described(trace) for trace in traces]
    told = from_corner_to_corner(edges, corners_of(traces, closed), angles_between(traces, closed))
    ends = (60.0, 90.0) if closed else (52.0, 82.0)
    assert np.allclose([edge.length for edge in told], [ends[0], 90.0, 60.0, ends[1]])

"""Traces are split where they turn sharply, and nowhere else."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from exploration.control.track_outline import TrackedOutline
from primitives.arrays import frozen
from primitives.evidence import EdgeTrace
from recognition.tracking.edge import TrackEdgeConfig, _hangs_together
from recognition.tracking.sharp_turns import split, split_at_corners
from recognition.tracking.traced import (
    angles_between,
    corners_of,
    described,
    from_corner_to_corner,
    whole_edges,
)

FINE = 0.05  # [mm] between the points of a curve before it is smoothed
BLUR = 0.8  # [mm] standard deviation, that rounds its corners


def traced(curve, closed=False):
    """A trace with a point every mm along a curve (n, 2), rounded as the skin rounds it, and noisy."""
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    travel = np.append(0.0, np.cumsum(steps))
    fine = np.arange(0.0, travel[-1], FINE)
    flat = np.stack([np.interp(fine, travel, column) for column in curve.T], axis=1)
    flat = gaussian_filter1d(flat, BLUR / FINE, axis=0, mode="nearest")[:: round(1.0 / FINE)]
    flat = flat + 0.01 * np.random.default_rng(0).standard_normal(flat.shape)
    points = np.column_stack([flat, np.zeros(len(flat))])
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up, sigma = np.tile([0.0, 0.0, 1.0], (len(points), 1)), np.full(len(points), 0.02)
    return EdgeTrace(frozen(points), frozen(along), frozen(up), frozen(sigma), closed, 0, 0)


def star(tip=30.0, hollow=16.0):
    """(10, 2) corners of a star with five tips, one of them first."""
    t, r = np.arange(10) * np.pi / 5.0, np.tile([tip, hollow], 5)
    return np.column_stack([r * np.cos(t), r * np.sin(t)])


def short_of_its_tips(by):
    """From tip to tip of a star, past the corner between them: each trace ends `by` mm short of the tips."""
    corners, traces = star(), []
    for k in range(0, 10, 2):
        a, b, c = corners[k], corners[k + 1], corners[(k + 2) % 10]
        ends = [p + by * (b - p) / np.linalg.norm(b - p) for p in (a, c)]
        traces.append(traced(np.array([ends[0], b, ends[1]])))
    return tuple(traces)


def outlined(traces):
    return TrackedOutline(traces, np.empty((0, 3)), "closed", 1.0, (1.0,), (1.0,), (None,) * len(traces))


def test_a_star_that_was_followed_from_tip_to_tip_has_ten_straight_edges():
    traces = split_at_corners(outlined(short_of_its_tips(6.6))).traces
    edges, corners = [described(trace) for trace in traces], corners_of(traces, True)
    told = from_corner_to_corner(edges, corners, angles_between(traces, True))
    assert [edge.curve for edge in told] == ["line"] * 10
    side = np.linalg.norm(star()[1] - star()[0])
    assert np.allclose([edge.length for edge in told], side, atol=0.2)
    apart = np.linalg.norm(corners[:, None, :2] - star(), axis=2)
    assert np.all(apart.min(axis=0) < 0.15)


@pytest.mark.parametrize("turn", [0.5, 0.9, 1.57])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_corner_is_where_the_edges_that_it_parts_meet(turn, side):
    ends = 15.0 * np.array([[-1.0, 0.0], [0.0, 0.0], [np.cos(turn), side * np.sin(turn)]])
    pieces = split(traced(ends))
    assert [described(piece).curve for piece in pieces] == ["line", "line"]
    assert np.allclose(corners_of(pieces, False), 0.0, atol=0.1)


@pytest.mark.parametrize("radius", [7.0, 12.0, 25.0, 60.0])
@pytest.mark.parametrize("turn", [0.9, 1.57, 3.0])
def test_a_round_bend_between_straight_edges_is_no_corner(radius, turn):
    t = np.linspace(0.0, turn, 200)
    arc = radius * np.column_stack([np.sin(t), 1.0 - np.cos(t)])
    curve = np.concatenate([[[-15.0, 0.0]], arc, [arc[-1] + 15.0 * np.array([np.cos(turn), np.sin(turn)])]])
    trace = traced(curve)
    assert split(trace) == [trace]


def test_a_square_that_was_followed_round_in_one_has_four_edges():
    square = np.array([[20, 0], [20, 20], [-20, 20], [-20, -20], [20, -20], [20, 4]], dtype=float)
    pieces = split(traced(square, closed=True))
    whole = whole_edges(pieces, [None] * len(pieces), True)
    assert len(whole) == 4
    assert not any(trace.closed for trace, _ in whole)


@pytest.mark.parametrize(("by", "jumped", "well"), [(4.0, 0, True), (6.6, 5, True), (12.0, 5, False)])
def test_tips_that_were_jumped_are_told_and_too_many_are_no_loop(by, jumped, well):
    run, corners = SimpleNamespace(warnings=[]), star()
    sides = [
        (a + by * (b - a) / np.linalg.norm(b - a), b)
        if k % 2 == 0
        else (a, b + by * (a - b) / np.linalg.norm(b - a))
        for k, (a, b) in enumerate(pairwise([*corners, corners[0]]))
    ]
    traces = [traced(np.array(side)) for side in sides]
    assert _hangs_together(run, traces, TrackEdgeConfig()) == well
    assert [warning.split()[0] for warning in run.warnings] == [str(jumped)] * (jumped > 0)

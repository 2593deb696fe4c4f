"""Counterbores and countersinks of which the two rims are known, and perhaps what stopped an array in them."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.stepped_holes import (
    BY_FLAT_HEAD,
    BY_GUESS,
    BY_SCREW,
    BY_SLOPE,
    BY_TOUCH,
    stepped_holes,
)
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Stopped
from primitives.evidence import NOT_FELT
from primitives.fit import Fit, fit

UP = np.array([0.0, 0.0, 1.0])
TOP = RoundRim(np.array([3.0, 1.0, 12.0]), UP, 15.0, 0.02, 0, measured=True)
BOTTOM = RoundRim(np.array([3.1, 1.0, 0.0]), -UP, 9.0, 0.02, 1, measured=True)


def test_a_hole_that_is_wider_on_top_has_a_ledge_half_way_down():
    (step,) = stepped_holes([BOTTOM, TOP])
    wide, narrow = step.holes
    assert step.rims == (TOP, BOTTOM)
    assert wide.radius == 15.0
    assert wide.holds(np.array([[16.0, 1.0, 7.0]])).all()
    assert not wide.holds(np.array([[16.0, 1.0, 4.0]])).any()
    assert (narrow.radius, narrow.depth) == (9.0, 6.0)
    ledge = step.contacts
    assert np.allclose(ledge.points[:, 2], 6.0)
    assert np.allclose(ledge.normals, UP)
    assert (ledge.touch == NOT_FELT).all()
    away = np.hypot(ledge.points[:, 0] - 3.0, ledge.points[:, 1] - 1.0)
    assert 9.0 < away.min() <= away.max() < 15.0
    assert step.why == BY_GUESS
    close = stepped_holes([replace(BOTTOM, radius=12.0), TOP])[0]  # no screw's
    assert (close.holes[0].depth, close.why) == (6.0, BY_GUESS)


@pytest.mark.parametrize(("shank", "head", "deep"), [(2.75, 5.0, 5.4), (3.3, 5.5, 6.4), (5.5, 9.0, 10.6)])
def test_one_that_is_as_wide_as_for_a_screw_s_head_is_as_deep(shank, head, deep):
    below = replace(BOTTOM, radius=shank, center=TOP.center - 30.0 * UP)
    (step,) = stepped_holes([below, replace(TOP, radius=head)])
    assert step.holes[0].depth == pytest.approx(deep, rel=0.02)
    assert step.why == BY_SCREW
    thin = stepped_holes([replace(below, center=TOP.center - 8.0 * UP), replace(TOP, radius=head)])[0]
    flat = head > 1.75 * shank  # and no room for a head that is as high as the screw is thick
    assert thin.why == (BY_FLAT_HEAD if flat else BY_GUESS)


@pytest.mark.parametrize(("shank", "head"), [(1.7, 3.4), (2.25, 4.7), (3.3, 6.5), (4.5, 9.2)])
def test_one_that_is_as_wide_as_for_a_flat_head_is_a_cone_of_90_degrees(shank, head):
    below = replace(BOTTOM, radius=shank, center=TOP.center - 30.0 * UP)
    (step,) = stepped_holes([below, replace(TOP, radius=head)])
    (narrow,) = step.holes
    assert narrow.depth == pytest.approx(30.0 - (head - shank))
    assert (step.kind, step.why) == ("cone", BY_FLAT_HEAD)
    assert fit("cone", step.contacts).shape.semi_angle == pytest.approx(np.pi / 4, abs=0.02)
    felt = [Stopped(TOP.center, 0.8 * head, 5.0)]
    assert stepped_holes([below, replace(TOP, radius=head)], stopped=felt)[0].why == BY_TOUCH
    thin = replace(below, center=TOP.center - 1.5 * UP)  # no room for a cone
    assert stepped_holes([thin, replace(TOP, radius=head)])[0].why == BY_GUESS


@pytest.mark.parametrize(
    ("shank", "head", "why"),
    [(1.7, 3.25, BY_SCREW), (2.0, 5.8, BY_FLAT_HEAD), (4.0, 11.0, BY_GUESS), (3.0, 15.0, BY_GUESS)],
)
def test_wider_mouths_are_of_flat_heads_only_where_no_array_has_room(shank, head, why):
    below = replace(BOTTOM, radius=shank, center=TOP.center - 30.0 * UP)
    assert stepped_holes([below, replace(TOP, radius=head)])[0].why == why


def test_the_ledge_is_where_an_array_was_stopped():
    stopped = [Stopped(TOP.center, 13.0, 3.1), Stopped(TOP.center, 10.6, 2.9)]
    (step,) = stepped_holes([BOTTOM, TOP], stopped=stopped)
    wide, narrow = step.holes
    assert wide.depth == pytest.approx(3.0)
    assert narrow.middle[2] == pytest.approx(4.5)
    assert np.allclose(step.contacts.points[:, 2], 9.0)
    assert (step.kind, step.why) == ("plane", BY_TOUCH)


@pytest.mark.parametrize("slope", [0.6, 1.0, 1.4])
def test_what_is_deeper_nearer_to_the_axis_is_a_cone_from_the_rim(slope):
    stopped = [Stopped(TOP.center, off, slope * (TOP.radius - off)) for off in (13.5, 11.0)]
    (step,) = stepped_holes([BOTTOM, TOP], stopped=stopped)
    (narrow,) = step.holes
    assert narrow.depth == pytest.approx(12.0 - slope * 6.0)
    made = fit(step.kind, step.contacts)
    assert isinstance(made, Fit)
    assert not made.convex
    assert made.shape.semi_angle == pytest.approx(np.arctan(1.0 / slope), abs=0.02)
    assert abs(made.shape.signed_distance(np.array([[18.0, 1.0, 12.0]]))[0]) < 0.05
    assert step.why == BY_SLOPE


def test_what_was_met_behind_the_far_end_or_in_another_hole_tells_nothing():
    stopped = [Stopped(TOP.center, 13.0, 12.5), Stopped(BOTTOM.center, 8.0, 3.0)]
    (step,) = stepped_holes([BOTTOM, TOP], stopped=stopped)
    assert step.why == BY_GUESS


def test_rims_alike_beside_each_other_or_only_guessed_make_no_step():
    assert stepped_holes([TOP, replace(BOTTOM, radius=14.5)]) == []
    assert stepped_holes([TOP, replace(BOTTOM, center=np.array([8.0, 1.0, 0.0]))]) == []
    assert stepped_holes([TOP, replace(BOTTOM, axis=UP)]) == []
    assert stepped_holes([replace(TOP, measured=False), replace(BOTTOM, measured=False)]) == []


def test_a_hole_ends_at_the_first_narrower_rim_and_not_in_a_wall_behind_it():
    behind = replace(BOTTOM, center=np.array([3.0, 1.0, -30.0]), radius=6.0)
    (step,) = stepped_holes([behind, TOP, BOTTOM])
    assert step.rims == (TOP, BOTTOM)

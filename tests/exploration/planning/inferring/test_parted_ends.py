"""Ends of a turned face beside a gap that an array went into."""

import numpy as np
import pytest

from exploration.planning.inferring.parted_ends import parted_ends
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import Face, MergeOptions, ranked_face

Z = np.eye(3)[2]
TURN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
RING = np.column_stack([np.cos(TURN), np.sin(TURN), np.zeros(24)])


def knuckles(*heights):
    """A round bar of radius 8, felt at some heights."""
    points = np.concatenate([8.0 * RING + z * Z for z in heights])
    return ranked_face(0, Contacts.of(points, np.tile(RING, (len(heights), 1)), 0.02, 0.02), MergeOptions())


def bore():
    points = np.concatenate([6.5 * RING + z * Z for z in (3.0, 15.0, 28.0)])
    face = ranked_face(1, Contacts.of(points, -np.tile(RING, (3, 1)), 0.02, 0.02), MergeOptions())
    assert isinstance(face, Face)
    assert not face.fit.convex
    return face


def went(deepest):
    """From one side, in to so far from the axis, between z = 14 and 18; less than 0 is past it."""
    x = np.arange(deepest, 8.0)
    return np.array([[a, b, c] for a in x for b in (-2.0, 0.0, 2.0) for c in (14.0, 16.0, 18.0)])


def test_a_bar_that_an_array_went_through_ends_on_both_sides_of_it():
    low, high = parted_ends([knuckles(2.0, 6.0, 10.0, 22.0, 26.0)], went(-7.0))
    assert low.points[:, 2] == pytest.approx(12.0)
    assert high.points[:, 2] == pytest.approx(20.0)
    assert (low.normals @ Z > 0.99).all()
    assert (high.normals @ Z < -0.99).all()
    assert (low.touch == NOT_FELT).all()
    assert np.hypot(*low.points[:, :2].T).max() < 8.0


def test_a_keyway_a_notch_contacts_at_that_height_and_a_bore_part_nothing():
    bar = knuckles(2.0, 10.0, 22.0)
    assert len(parted_ends([bar], went(-7.0))) == 2
    assert parted_ends([bar], went(5.5)) == []
    assert parted_ends([bar], went(1.0)) == []
    assert parted_ends([knuckles(2.0, 6.0, 10.0, 13.0, 16.0, 19.0, 22.0)], went(-7.0)) == []
    assert parted_ends([bar, bore()], went(-7.0)) == []
    assert parted_ends([bar], np.empty((0, 3))) == []


def test_a_corner_is_not_parted_by_an_array_that_passed_beside_it():
    corner = RING[np.abs(TURN - 0.5 * np.pi) < 0.6]
    points = np.concatenate([8.0 * corner + z * Z for z in (2.0, 6.0, 10.0, 22.0, 26.0)])
    face = ranked_face(0, Contacts.of(points, np.tile(corner, (5, 1)), 0.02, 0.02), MergeOptions())
    assert face.fit.convex
    everywhere = np.array(
        [r * way + z * Z for r in (1.0, 3.0, 6.5) for way in RING for z in (14.0, 16.0, 18.0)]
    )
    beside = everywhere[(everywhere[:, 1] < 2.0)]
    assert len(parted_ends([face], everywhere)) == 2
    assert parted_ends([face], beside) == []


def test_knuckles_on_a_narrow_pin_bore_are_parted_where_an_array_went_beside_the_bore():
    points = np.concatenate([3.0 * RING + z * Z for z in (3.0, 15.0, 28.0)])
    pin = ranked_face(1, Contacts.of(points, -np.tile(RING, (3, 1)), 0.02, 0.02), MergeOptions())
    bar = knuckles(2.0, 10.0, 22.0)
    heights = [lot.points[0, 2] for lot in parted_ends([bar, pin], went(-7.0))]
    assert heights == [pytest.approx(12.0), pytest.approx(20.0)]
    turns = 6.8 * RING
    round_it = np.concatenate([turns + z * Z for z in (14.0, 16.0, 18.0)])
    assert parted_ends([bar, pin], round_it) == []  # a groove round a core that is bored
    within = went(-7.0)
    assert parted_ends([bar, pin], within[np.hypot(*within[:, :2].T) < 4.0]) == []

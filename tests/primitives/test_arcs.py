"""Round pieces of outlines."""

import numpy as np
import pytest

from primitives.arcs import arcs, circle_through, evenly

SQUARE = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 30.0], [0.0, 30.0]])


def arc_of(center, radius, first, last, count=40):
    turn = np.linspace(first, last, count)
    return center + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def test_a_straight_outline_has_no_arcs():
    assert arcs(SQUARE) == []


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_the_arcs_of_a_keyhole_are_its_two_circles(noise):
    rng = np.random.default_rng(3)
    gap = np.arcsin(6.5 / 13.0)
    outline = np.concatenate(
        [
            arc_of([-15.0, 0.0], 13.0, gap, 2.0 * np.pi - gap),
            arc_of([30.0, 0.0], 6.5, -0.5 * np.pi, 0.5 * np.pi),
        ]
    )
    found = arcs(outline + noise * rng.normal(size=outline.shape))
    assert len(found) == 2
    wide, narrow = found
    assert np.abs(wide.center - [-15.0, 0.0]).max() < 0.1 + noise
    assert abs(wide.radius - 13.0) < 0.1 + noise
    assert np.abs(narrow.center - [30.0, 0.0]).max() < 0.3 + 2.0 * noise
    assert abs(narrow.radius - 6.5) < 0.3 + 2.0 * noise
    assert abs(wide.turn - (2.0 * np.pi - 2.0 * gap)) < 0.3


def test_a_whole_circle_is_one_arc_wherever_its_rim_begins():
    rim = arc_of([5.0, -3.0], 9.0, 1.0, 1.0 + 2.0 * np.pi, 60)[:-1]
    (arc,) = arcs(rim)
    assert abs(arc.radius - 9.0) < 0.02
    assert arc.turn > 6.0


def test_places_along_a_rim_are_about_a_step_apart():
    places = evenly(SQUARE, 1.5)
    gaps = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    assert len(places) == round(140.0 / 1.5)
    assert gaps.max() <= 140.0 / len(places) + 1e-9


def test_a_circle_through_places_on_a_line_is_none():
    assert circle_through(np.column_stack([np.arange(5.0), 2.0 * np.arange(5.0)])) is None

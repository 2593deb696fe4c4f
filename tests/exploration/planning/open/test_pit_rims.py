"""Narrow holes that frames showed become rims of the flat faces that they are in."""

import numpy as np
import pytest

from exploration.planning.known.seen_pits import SeenPit
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.local_frontier import LocalFrontier
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]
FREE = np.empty((0, 3))


def plate():
    """A flat face, and what was felt of it."""
    xy = np.stack(np.meshgrid(np.arange(-15.0, 16.0, 1.5), np.arange(-9.0, 10.0, 1.5)), axis=-1).reshape(
        -1, 2
    )
    points = np.column_stack([xy, np.zeros(len(xy))])
    face, felt = (
        ranked_face(3, Contacts.of(points, np.tile(Z, (len(xy), 1)), 0.01, 0.01), MergeOptions()),
        SurfaceMap(),
    )
    felt.add(points, np.tile(Z, (len(xy), 1)))
    return face, felt


def pit(center, normal=Z):
    return SeenPit(np.array(center), np.asarray(normal), 2.5, np.zeros(2), 5, 6.0)


def test_one_in_a_face_is_an_opening_to_look_at_and_says_that_the_object_is_not_convex():
    face, felt = plate()
    now = LocalFrontier([face], felt, FREE, 10.0, pits=[pit([4.0, 1.0, 0.1])])
    (rim,) = now.openings
    assert rim.face == 3
    assert rim.center == pytest.approx([4.0, 1.0, 0.0], abs=1e-2)
    assert rim.axis @ Z > 0.999
    assert not rim.measured
    assert now.dented()


@pytest.mark.parametrize(
    "stray",
    [pit([4.0, 1.0, 2.0]), pit([4.0, 1.0, 0.1], -Z), pit([60.0, 1.0, 0.1]), pit([4.0, 1.0, 0.1], [1, 0, 0])],
)
def test_one_off_every_face_or_turned_from_it_is_none(stray):
    face, felt = plate()
    now = LocalFrontier([face], felt, FREE, 10.0, pits=[stray])
    assert now.openings == []
    assert not now.dented()


def test_a_hole_that_was_seen_as_two_is_one_opening():
    face, felt = plate()
    twice = [pit([4.0, 1.0, 0.1]), pit([5.7, 1.0, 0.0])]
    assert len(LocalFrontier([face], felt, FREE, 10.0, pits=twice).openings) == 1

"""What stopped a stroke under an overhang is no wall."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.lips import no_walls
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face

X, Y, Z = np.eye(3)
LEAN = np.array([0.85, 0.0, -0.5268])


def plane(normal, at, across, up):
    points = at + np.array([a * across + b * up for a in (-20.0, 0.0, 20.0) for b in (0.2, 0.5, 0.8)])
    return Contacts.of(points, np.tile(normal, (9, 1)))


def inferred(contacts):
    return replace(contacts, touch=np.full(len(contacts), NOT_FELT))


def face(number, contacts):
    return ranked_face(number, contacts, MergeOptions())


SIDE = inferred(
    plane(LEAN, -24.0 * X, Y, 19.0 * np.array([0.527, 0.0, 0.85]))
)  # from the floor up to the lip
FLOOR = face(0, plane(Z, np.zeros(3), Y, 10.0 * X))


def under(x, way=X):
    return inferred(plane(way, x * X, Y, 16.0 * Z))


@pytest.mark.parametrize(
    ("wall", "floor", "gone"),
    [
        (under(-15.5), FLOOR, {5}),
        (under(-9.0), FLOOR, set()),  # not at the lip
        (under(-15.5, -X), FLOOR, set()),  # looks the other way
        (replace(under(-15.5), touch=np.arange(9)), FLOOR, set()),  # was felt
        (under(-15.5), face(0, inferred(FLOOR.contacts)), set()),  # no floor was
        (under(-15.5), face(0, plane(-Z, np.zeros(3), Y, 10.0 * X)), set()),  # the side leans away from it
    ],
)
def test_a_wall_straight_down_from_the_lip_of_a_side_that_leans_over_the_floor_is_none(wall, floor, gone):
    assert no_walls(SIDE, [floor, face(5, wall)]) == gone


def test_a_side_that_stands_upright_or_lies_flat_has_no_lip():
    for side in (under(-15.5), inferred(plane(-Z, 16.0 * Z, Y, 10.0 * X))):
        assert no_walls(side, [FLOOR, face(5, under(-15.5))]) == set()

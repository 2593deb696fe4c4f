"""Whether something stands up from a flat face."""

import numpy as np
import pytest

from exploration.planning.open.bumps import BumpsConfig, bumpy
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

UP = np.array([0.0, 0.0, 1.0])
GRID = np.stack(np.meshgrid(np.arange(0.0, 40.0, 2.0), np.arange(0.0, 20.0, 2.0)), -1).reshape(-1, 2)
FLAT = np.column_stack([GRID, np.zeros(len(GRID))])
FACE = ranked_face(0, Contacts.of(FLAT, np.tile(UP, (len(FLAT), 1))), MergeOptions())


def felt(points, normal=UP):
    facing = [np.tile(UP, (len(FLAT), 1)), np.tile(normal, (len(points), 1))]
    return Contacts.of(np.concatenate([FLAT, points]), np.concatenate(facing))


def raised(high, count):
    return np.column_stack([np.arange(count) * 3.0, np.full(count, 5.0), np.full(count, high)])


@pytest.mark.parametrize(("high", "count", "told"), [(1.5, 24, True), (0.3, 24, False), (1.5, 8, False)])
def test_what_is_raised_high_and_wide_enough_stands_up(high, count, told):
    assert bumpy([FACE], felt(raised(high, count))) is told


def test_what_looks_another_way_or_lies_behind_the_face_does_not():
    aside = np.array([1.0, 0.0, 0.0])
    assert not bumpy([FACE], felt(raised(1.5, 24), aside))
    assert bumpy([FACE], felt(raised(11.0, 24), aside))  # farther than blur lays it
    assert not bumpy([FACE], felt(raised(-5.0, 24)))
    assert not bumpy([], felt(raised(1.5, 24)))


def test_fewer_places_may_be_asked_for():
    assert bumpy([FACE], felt(raised(1.5, 8)), BumpsConfig(least=8))


def test_a_face_that_is_known_at_one_end_says_little_of_the_other():
    """Felt over 10 mm and not to better than half a degree, 100 mm from what seems to lie in front of it."""
    few = np.column_stack([GRID[:6] * 0.25, np.zeros(6)])
    told = Contacts.of(few, np.tile(UP, (6, 1)), sigma=0.05, normal_sigma=0.02)
    far = raised(1.0, 24) + np.array([100.0, 0.0, 0.0])
    assert not bumpy([ranked_face(0, told, MergeOptions())], felt(far))

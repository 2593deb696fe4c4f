"""Untouched taxels against near-duplicates that contacts alone do not tell apart."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.arrays import frozen
from primitives.evidence import Contacts, FreeSpace
from primitives.pose import pose
from recognition.matching import Evidence, Hypothesis, match
from recognition.matching.untouched import log_untouched

PLAIN = Cube((80.0, 50.0, 10.0))
LIBRARY = Library.of(
    {"plain": Solid.from_csg(PLAIN), "bored": Solid.from_csg(PLAIN - Cylinder(6.0, 30.0).at(10.0, 0.0, 0.0))}
)
GRID = np.array([[x, y, 0.0] for x in (-2.0, 0.0, 2.0) for y in (-2.0, 0.0, 2.0)])
OVER_HOLE = np.array([10.0, 0.0, 4.5]) + GRID
NOTHING = Contacts.of([])


def _left(name: str, cells: np.ndarray, turned: float = 0.001, missed: FreeSpace | None = None) -> float:
    covariance = frozen(np.diag([1e-4] * 3 + [turned**2] * 3))
    h = Hypothesis(name, frozen(np.eye(4)), 0.0, covariance, 0.0, frozen(np.zeros(1)))
    return log_untouched(h, LIBRARY[name], Evidence(NOTHING, untouched=cells, missed=missed))


def test_a_hole_that_was_felt_speaks_against_the_plain_twin() -> None:
    assert _left("plain", OVER_HOLE) < -5.0
    assert _left("bored", OVER_HOLE) == 0.0


def test_free_places_outside_both_change_nothing() -> None:
    outside = np.array([[60.0, 0.0, 4.5], [0.0, 0.0, 8.0]])
    assert _left("plain", outside) == _left("bored", outside) == 0.0


def test_a_pose_that_is_not_known_is_not_asked_for_its_holes() -> None:
    assert _left("plain", OVER_HOLE, turned=1.0) == 0.0


def test_an_approach_through_an_object_makes_it_unlikely_and_no_more() -> None:
    through = FreeSpace(np.eye(4)[None], np.array([[10.0, 10.0, 60.0]]))
    beside = FreeSpace(pose(np.eye(3), [0.0, 90.0, 0.0])[None], through.half_extents)
    assert _left("plain", np.empty((0, 3)), missed=through) == pytest.approx(np.log(0.1))
    assert _left("plain", np.empty((0, 3)), missed=beside) == 0.0


def test_the_belief_names_the_bored_twin_where_the_skin_fell_into_its_hole() -> None:
    rng = np.random.default_rng(0)
    top = np.column_stack([rng.uniform([-40, -25], [40, 25], (12, 2)), np.full(12, 5.0)])
    ends = np.array([[40.0, y, z] for y in (-15.0, 15.0) for z in (-3.0, 3.0)])
    sides = np.array([[x, 25.0, z] for x in (-30.0, 30.0) for z in (-3.0, 3.0)])
    facing = np.repeat(np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]), [12, 4, 4], axis=0)
    far = np.linalg.norm(top[:, :2] - [10.0, 0.0], axis=1) > 8.0
    keep = np.concatenate([far, np.ones(8, dtype=bool)])
    contacts = Contacts.of(np.vstack([top, ends, sides])[keep], facing[keep], 0.05, 0.01)
    belief = match(Evidence(contacts, untouched=OVER_HOLE), LIBRARY)
    assert belief.decision == "bored"

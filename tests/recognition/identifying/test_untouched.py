"""Untouched taxels against near-duplicates that contacts alone do not tell apart."""

import numpy as np

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.arrays import frozen
from recognition.identifying.untouched import weighed
from recognition.matching import Belief, Hypothesis

PLAIN = Cube((80.0, 50.0, 10.0))
LIBRARY = Library.of(
    {"plain": Solid.from_csg(PLAIN), "bored": Solid.from_csg(PLAIN - Cylinder(6.0, 30.0).at(10.0, 0.0, 0.0))}
)
OVER_HOLE = np.array([10.0, 0.0, 4.5]) + np.array(
    [[x, y, 0.0] for x in (-2.0, 0.0, 2.0) for y in (-2.0, 0.0, 2.0)]
)


def _believed(turned: float = 0.001) -> Belief:
    covariance = frozen(np.diag([1e-4] * 3 + [turned**2] * 3))
    each = [
        Hypothesis(name, frozen(np.eye(4)), float(np.log(0.45)), covariance, 0.0, frozen(np.zeros(1)))
        for name in LIBRARY
    ]
    return Belief(tuple(each), {"plain": 0.45, "bored": 0.45, "unknown": 0.1})


def test_a_hole_that_was_felt_names_the_bored_twin() -> None:
    after = weighed(_believed(), LIBRARY, OVER_HOLE)
    assert after.decision == "bored"
    assert after.hypotheses[0].name == "bored"
    assert abs(sum(after.probabilities.values()) - 1.0) < 1e-9


def test_free_places_outside_both_change_nothing() -> None:
    after = weighed(_believed(), LIBRARY, np.array([[60.0, 0.0, 4.5], [0.0, 0.0, 8.0]]))
    assert abs(after.probabilities["plain"] - 0.45) < 1e-9


def test_a_pose_that_is_not_known_is_not_asked_for_its_holes() -> None:
    after = weighed(_believed(turned=1.0), LIBRARY, OVER_HOLE)
    assert abs(after.probabilities["plain"] - 0.45) < 1e-9

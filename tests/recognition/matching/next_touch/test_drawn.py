"""Draws of a pose that contacts leave open, on a plate that may lie along its face."""

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from models.csg import Cube
from models.library import Library
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.next_touch.flight import flown, least_turned
from recognition.matching.next_touch.held import placed
from recognition.matching.next_touch.sampled import sampled

PLATE = Library.of({"plate": Solid.from_csg(Cube((90.0, 60.0, 12.0)))})
PLACES = np.array([[0.0, 0.0, 6.0], [10.0, 0.0, 6.0], [0.0, 10.0, 6.0], [10.0, 10.0, 6.0]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


def _believed() -> tuple[Evidence, Belief]:
    contacts = Contacts.of(np.concatenate([PLACES, -PLACES]), np.concatenate([UP, -UP]), 0.1, 0.02)
    evidence = Evidence(contacts, untouched=np.array([[14.0, y, 5.0] for y in (0.0, 4.0, 8.0)]))
    return evidence, match(evidence, PLATE, Prior(np.zeros(3), 100.0), 0.0)


def test_draws_keep_the_contacts_on_the_surface_and_spread_along_it() -> None:
    evidence, belief = _believed()
    known = sampled(belief, PLATE, evidence, np.random.default_rng(0))
    assert np.isclose(known.weights.sum(), 1.0)
    assert known.loose.all()
    off = [np.abs(s.signed_distance(np.asarray(evidence.contacts.points))).max() for s in known.solids]
    assert np.average(np.array(off) < 0.5, weights=known.weights) > 0.9
    assert np.ptp(known.centers[:, :2], axis=0).min() > 8.0
    inside = [(s.signed_distance(evidence.untouched) < -1.5).any() for s in known.solids]
    assert np.average(inside, weights=known.weights) < 0.2


def test_an_approach_is_flown_until_shortly_before_what_may_be_there() -> None:
    down = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 100.0])
    known = placed([("plate", np.eye(4), 0.5, 0.0), ("plate", se3.pose(translation=[0, 0, 20.0]), 0.5, 0.0)],
                   PLATE, 0.01)  # fmt: skip
    taken = flown(Approach(down, 200.0), known, PLATE, (28.8, 18.0))
    assert 60.0 < taken.flown < 63.0
    assert np.isclose(taken.felt.start[2, 3], 100.0 - taken.flown)
    assert np.isclose(taken.felt.length, 200.0 - taken.flown)
    rare = [("plate", np.eye(4), 0.995, 0.0), ("plate", se3.pose(translation=[0, 0, 20.0]), 0.005, 0.0)]
    bold = flown(Approach(down, 200.0), placed(rare, PLATE, 0.01), PLATE, (28.8, 18.0))
    assert 80.0 < bold.flown < 83.0  # less than one in a hundred is no reason to feel the way
    strange = placed([("plate", np.eye(4), 1.0, 0.0)], PLATE, 0.3)
    assert flown(Approach(down, 200.0), strange, PLATE, (28.8, 18.0)).flown == 0.0


def test_the_pad_turns_by_less_than_an_eighth_about_its_own_approach() -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        turn = se3.random_rotation(rng)
        spun = turn @ se3.rotation_exp(np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)]))
        taken = least_turned(Approach(se3.pose(spun), 10.0), se3.pose(turn))
        assert np.allclose(taken.direction, turn[:, 2])
        assert se3.turn_between(taken.start, se3.pose(turn)) < np.pi / 4 + 1e-6

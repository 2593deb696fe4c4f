"""What is touched once a name is sure, and no touch tells more of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.devices.guard import Cost
from exploration.planning.touching.lone_touch import Approach, LoneTouch, joined
from exploration.planning.ways.round_ball import Ball
from models.csg import Cube
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose
from recognition.identifying import finish, identify
from recognition.identifying.exact import Exact
from recognition.identifying.identify import Identifier
from recognition.matching import Belief, Hypothesis
from recognition.matching.next_touch import NoChoice

LIBRARY = Library.of({"cube": Solid.from_csg(Cube((40.0, 40.0, 40.0)))})
BALL = Ball(np.zeros(3), 60.0)
SETTLING = Approach(pose(translation=[0.0, 0.0, -60.0]), 120.0)


@pytest.mark.parametrize("agreed", [0, 1])
def test_a_touch_that_only_confirms_a_name_is_made_for_the_pose(
    agreed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identify, "choose", lambda *args, **more: NoChoice("nothing"))
    monkeypatch.setattr(finish, "placing", lambda *args, **more: SETTLING)
    monkeypatch.setattr(identify, "sampled", lambda *args: None)
    hand = SimpleNamespace(
        cost=Cost(), here=np.eye(4), pad=(20.0, 20.0), pace=None, reachable=lambda approach: True
    )
    found = Hypothesis("cube", np.eye(4), 0.0, 1e-4 * np.eye(6), 0.0, np.zeros(1))
    contacts = Contacts.of([[0.0, 0.0, 20.0]], [[0.0, 0.0, 1.0]], 0.1, 0.01)
    felt = LoneTouch(1, SETTLING, contacts, (), joined([]), True, "a flat face", np.eye(4))
    identifier = Identifier(hand, LIBRARY, np.array([-100.0] * 3 + [100.0] * 3), touches=[felt])
    identifier.belief, identifier._agreed = Belief((found,), {"cube": 0.99, "unknown": 0.01}), agreed
    approach, choice = identifier._next(BALL)
    assert choice is None
    assert (approach is SETTLING) == bool(agreed)


def test_what_is_told_is_exact_and_touches_are_chosen_by_what_was_matched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of twins that are known unequally well hardly any touch seems to tell one from the other."""
    matched = Hypothesis("cube", np.eye(4), 0.0, 1e-4 * np.eye(6), 0.0, np.zeros(1))
    better = Hypothesis("cube", pose(translation=[0.05, 0.0, 0.0]), 0.0, 1e-6 * np.eye(6), 0.0, np.zeros(1))
    belief = Belief((matched,), {"cube": 0.99, "unknown": 0.01})
    monkeypatch.setattr(identify, "learned", lambda *args: belief)
    monkeypatch.setattr(identify, "exact", lambda *args: Exact(better, 0.01, 0.001))
    me = Identifier(SimpleNamespace(cost=Cost()), LIBRARY, np.array([-100.0] * 3 + [100.0] * 3))
    contacts = Contacts.of([[0.0, 0.0, 20.0]], [[0.0, 0.0, 1.0]], 0.1, 0.01)
    me._learn(LoneTouch(1, SETTLING, contacts, (), joined([]), True, "a flat face", np.eye(4)), None)
    assert me.belief is belief
    assert me.told.best("cube") is better
    assert me.told.probabilities == belief.probabilities

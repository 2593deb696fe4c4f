"""An approach that something stops on its way tells nothing, and the next one is made elsewhere."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.devices.guard import Collision, Cost, GuardLimits
from exploration.planning.touching.lone_touch import Approach, LoneTouch, blocked, joined
from exploration.planning.ways.round_ball import Ball
from models.csg import Cube
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose
from recognition.identifying import identify
from recognition.identifying.hand import GuardedHand
from recognition.identifying.identify import Identifier, IdentifyConfig
from recognition.matching import Belief, Hypothesis

LIBRARY = Library.of({"cube": Solid.from_csg(Cube((40.0, 40.0, 40.0)))})
AWAY = pose(translation=[0.0, 0.0, 90.0])
ASKED = Approach(pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 60.0]), 120.0)


class _InTheWay:
    """A guard that meets something wherever it is sent."""

    def __init__(self):
        self.cost, self.world_from_sensor, self.limits = Cost(), AWAY, GuardLimits()
        self.asked = []

    def go_to(self, where):
        self.asked.append(where[:3, 3])
        raise Collision("collision of lts210 by 0.13 mm")


def test_an_approach_that_is_blocked_on_its_way_is_a_touch_that_tells_nothing():
    hand = GuardedHand(_InTheWay())
    made = hand.touch(ASKED, Ball(np.zeros(3), 40.0))
    assert not made
    assert not made.told
    assert made.touch == hand.cost.touches == 1
    assert hand.warnings == ["collision of lts210 by 0.13 mm"]


def test_a_search_whose_ways_are_all_blocked_ends_and_says_so():
    guard = _InTheWay()
    guard.sensor = SimpleNamespace(array=SimpleNamespace(size=(30.0, 20.0)))
    hand = GuardedHand(guard, feature=40.0)
    assert not list(hand.find(np.array([-60.0] * 3 + [60.0] * 3)))
    assert len(guard.asked) > 9
    assert set(hand.warnings) == {"collision of lts210 by 0.13 mm"}


def test_round_an_object_larger_than_its_travel_the_stage_is_not_asked_to_leave_it():
    guard = _InTheWay()
    hand = GuardedHand(guard)
    for ways in (np.eye(3), -np.eye(3)):
        for way in ways:
            begin = pose(translation=-900.0 * way) @ pose(np.column_stack([ways[1], ways[2], way]))
            hand.touch(Approach(begin, 1500.0), Ball(np.zeros(3), 900.0))
    assert guard.asked
    assert np.abs(guard.asked).max() < 600.0


def test_after_two_that_were_blocked_belief_is_not_asked_where_to_touch(monkeypatch):
    asked = []
    monkeypatch.setattr(identify, "choose", lambda *args, **more: asked.append("belief"))
    monkeypatch.setattr(identify, "learned", lambda *args: asked.append("matched"))
    contacts = Contacts.of([[0.0, 0.0, 20.0]], [[0.0, 0.0, 1.0]], 0.1, 0.01)
    felt = LoneTouch(1, ASKED, contacts, (), joined([]), True, "a flat face", np.eye(4))
    hand = SimpleNamespace(
        cost=Cost(touches=1),
        here=AWAY,
        pad=(20.0, 20.0),
        pace=None,
        reachable=lambda approach: True,
        leave=lambda ball: None,
    )
    hand.touch = lambda approach, ball: blocked(2, approach, AWAY)
    me = Identifier(hand, LIBRARY, np.array([-100.0] * 3 + [100.0] * 3), IdentifyConfig(max_touches=3))
    found = Hypothesis("cube", np.eye(4), 0.0, 1e-4 * np.eye(6), 0.0, np.zeros(1))
    me.touches, me.belief, me._agreed = [felt], Belief((found,), {"cube": 0.99, "unknown": 0.01}), 1
    before = me.around()
    for _ in range(2):
        me._learn(hand.touch(ASKED, before), None)
    assert me._agreed == 1
    assert me.around().radius > before.radius
    approach, choice = me._next(me.around())
    assert choice is None
    assert not asked
    there, tried = (a.start[:3, 3] - me.around().center for a in (approach, ASKED))
    assert there @ tried < 0.5 * np.linalg.norm(there) * np.linalg.norm(tried)


@pytest.mark.parametrize("policy", ["grid", "largest-gap", "random", "information"])
def test_every_policy_begins_over_the_table(policy):
    hand = SimpleNamespace(cost=Cost(), here=AWAY, pad=(20.0, 20.0), pace=None)
    hand.reachable = lambda approach: approach.start[2, 3] > 10.0
    me = Identifier(hand, LIBRARY, np.array([-100.0] * 3 + [100.0] * 3), IdentifyConfig(policy=policy))
    below, begun = 0, []
    for k in range(12):
        approach, choice = me._next(Ball(np.zeros(3), 50.0))
        assert choice is None
        below += approach.start[2, 3] < 10.0
        begun.append(approach.start[:3, 3])
        me.touches.append(blocked(k, approach, AWAY))
    assert below == 0
    assert len(np.unique(np.round(begun, 3), axis=0)) > 6


def test_what_comes_from_aside_stays_over_the_table_until_near_the_object_and_from_above_it_need_not():
    told = SimpleNamespace(table=0.0, leads_past=lambda at: at[2, 3] > 9.0)
    hand = GuardedHand(_InTheWay(), told=told)

    def from_aside(high, down):
        way = np.array([np.cos(down), 0.0, -np.sin(down)])
        begin = pose(np.column_stack([np.cross([0.0, 1.0, 0.0], way), [0.0, 1.0, 0.0], way]))
        begin[:3, 3] = [-80.0, 0.0, high]
        return Approach(begin, 160.0)

    assert hand.reachable(from_aside(30.0, 0.1))
    assert not hand.reachable(from_aside(30.0, 0.5))
    assert hand.reachable(from_aside(30.0, 1.4))
    assert not hand.reachable(from_aside(5.0, 0.0))

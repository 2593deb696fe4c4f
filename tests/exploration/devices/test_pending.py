"""Commands on their way: the predicted pose is where the stage will be."""

import numpy as np
import pytest

from exploration.devices.pending import Pending
from primitives.pose import exp


def test_nothing_is_pending_without_latency() -> None:
    pending = Pending(0.0)
    pending.say(0.0, np.ones(6))
    assert pending.motion(0.005) == pytest.approx(np.eye(4))


def test_a_steady_twist_is_pending_for_the_latency() -> None:
    twist, pending = np.array([10.0, 0.0, 1.0, 0.1, 0.0, 0.5]), Pending(0.02)
    for k in range(20):
        pending.say(0.005 * k, twist)
    assert pending.motion(0.1) == pytest.approx(exp(0.02 * twist))


def test_pending_twists_add_up_to_their_product_where_the_pad_turns_little() -> None:
    first, second = np.array([10.0, 0, 0, 0, 0, 0]), np.array([0, 0, 0, 0, 0, 2.0])
    pending = Pending(0.01)
    pending.say(0.0, first)
    pending.say(0.005, second)
    assert pending.motion(0.01) == pytest.approx(exp(0.005 * first) @ exp(0.005 * second), abs=5e-4)


def test_a_command_older_than_the_latency_is_done() -> None:
    pending = Pending(0.01)
    pending.say(0.0, np.array([10.0, 0, 0, 0, 0, 0]))
    pending.say(0.005, np.zeros(6))
    assert pending.motion(0.02) == pytest.approx(np.eye(4))

"""A Grbl stage's kinematics, its words, and what a strict controller refuses."""

import numpy as np
import pytest

from exploration.devices.emulators.grbl_machine import GrblMachine
from exploration.devices.grbl_text import jog, status
from exploration.devices.jog_plan import JogPlan, StreamConfig
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.protocols import StageLimits


def machine() -> GrblMachine:
    return GrblMachine("XYZ", np.zeros(3), np.full(3, 100.0))


def said(m: GrblMachine, text: bytes) -> bytes:
    m.receive(text)
    told = b"".join(m.replies)
    m.replies.clear()
    return told


def test_joints_are_found_again_from_the_pose_that_they_give():
    chain, rng = KinematicChain.gantry(), np.random.default_rng(0)
    for _ in range(20):
        q = np.concatenate([rng.uniform(-100, 100, 3), rng.uniform(-1.0, 1.0, 3)])
        goal = chain.pose(q)
        reached = chain.reach(goal, q + 0.1 * rng.standard_normal(6))
        assert reached
        assert np.allclose(chain.pose(reached.q), goal, atol=1e-3)


def test_three_axes_cannot_turn_the_pad():
    chain = KinematicChain.gantry("XYZ")
    assert not chain.reach(KinematicChain.gantry().pose(np.array([0, 0, 0, 0, 0.5, 0.0])), np.zeros(3))


def test_a_status_report_is_read_with_its_pins():
    told = status("<Jog|MPos:1.000,-2.500,3.000|Bf:14,100|FS:0,0|Pn:P>")
    assert (told.state, told.position, told.pins, told.blocks) == ("Jog", (1.0, -2.5, 3.0), "P", 14)


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        (b"$J=G91X1\n", b"error:22"),
        (b"$J=G91X500F100\n", b"error:15"),
        (b"$J=G91X1F100" + b" " * 90 + b"\n", b"error:11"),
    ],
)
def test_what_grbl_refuses_is_refused(line, answer):
    assert answer in said(machine(), line)


def test_a_jog_in_alarm_is_refused():
    m = machine()
    m.alarm(1)
    assert b"error:9" in said(m, b"$J=G91X1F100\n")


def test_a_canceled_jog_ends_where_braking_ends():
    m = machine()
    said(m, (jog("XYZ", [50.0, 0.0, 0.0], 1200.0) + "\n").encode())
    m.advance(0.5)
    at = m.position[0]
    said(m, b"\x85")
    m.advance(0.1)
    assert m.state == "Idle"
    assert 0.0 < m.position[0] - at < 20.0**2 / (2 * 2000.0) + 0.05


@pytest.mark.parametrize("speed", [5.0, 20.0, 60.0])
@pytest.mark.parametrize("late", [0, 12])  # [ms] by which the stage starts
def test_all_that_was_sent_ahead_is_over_in_time_and_no_motion_waits_for_more(speed, late):
    limits = StageLimits(speed=speed)
    braking = 0.5 * speed / limits.acceleration  # [s] that coming to rest adds
    chain = KinematicChain.gantry("XYZ")
    plan = JogPlan(chain, limits, StreamConfig())
    plan.head_for(chain.pose(np.array([0.5 * speed, 0.0, 0.0])))
    x, reports, waited = 0.0, [np.zeros(3)] * 6, 0
    for k in range(500):
        now = 1e-3 * k
        while (sent := plan.due(now, reports[-6])) is not None:
            plan.took(sent, now)
        if k >= late:
            waited += plan.leads_to[0] - x < 0.5 * speed * 1e-3
            x = min(plan.leads_to[0], x + speed * 1e-3)
        reports.append(np.array([x, 0.0, 0.0]))
        assert (plan.leads_to[0] - x) / speed + braking <= 0.05
    assert waited <= 2

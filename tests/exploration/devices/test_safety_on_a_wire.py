"""What a stage does when frames stop, freeze or show too much, over pseudo-terminals.

All live by the rig's clock, which stands while it does not get the processor, so that a busy machine is no fault.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from exploration.devices.clock import Clock, ReadClock
from exploration.devices.emulators.rig import EmulatedRig
from exploration.devices.grbl_link import GrblLink
from exploration.devices.grbl_stage import GrblStage, StreamConfig
from exploration.devices.guard import Guard
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.ports import Port
from exploration.devices.protocols import StageLimits
from exploration.devices.safety import Safety, SafetyLimits
from exploration.devices.serial_array import SerialArray
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3

LTS = load_sensor("lts210")
PAD = LTS.array.pitch[0] * LTS.array.pitch[1]
UP = np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0])
DOWN = -UP


@contextmanager
def devices(
    height: float, force: float = 60.0
) -> Iterator[tuple[EmulatedRig, SerialArray, GrblStage, Safety]]:
    """A rig `height` [mm] over a block's face, and the drivers at the other end of its wires."""
    chain = KinematicChain.gantry()
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 20.0 + height])
    block = Solid.from_csg(Cube((40.0, 40.0, 40.0)))
    rig = EmulatedRig(block, LTS, chain, chain.reach(above, np.zeros(6)).q, "lines")
    over = threading.Event()
    server = threading.Thread(target=rig.serve, args=(over.is_set,), daemon=True)
    server.start()
    clock = ReadClock(rig.clock_path)
    array = SerialArray(Port(rig.array_path, 115200), "lines", LTS.array, LTS.period, np.eye(4), clock)
    told = SafetyLimits(force, patience=0.3)
    safety = Safety(Calibration.nominal(LTS), PAD, LTS.period, told, clock=clock)
    array.watch = safety.seen
    array.start()
    array.read()
    limits = StageLimits(20.0, 500.0, 1.0, 10.0)
    link = GrblLink(Port(rig.stage_path, 115200), clock)
    stage = GrblStage(link, chain, limits, safety, StreamConfig(dumb=10.0))
    stage.start()
    try:
        yield rig, array, stage, safety
    finally:
        stage.close()
        array.close()
        over.set()
        server.join(30.0)
        assert not server.is_alive()
        rig.close()


def comes(true: Callable[[], bool], within: float = 240.0, do: Callable[[], object] = lambda: None) -> bool:
    """Whether something becomes true, while `do` is done again and again."""
    until = time.monotonic() + within
    while time.monotonic() < until:
        do()
        if true():
            return True
        time.sleep(0.02)
    return False


def passes(rig: EmulatedRig, seconds: float) -> None:
    """Wait until the rig has run so long."""
    ReadClock(rig.clock_path).sleep(seconds)


def at_rest(rig: EmulatedRig) -> bool:
    """Whether the machine stands, and stays."""
    before = rig.machine.position.copy()
    passes(rig, 0.3)
    return bool(rig.machine.state == "Idle" and (rig.machine.position == before).all())


@pytest.mark.parametrize("fault", ["silent", "frozen"])
def test_frames_that_stop_or_freeze_end_motion_and_hold(fault):
    with devices(80.0) as (rig, _, stage, safety):
        start = rig.machine.position.copy()
        wish = lambda: stage.move(UP)  # noqa: E731
        assert comes(lambda: bool(np.linalg.norm(rig.machine.position - start) > 1.0), do=wish)
        setattr(rig.faults, fault, True)
        assert comes(lambda: safety.silent(rig.clock.now()) and rig.machine.state == "Idle", do=wish)
        assert at_rest(rig)
        held = rig.machine.position.copy()
        stage.move(UP)
        passes(rig, 0.3)
        assert (rig.machine.position == held).all()
        assert not rig.machine.violations


@pytest.mark.slow
def test_a_goal_is_held_while_frames_are_away_and_reached_when_they_come_again():
    with devices(80.0) as (rig, _, stage, safety):
        goal = stage.pose() @ se3.pose(None, [0.0, 0.0, -45.0])
        stage.go_to(goal)
        rig.faults.silent = True
        assert comes(lambda: safety.silent(rig.clock.now()) and rig.machine.state == "Idle")
        assert at_rest(rig)
        assert stage.moving, stage.fault
        rig.faults.silent = False
        assert comes(lambda: not stage.moving)
        assert np.allclose(stage.pose()[:3, 3], goal[:3, 3], atol=0.05)


def test_too_much_force_locks_motion_until_it_is_stopped():
    with devices(1.0, force=5.0) as (rig, _, stage, safety):
        assert comes(lambda: bool(safety.tripped), do=lambda: stage.move(DOWN))
        assert comes(lambda: rig.machine.state == "Idle", do=lambda: stage.move(DOWN))
        locked = rig.machine.position.copy()
        stage.move(UP)
        passes(rig, 0.4)
        assert (rig.machine.position == locked).all()
        stage.stop()
        assert not safety.tripped
        risen = lambda: bool(np.linalg.norm(rig.machine.position - locked) > 2.0)  # noqa: E731
        assert comes(risen, do=lambda: stage.move(UP))


def test_a_feed_hold_at_the_machine_holds_a_goal_until_it_is_resumed_there():
    with devices(80.0) as (rig, _, stage, _):
        goal = stage.pose() @ se3.pose(None, [0.0, 0.0, -20.0])
        stage.go_to(goal)
        assert comes(lambda: rig.machine.state == "Jog")
        rig.press(b"!")
        assert comes(lambda: stage.state == "Hold")
        assert comes(lambda: rig.machine.standing)
        held = rig.machine.position.copy()
        passes(rig, 0.4)
        assert (rig.machine.position == held).all()
        assert stage.moving
        rig.press(b"~")
        assert comes(lambda: not stage.moving)
        assert np.allclose(stage.pose()[:3, 3], goal[:3, 3], atol=0.05)
        assert set(rig.machine.violations) <= {"error:8"}  # to a line that was on its way just then


def test_a_feed_hold_is_no_stage_that_stands_though_told_to_move():
    with devices(80.0) as (rig, array, stage, _):
        guard = Guard(stage, [array], [Calibration.nominal(LTS)])
        assert comes(lambda: rig.machine.state == "Jog", do=lambda: guard.move(3.0 * UP))
        rig.press(b"!")
        assert comes(lambda: stage.state == "Hold", do=lambda: guard.move(3.0 * UP))
        held = rig.machine.position.copy()
        for _ in range(200):  # 15 mm are asked for in vain
            guard.move(3.0 * UP)
        rig.press(b"~")
        risen = lambda: bool(np.linalg.norm(rig.machine.position - held) > 2.0)  # noqa: E731
        assert comes(risen, do=lambda: guard.move(3.0 * UP))


def test_cables_that_come_loose_and_back_cost_a_pause_and_not_the_goal():
    with devices(80.0) as (rig, array, stage, _):
        goal = stage.pose() @ se3.pose(None, [0.0, 0.0, -20.0])
        stage.go_to(goal)
        assert comes(lambda: rig.machine.state == "Jog")
        rig.unplug_stage()
        rig.unplug_array()
        passes(rig, 0.4)
        rig.plug_in()
        assert comes(lambda: stage.reconnects == 1 and array.counts.reconnects == 1)
        assert comes(lambda: not stage.moving), stage.fault
        assert np.allclose(stage.pose()[:3, 3], goal[:3, 3], atol=0.05)
        assert not stage.fault


def frame(counts: np.ndarray, index: int) -> TaxelFrame:
    return TaxelFrame(counts, float(index), index)


class SetClock(Clock):
    """One that stands where it was set."""

    time = 0.0

    def now(self) -> float:
        return self.time


def test_repeated_frames_count_as_silence_and_noisy_or_quiet_ones_do_not():
    nominal, rng = Calibration.nominal(LTS), np.random.default_rng(0)
    limits = SafetyLimits(patience=0.05)
    pressed = np.full(LTS.array.shape, 100.0)
    noisy = lambda: np.rint(pressed + nominal.noise * rng.standard_normal(pressed.shape))  # noqa: E731

    def silent_after(counts: Callable[[], np.ndarray], calibration: Calibration = nominal) -> bool:
        clock = SetClock()
        safety = Safety(calibration, PAD, 0.005, limits, clock=clock)
        for k in range(30):
            clock.time = 0.01 * k
            safety.seen(frame(counts(), k))
        return safety.silent(clock.now())

    assert nominal.noise > 0.5
    assert silent_after(lambda: pressed)
    assert not silent_after(noisy)
    assert not silent_after(lambda: pressed, replace(nominal, noise=0.0))

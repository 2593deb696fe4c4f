"""An array and a Grbl stage over one object, each on a pseudo-terminal, in real time.

The simulator's own array rides on a stage that the controller's planner moves.  `Faults` disturb what
goes over the wire; what happened in the physics is kept for whoever judges.  The ports' names are links that stay
when a cable is pulled and plugged in again.  Whoever drives the rig reads its clock (`devices.clock`), and the rig
waits a moment for a driver that asks no more, so that a busy machine is no fault of either; `waited` says how
long.
"""

import select
import shutil
import tempfile
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exploration.devices.clock import WrittenClock
from exploration.devices.emulators import terminals
from exploration.devices.emulators.array_words import encoded, replies
from exploration.devices.emulators.grbl_machine import GrblMachine
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.simulated_array import SimulatedArray
from exploration.devices.simulated_stage import SimulatedStage
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.surface import Surface

_ROUND = 0.001  # [s] at most that a round waits for bytes
_ASKS = 0.01  # [s] of the rig's time within which a driver that gets to run asks for a report
_WAITS = 2.0  # [s] of the machine's time that the rig waits for it


@dataclass
class Faults:
    """What goes wrong; changed at will while the rig runs."""

    byte_errors: float = 0.0  # share of the array's bytes that arrive changed
    dropouts: float = 0.0  # share of the frames that never arrive
    silent: bool = False  # the array sends nothing
    frozen: bool = False  # the array repeats one frame
    deaf: bool = False  # the stage neither hears nor answers, and moves on
    garbled: float = 0.0  # share of the stage's answers that arrive with a changed byte
    noise: bool = False  # the array's bytes are those of another baud rate
    latency: float = 0.0  # [s] by which the stage answers late


class _DrivenStage(SimulatedStage):
    """The simulated stage, moved by the controller."""

    def __init__(self, machine: GrblMachine, chain: KinematicChain, rng: np.random.Generator) -> None:
        self.machine, self._chain = machine, chain
        super().__init__(chain.pose(machine.position / chain.to_wire), rng)

    def _integrate(self, dt: float) -> None:
        self._time += dt
        self.machine.advance(dt)
        if self.machine.moved:
            self._true = self._chain.pose(self.machine.position / self._chain.to_wire)


class EmulatedRig:
    """Both devices; `serve` until told to end."""

    def __init__(
        self,
        surface: Surface,
        spec: SensorSpec,
        chain: KinematicChain,
        start: Floats,
        protocol: str,
        seed: int = 0,
        acceleration: float = 2000.0,
        pace: float = 1.0,
        flange_from_sensor: Floats | None = None,
    ) -> None:
        rng = np.random.default_rng(seed)
        letters = "".join(axis.letter for axis in chain.axes)
        travel = np.maximum(np.abs(chain.least), np.abs(chain.most)) * chain.to_wire
        self.machine = GrblMachine(letters, start * chain.to_wire, travel, acceleration)
        self.stage = _DrivenStage(self.machine, chain, rng.spawn(1)[0])
        mount = np.eye(4) if flange_from_sensor is None else flange_from_sensor
        self.array = SimulatedArray(surface, spec, self.stage, mount, rng.spawn(1)[0])
        self.faults = Faults()
        self.most_force = 0.0  # [N] that the skin truly carried, as far as its taxels show
        self.housing_hits = 0
        self._spec, self._protocol, self._rng = spec, protocol, rng
        self._calibration = Calibration.nominal(spec)
        self._folder = Path(tempfile.mkdtemp(prefix="palpate-"))
        self.array_path, self.stage_path = str(self._folder / "array"), str(self._folder / "stage")
        self.clock_path = self._folder / "clock"
        self.clock = WrittenClock(self.clock_path, pace)
        self._array_end, self._array_held = terminals.plugged(self.array_path)
        self._stage_end, self._stage_held = terminals.plugged(self.stage_path)
        self.waited = 0.0  # [s] of the machine's time, for the driver
        self._asked = (0.0, -np.inf)  # when the driver was heard last, in the rig's time and the machine's
        self._turned = time.monotonic()
        self._hands: deque[Callable[[], None]] = deque()  # what a person does, from any thread
        self._late: list[tuple[float, bytes]] = []
        self._unsent, self._unread = b"", False  # of the array, and whether waiting for a reader was in vain
        self._full = 0.0  # [s] of the machine's time, when there was no room
        self._frozen: TaxelFrame | None = None

    def serve(self, ends: Callable[[], bool]) -> None:
        """Answer until `ends()`."""
        while not ends():
            self.turn()

    def turn(self) -> None:
        """One round: what a person did, frames that are due, and what has come."""
        while self._hands:
            self._hands.popleft()()
        self._send(b"")
        self._hear(0.0)
        now = self._tick()
        self._live_until(now)
        self._hear(min(_ROUND, max(self._next_frame() - now, 0.0)))

    def _hear(self, wait: float) -> None:
        """Obey what has come, after waiting [s] for it, at the time at which it was sent.

        Whoever sent it read this clock, and that has stood since the last round, whoever did not get to run.
        """
        ends = [end for end in (self._stage_end, self._array_end) if end >= 0]
        for end in select.select(ends, [], [], wait)[0]:
            data = terminals.read(end)
            if end == self._stage_end and data and not self.faults.deaf:
                self._asked = (self.clock.now(), time.monotonic())
                self.machine.receive(data)
            elif end == self._array_end and data:
                terminals.write(self._array_end, replies(self._protocol, data, self._spec))
        self._send_replies(self.clock.now())

    def _live_until(self, now: float) -> None:
        """Move on, with every frame that is complete by then: a round may last longer than a frame."""
        while (due := self._next_frame()) <= now:
            self._frame()
            self.stage._advance(due)
        self.stage._advance(now)

    def _next_frame(self) -> float:
        """[s] when the next frame is complete."""
        period = self._spec.period
        return float((np.floor(self.stage._time / period + 1e-6) + 1) * period)

    def _tick(self) -> float:
        """The time, which stands while a driver that was there does not get to run, or has not read its frames."""
        asked, heard = self._asked
        real = time.monotonic()
        silent = self.clock.now() - asked > _ASKS and real - heard < _WAITS and not self.faults.deaf
        if silent or self._unsent:
            self.waited += real - self._turned
            self.clock.stand()
        else:
            self.clock.tick()
        self._turned = real
        return self.clock.now()

    def close(self) -> None:
        """Unplug both, and leave nothing behind; once nobody serves any more."""
        self._pull_array()
        self._pull_stage()
        shutil.rmtree(self._folder, ignore_errors=True)

    def press(self, button: bytes) -> None:
        """A person at the machine: `!` hold, `~` go on, 0x18 reset; obeyed in the next round."""
        self._hands.append(lambda: self.machine.receive(button))

    def unplug_array(self) -> None:
        """Pull the array's cable, in the next round."""
        self._hands.append(self._pull_array)

    def unplug_stage(self) -> None:
        """Pull the stage's cable, in the next round; the controller moves on."""
        self._hands.append(self._pull_stage)

    def plug_in(self) -> None:
        """Plug in again what was pulled, in the next round."""
        self._hands.append(self._plug_in)

    def _pull_array(self) -> None:
        self._array_end, self._array_held = terminals.pulled(
            self.array_path, self._array_end, self._array_held
        )

    def _pull_stage(self) -> None:
        self._stage_end, self._stage_held = terminals.pulled(
            self.stage_path, self._stage_end, self._stage_held
        )
        self._asked = (0.0, -np.inf)

    def _plug_in(self) -> None:
        if self._array_end < 0:
            self._array_end, self._array_held = terminals.plugged(self.array_path)
        if self._stage_end < 0:
            self._stage_end, self._stage_held = terminals.plugged(self.stage_path)

    def _frame(self) -> None:
        frame = self.array.read()
        c, area = self._calibration, self._spec.array.pitch[0] * self._spec.array.pitch[1]
        self.most_force = max(self.most_force, float(((frame.counts - c.zero) / c.gain).sum() * area))
        events = self.stage.events()
        self.housing_hits += bool(events) and not self.machine.pins
        self.machine.pins = "P" if events else ""
        if self.faults.frozen:
            frame = self._frozen or frame
        self._frozen = frame
        if self.faults.silent or self._rng.random() < self.faults.dropouts:
            return
        data = bytearray(encoded(self._protocol, frame))
        if self.faults.noise:
            data[:] = self._rng.integers(0, 256, len(data), dtype=np.uint8).tobytes()
        if self.faults.byte_errors:
            hit = np.flatnonzero(self._rng.random(len(data)) < self.faults.byte_errors)
            for at in hit:
                data[at] = int(self._rng.integers(0, 256))
        self._send(bytes(data))

    def _send(self, data: bytes) -> None:
        """A frame, once there is room for it: a driver that does not get to run has not read the last ones."""
        if self._unsent and time.monotonic() - self._full > _WAITS:
            self._unsent, self._unread = b"", True
        waiting = self._unsent + data
        left = waiting[terminals.write(self._array_end, waiting) :] if waiting else b""
        if not left:
            self._unread = self._unread and not waiting
        elif not self._unsent:
            self._full = time.monotonic()
        self._unsent = b"" if self._unread else left

    def _send_replies(self, now: float) -> None:
        if self.machine.replies:
            data = b"".join(self.machine.replies)
            self.machine.replies.clear()
            self._late.append((now + self.faults.latency, data))
        while self._late and self._late[0][0] <= now:
            answer = bytearray(self._late.pop(0)[1])
            if answer and self._rng.random() < self.faults.garbled:
                answer[int(self._rng.integers(0, len(answer)))] = int(self._rng.integers(0, 256))
            if not self.faults.deaf:
                terminals.write(self._stage_end, bytes(answer))

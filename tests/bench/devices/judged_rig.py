"""An emulated rig over a block, in a process of its own, that does what it is told and keeps what truly happened.

Orders go through a pipe with the time at which to obey them; the physics, position and true force, is written down
every round.  The pad lies level over the block's face, so its true force is stiffness * area * depth, whatever its
taxels can show.
"""

from __future__ import annotations

import contextlib
import multiprocessing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from exploration.devices.emulators.rig import EmulatedRig
from exploration.devices.kinematic_chain import KinematicChain
from exploration.sensing.physics.skin import skin_of
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3

TOP = 20.0  # [mm] height of the block's face
LTS = load_sensor("lts210")
_ANSWERS = 120.0  # [s] of the machine's time, with what the process needs to start
ACCELERATION = 2000.0  # [mm/s^2] of the emulated stage

_CONFIG = """
[array]
port = "{array}"
protocol = "{protocol}"
sensor = "lts210"

[stage]
port = "{stage}"
axes = "XYZABC"
speed_mm_s = 60.0
acceleration_mm_s2 = 2000.0
crash_pin = "P"

[limits]
force_n = {force}

[emulation]
clock = "{clock}"
"""


@dataclass(frozen=True)
class Truth:
    """What happened."""

    time: np.ndarray  # (n,) [s]
    position: np.ndarray  # (n, 3) [mm] of the flange
    force: np.ndarray  # (n,) [N]
    violations: list[str]

    def stands_from(self, moment: float) -> float:
        """[s] from when on, at or after a moment, it did not move for 30 ms at least."""
        t, steps = self._steps(moment)
        moved = np.flatnonzero(np.linalg.norm(steps, axis=1) > 1e-6)
        edges = np.concatenate([[t[0]], t[moved + 1], [t[-1]]])
        gaps = np.flatnonzero(np.diff(edges) > 0.03)
        return float(edges[gaps[0]]) if len(gaps) else float(t[-1])

    def retreats_from(self, moment: float) -> float:
        """[s] from when on, at or after a moment, it went up, within 10 degrees, or nowhere."""
        t, steps = self._steps(moment)
        side = np.linalg.norm(steps[:, :2], axis=1)
        other = np.flatnonzero((side > 0.18 * np.maximum(steps[:, 2], 0.0) + 1e-6) | (steps[:, 2] < -1e-6))
        return float(t[other[-1] + 1] if len(other) else t[0])

    def fastest(self, begin: float, end: float) -> float:
        """[mm/s] between two times, over 5 ms."""
        t = np.arange(begin - 0.01, end, 0.005)
        if len(t) < 2:
            return 0.0
        p = np.stack([np.interp(t, self.time, axis) for axis in self.position.T], axis=1)
        return float(np.linalg.norm(np.diff(p, axis=0), axis=1).max() / 0.005)

    def _steps(self, moment: float) -> tuple[np.ndarray, np.ndarray]:
        after = self.time >= moment
        return self.time[after], np.diff(self.position[after], axis=0)


class JudgedRig:
    """The process; use it in a `with`."""

    def __init__(
        self, folder: Path, height: float, force: float, seed: int, pace: float, protocol: str
    ) -> None:
        server = multiprocessing.get_context("forkserver")
        server.set_forkserver_preload(["devices.judged_rig"])
        self._pipe, theirs = server.Pipe()
        self._process = server.Process(
            target=_serve, args=(theirs, height, seed, pace, protocol), daemon=True
        )
        self._process.start()
        ports = self._told()
        self.config = folder / "rig.toml"
        self.config.write_text(_CONFIG.format(force=force, protocol=protocol, **ports))

    def __enter__(self) -> JudgedRig:
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):  # it has ended by itself
            self._pipe.send((0.0, "end", None))
        self._process.join(30.0)
        if self._process.is_alive():
            self._process.kill()

    def order(self, moment: float, what: str, value: object = None) -> None:
        """At a moment of the rig's clock, or at once."""
        self._pipe.send((moment, what, value))

    def truth(self) -> Truth:
        """Everything until now."""
        self.order(0.0, "tell")
        return self._told()

    def _told(self) -> Any:
        if not self._pipe.poll(_ANSWERS):
            raise RuntimeError(f"the emulated rig did not answer within {_ANSWERS:.0f} s")
        return self._pipe.recv()


def _serve(pipe, height: float, seed: int, pace: float, protocol: str) -> None:
    chain = KinematicChain.gantry()
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, TOP + height])
    block = Solid.from_csg(Cube((90.0, 90.0, 2 * TOP)))
    start = chain.reach(above, np.zeros(6)).q
    rig = EmulatedRig(block, LTS, chain, start, protocol, seed, ACCELERATION, pace)
    pipe.send({"array": rig.array_path, "stage": rig.stage_path, "clock": str(rig.clock_path)})
    skin = skin_of(LTS)
    area = float(np.ptp(skin.x_edges) * np.ptp(skin.y_edges))
    times, places, forces, waiting = [], [], [], []
    while True:
        rig.turn()
        if not times or rig.stage._time > times[-1]:
            times.append(rig.stage._time)
            places.append(rig.machine.position[:3].copy())
            forces.append(LTS.elastomer.stiffness * area * max(0.0, TOP - rig.machine.position[2]))
        while pipe.poll():
            waiting.append(pipe.recv())
        for item in [item for item in waiting if item[0] <= rig.clock.now()]:
            waiting.remove(item)
            _, what, value = item
            if what == "end":
                rig.close()
                return
            if what == "tell":
                pipe.send(
                    Truth(np.array(times), np.array(places), np.array(forces), list(rig.machine.violations))
                )
            elif what == "reset":
                rig.machine.receive(b"\x18")
            elif what == "alarm":
                rig.machine.alarm(value)
            elif what == "swallow":
                rig.machine.swallow_ok = value
            elif what in ("unplug_array", "unplug_stage", "plug_in"):
                getattr(rig, what)()
            elif what == "mend":
                rig.faults = type(rig.faults)()
                rig.plug_in()
            else:
                setattr(rig.faults, what, value)

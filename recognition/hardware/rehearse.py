"""`palpate explore --device CONFIG --dry-run`: every motion before the first contact, and nothing moves.

The explorer itself runs, on a simulated stage that begins where the real one stands, over nothing at all: so it
makes the very motions that it would make until something is touched.  Each is checked against the stage's axes
and the box that its flange may not leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from exploration.control.latency import measure_latency
from exploration.devices.guard import Guard, GuardLimits
from exploration.devices.protocols import StageLimits
from exploration.devices.simulated_array import SimulatedArray
from exploration.devices.simulated_stage import SimulatedStage
from exploration.planning.explorer import Explorer, ExplorerConfig
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.surface import RayHits
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.rig import open_rig, sensor_of, stage_limits

_STRAIGHT = 0.02  # [rad] between the directions of one motion
_FAR = 1e6  # [mm]


@dataclass(frozen=True)
class Motion:
    """One straight motion of the flange."""

    what: str
    start: Floats  # (4, 4)
    end: Floats  # (4, 4)
    seconds: float
    trouble: str  # why the stage cannot make it; empty where it can


class Nothing:
    """The surface of no object at all."""

    def signed_distance(self, points: Floats) -> Floats:
        """(n,) [mm], far."""
        return np.full(len(points), _FAR)

    def normals(self, points: Floats) -> Floats:
        """(n, 3) up."""
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """No hit."""
        count = len(origins)
        return RayHits(np.full(count, np.inf), np.zeros((count, 3)), np.full(count, -1))


class _WatchedStage(SimulatedStage):
    """A simulated stage that notes where each motion begins."""

    def __init__(self, start: Floats, limits: StageLimits) -> None:
        super().__init__(start, np.random.default_rng(0), limits)
        self.begun: list[tuple[float, str, Floats]] = []
        self._way = np.zeros(3)

    def move(self, twist: Floats) -> None:
        """Follow a twist; a change of its direction is a new motion."""
        speed = float(np.linalg.norm(twist[:3]))
        way = self.pose()[:3, :3] @ twist[:3] / speed if speed > 1e-9 else np.zeros(3)
        if float(np.linalg.norm(way - self._way)) > _STRAIGHT and speed > 1e-9:
            self.begun.append((self._time, "feel along", self.pose()))
        self._way = way
        super().move(twist)

    def go_to(self, world_from_flange: Floats) -> None:
        """A straight move."""
        self.begun.append((self._time, "go to", self.pose()))
        self._way = np.zeros(3)
        super().go_to(world_from_flange)


def rehearsed(path: Path) -> list[Motion]:
    """The motions, in order, until the workspace has been searched in vain."""
    config = load_device(path)
    rig = open_rig(config)
    try:
        rig.array.read()
        start, mount = rig.stage.pose(), rig.array.flange_from_sensor
    finally:
        rig.close()
    spec = sensor_of(config)
    stage = _WatchedStage(start, stage_limits(config))
    array = SimulatedArray(Nothing(), spec, stage, mount, np.random.default_rng(0))
    reach = tuple(np.reshape(config.limits.reach_mm, (2, 3)).ravel() + np.repeat([-_FAR, _FAR], 3))
    guard = Guard(stage, [array], [Calibration.nominal(spec)], GuardLimits(reach=reach))
    measure_latency(guard)
    shaken = len(stage.begun)
    box = np.array(config.limits.workspace_mm)
    for _ in Explorer(guard, box, ExplorerConfig(), tools=(Tool.of(spec),)).run():
        pass
    ends = [*stage.begun[1:], (stage._time, "", stage.pose())]
    made = [
        _checked(config, "shake" if k < shaken else what, begun, end, after - before)
        for k, ((before, what, begun), (after, _, end)) in enumerate(zip(stage.begun, ends, strict=True))
    ]
    shakes = made[:shaken]
    shake = [Motion("shake by 1 mm", start, start, sum(m.seconds for m in shakes), "")] * bool(shakes)
    return [*shake, *(motion for motion in made[shaken:] if motion.seconds > 0.0)]


def _checked(config: DeviceConfig, what: str, start: Floats, end: Floats, seconds: float) -> Motion:
    assert config.stage is not None
    chain = config.stage.chain
    reached = chain.reach(end, chain.reach(start, np.zeros(len(chain.axes))).q)
    low, high = np.reshape(config.limits.reach_mm, (2, 3))
    trouble = ""
    if not reached:
        trouble = f"the axes stay {reached.off:.0f} mm, {np.degrees(reached.turned):.0f} deg away"
    elif (end[:3, 3] < low).any() or (end[:3, 3] > high).any():
        trouble = "it leaves reach_mm"
    return Motion(what, start, end, seconds, trouble)


def rehearsal_json(path: Path, motions: list[Motion]) -> dict[str, Any]:
    """What `--json` prints."""
    return {
        "command": "explore",
        "dry_run": True,
        "config": str(path),
        "motions": [
            {
                "what": m.what,
                "from_mm": np.round(m.start[:3, 3], 3).tolist(),
                "to_mm": np.round(m.end[:3, 3], 3).tolist(),
                "turn_deg": _turn(m),
                "seconds": m.seconds,
                "trouble": m.trouble,
            }
            for m in motions
        ],
        "possible": all(not m.trouble for m in motions),
    }


def print_rehearsal(motions: list[Motion], console: Console | None = None) -> None:
    """What a person reads."""
    console = console or Console(highlight=False)
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    for name in ("", "motion", "from [mm]", "to [mm]", "turn", "time", ""):
        table.add_column(name, justify="right" if name in ("", "turn", "time") else "left", no_wrap=True)
    for k, m in enumerate(motions, 1):
        places = (", ".join(f"{x + 0.0:.0f}" for x in pose[:3, 3].round()) for pose in (m.start, m.end))
        table.add_row(str(k), m.what, *places, f"{_turn(m):.0f} deg", f"{m.seconds:.1f} s", m.trouble)
    console.print(table)
    total, bad = sum(m.seconds for m in motions), sum(bool(m.trouble) for m in motions)
    console.print(
        f"{len(motions)} motions, {total:.0f} s if nothing is touched; the first contact ends the list"
    )
    console.print(f"{bad} of them the stage cannot make" if bad else "the stage can make all of them")


def _turn(motion: Motion) -> float:
    turned = se3.rotation_log(motion.end[:3, :3] @ motion.start[:3, :3].T)
    return float(np.degrees(np.linalg.norm(turned)))

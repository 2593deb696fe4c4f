"""`palpate hardware jog`: move the flange by hand, guarded: whatever is touched ends the motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from exploration.control.procedures.approach import advance
from exploration.devices.grbl_link import GrblLink
from exploration.devices.guard import Guard, GuardLimits, Observation
from exploration.devices.ports import Port
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.rig import open_rig

_HOMING, _UNLOCKING, _HELLO = 120.0, 2.0, 2.0  # [s] at most


def jog(path: Path, by: tuple[float, ...], home: bool, unlock: bool = False) -> dict[str, Any]:
    """Free it from an alarm and home it where asked, then move straight by (3,) [mm]."""
    config = load_device(path)
    if unlock:
        free(config)
    if home:
        _said(config, "$H", _HOMING, "homing failed; check the limit switches, and $22=1")
    rig = open_rig(config)
    try:
        limits = GuardLimits(config.limits.force_n, config.limits.depth_mm, config.limits.reach_mm)
        guard = Guard(rig.stage, [rig.array], [rig.calibration], limits)
        met = _moved(guard, np.array(by)) if any(by) else None
        where = guard.observe().world_from_sensor @ se3.inverse(rig.array.flange_from_sensor)
        ended = "arrived" if met is None else f"touched something, {met.force:.1f} N"
    finally:
        rig.close()
    return {"ended": ended, "position_mm": np.round(where[:3, 3], 3).tolist(), "touched": met is not None}


def _moved(guard: Guard, by: Floats) -> Observation | None:
    """Feel along the way, no faster than a touch allows; then to the goal itself."""
    goal = guard.world_from_sensor.copy()
    goal[:3, 3] += by
    length = float(np.linalg.norm(by))
    met = advance(guard, by / length, length, guard.stage.limits.speed)
    if met is None:
        guard.go_to(goal)
    return met


def free(config: DeviceConfig) -> None:
    """A soft reset, and out of an alarm; where the stage is, it may not know any more."""
    _said(config, "$X", _UNLOCKING, "the stage stays locked; its limit switches may be pressed", reset=True)


def _said(config: DeviceConfig, line: str, patience: float, trouble: str, reset: bool = False) -> None:
    """One line to the controller, answered with ok."""
    if config.stage is None:
        raise PalpateError(f"{config.path} has no table [stage]; add one")
    port = Port(config.stage.port, config.stage.baud)
    try:
        link = GrblLink(port, config.clock)
        if reset:
            link.realtime(b"\x18")
            until = config.clock.now() + _HELLO
            while config.clock.now() < until and not link.listen().reset:
                pass
        heard = link.exchange(line, patience)
    finally:
        port.close()
    if heard.errors or heard.alarm is not None:
        raise PalpateError(trouble)

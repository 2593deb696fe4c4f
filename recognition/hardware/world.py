"""The world of a run on devices: as a simulated one, but that nothing is known of the object."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np

from exploration.devices.guard import Guard, GuardLimits, Observation
from models.part import Part
from models.solid import Solid
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.rig import DeviceRig, open_rig, sensor_of
from recognition.simulation import World, WorldConfig


@dataclass
class WiredDevice:
    """Opens the devices when a run begins, closes them when it ends."""

    config: DeviceConfig
    rig: DeviceRig | None = None

    def guarded(self, observer: Callable[[Guard, Observation], None]) -> Guard:
        """The array on its stage, behind a guard."""
        self.rig = open_rig(self.config)
        told = self.config.limits
        limits = GuardLimits(told.force_n, told.depth_mm, told.reach_mm)
        guard = Guard(self.rig.stage, [self.rig.array], [self.rig.calibration], limits)
        guard.observers = (lambda seen: observer(guard, seen),)
        return guard

    def close(self) -> None:
        """Stop, back off, and let go of the ports."""
        if self.rig is not None:
            self.rig.close()


@dataclass(frozen=True)
class _Unknown:
    """What stands for the part: nobody knows it."""

    name: str
    warnings: tuple[str, ...] = ()
    csg: None = None
    solid: None = field(default=None)


def device_world(path: str, config: WorldConfig) -> World:
    """The set-up of a config file."""
    device = load_device(Path(path))
    name = Path(path).stem
    box = np.reshape(device.limits.workspace_mm, (2, 3))
    part = cast(Part, _Unknown(name))
    return World(part, cast(Solid, None), sensor_of(device), box, config, WiredDevice(device))

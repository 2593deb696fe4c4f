"""The world of a run on devices: as a simulated one, but that nothing is known of the object."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from exploration.devices.guard import Guard, GuardLimits, Observation
from exploration.sensing.spec import SensorSpec
from models.part import Part
from primitives.arrays import Floats
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.rig import DeviceRig, open_rig, sensor_of


@dataclass
class WiredDevice:
    """Opens the devices when a run begins, closes them when it ends."""

    config: DeviceConfig
    rig: DeviceRig | None = None

    @property
    def spec(self) -> SensorSpec:
        """The array's data sheet."""
        return sensor_of(self.config)

    @property
    def box(self) -> Floats:
        """(2, 3) the workspace [mm]."""
        return np.reshape(self.config.limits.workspace_mm, (2, 3))

    @property
    def part(self) -> Part:
        """What stands for the part, which nobody knows."""
        return cast(Part, _Unknown(self.config.path.stem, self))

    @property
    def remarks(self) -> tuple[str, ...]:
        """What did not go well on the wires."""
        return self.rig.remarks if self.rig is not None else ()

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
    device: WiredDevice
    csg: None = None
    solid: None = None

    @property
    def warnings(self) -> tuple[str, ...]:
        """Those of the devices that touch it."""
        return self.device.remarks


def wired(path: str) -> WiredDevice:
    """The set-up of a config file; nothing is opened yet."""
    return WiredDevice(load_device(Path(path)))

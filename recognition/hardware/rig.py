"""Devices opened from a config: an array, a stage, and the safety below both."""

from __future__ import annotations

import atexit
import contextlib
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exploration.devices.clock import Clock
from exploration.devices.grbl_link import GrblLink
from exploration.devices.grbl_stage import GrblStage
from exploration.devices.ports import Port
from exploration.devices.protocols import StageLimits
from exploration.devices.safety import Safety, SafetyLimits
from exploration.devices.serial_array import SerialArray
from exploration.devices.watched_stage import WatchedStage
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import SensorSpec, load_sensor
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.hardware.config import DeviceConfig, StageConfig, baud
from recognition.hardware.driver import driven
from recognition.hardware.saved_calibration import load

_CONTACT = 0.05  # of the force limit, above which letting go begins with backing off
_BACK, _BACKING = 5.0, 4.0  # [mm], and [s] at most
_NO_STAGE = "{}: without a table [stage] only palpate frames works; add one"
_SURE = 0.8  # of the force at which all taxels read full scale, beyond which none can be told
_SWITCH = 0.0005  # [s] that the loop may keep the interpreter from the threads that watch over it


@dataclass
class DeviceRig:
    """What a run drives; `close` whatever happened."""

    array: SerialArray
    stage: GrblStage | WatchedStage
    safety: Safety
    calibration: Calibration
    clock: Clock

    def close(self) -> None:
        """Back off where something is touched and frames still come, else hold; then let go of both ports."""
        with contextlib.suppress(Exception):
            self.stage.stop()
            self._back_off()
        with contextlib.suppress(Exception):
            self.stage.close()
        with contextlib.suppress(Exception):
            self.array.close()
        atexit.unregister(self.close)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What did not go well on the wires, in lines for whoever reads the summary."""
        held = f"the stage was held {self.safety.holds} times for want of frames" * bool(self.safety.holds)
        again = getattr(self.stage, "reconnects", 0)
        gone = f"the stage's port had gone, and came again, {again} times" * bool(again)
        return tuple(line for line in (self.array.counts.remark, held, gone) if line)

    def _back_off(self) -> None:
        pressed = self.safety.force(self.array.read()) > _CONTACT * self.safety.limits.force
        if self.stage.fault or not pressed:
            return
        mount = self.array.flange_from_sensor
        sensor = self.stage.pose() @ mount @ se3.pose(None, [0.0, 0.0, -_BACK])
        self.stage.go_to(sensor @ se3.inverse(mount))
        until = self.clock.now() + _BACKING
        while self.stage.moving and self.clock.now() < until:
            self.array.read()


def sensor_of(config: DeviceConfig) -> SensorSpec:
    """The array's data sheet."""
    return load_sensor(config.array.sensor)


def calibration_of(config: DeviceConfig, spec: SensorSpec) -> tuple[Calibration, Floats]:
    """The array's own calibration, or the data sheet's; and (4, 4) where the array sits on the flange."""
    told = config.array.flange_from_sensor
    if not config.array.calibration:
        return Calibration.nominal(spec), told
    calibration, mount = load(config.path.parent / Path(config.array.calibration))
    if calibration.zero.shape != spec.array.shape:
        raise PalpateError(
            f"{config.array.calibration} is of another array than {spec.name}; calibrate again"
        )
    return calibration, told if mount is None else mount


def open_array(config: DeviceConfig) -> SerialArray:
    """The array alone, listening."""
    spec = sensor_of(config)
    _, mount = calibration_of(config, spec)
    port = Port(config.array.port, baud(config.array))
    array = SerialArray(port, config.array.protocol, spec.array, spec.period, mount, config.clock)
    array.start()
    return array


def stage_limits(config: DeviceConfig) -> StageLimits:
    """What the stage may do."""
    told = config.stage
    if told is None:
        raise PalpateError(_NO_STAGE.format(config.path))
    turning = told.acceleration_mm_s2 / 50.0
    return StageLimits(
        told.speed_mm_s, told.acceleration_mm_s2, float(np.radians(told.turn_speed_deg_s)), turning
    )


def _stage(config: DeviceConfig, told: StageConfig, safety: Safety) -> GrblStage | WatchedStage:
    """On a Grbl controller, or with a driver of one's own."""
    if told.driver:
        return WatchedStage(driven(config.path, told), safety, config.clock)
    link = GrblLink(Port(told.port, told.baud), config.clock)
    return GrblStage(link, told.chain, stage_limits(config), safety, crash_pin=told.crash_pin)


def open_rig(config: DeviceConfig) -> DeviceRig:
    """Array and stage, listening and guarded; nothing moves."""
    if config.stage is None:
        raise PalpateError(_NO_STAGE.format(config.path))
    spec = sensor_of(config)
    calibration, mount = calibration_of(config, spec)
    area = spec.array.pitch[0] * spec.array.pitch[1]
    felt = _SURE * float((area * (calibration.full_scale - calibration.zero) / calibration.gain).sum())
    limits = SafetyLimits(min(config.limits.force_n, felt), config.limits.reach_mm)
    safety = Safety(calibration, area, spec.period, limits, mount, config.clock)
    array = open_array(config)
    array.watch, array.gone = safety.seen, safety.lost
    try:
        array.read()
        stage = _stage(config, config.stage, safety)
    except PalpateError:
        array.close()
        raise
    sys.setswitchinterval(_SWITCH)
    array.before = lambda frame: stage.as_of(frame.time)
    array.fault = lambda: stage.fault or safety.frozen
    stage.start()
    rig = DeviceRig(array, stage, safety, calibration, config.clock)
    atexit.register(rig.close)
    return rig

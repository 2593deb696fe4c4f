"""A set-up's TOML file: where the array and the stage are plugged in, what they are, and their limits."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from exploration.devices.clock import MACHINE, Clock, ReadClock
from exploration.devices.kinematic_chain import Axis, KinematicChain
from exploration.devices.serial_array import BAUDS, PROTOCOLS
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.hardware.artifact import Artifact

_TABLES = ("array", "stage", "limits", "artifact", "emulation")


@dataclass(frozen=True)
class ArrayConfig:
    """`[array]`."""

    port: str
    protocol: str
    sensor: str = "lts210"
    baud: int = 0  # 0: the protocol's own
    calibration: str = ""  # a file of `palpate hardware calibrate`; without one the data sheet's
    translation_mm: tuple[float, ...] = (0.0, 0.0, 0.0)  # flange_from_sensor
    quaternion_wxyz: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)

    @property
    def flange_from_sensor(self) -> Floats:
        """(4, 4)."""
        return se3.from_quaternion(list(self.quaternion_wxyz), list(self.translation_mm))


@dataclass(frozen=True)
class StageConfig:
    """`[stage]`."""

    port: str = ""
    driver: str = ""  # FILE.py:CLASS of a stage of one's own; empty: a Grbl controller
    baud: int = 115200
    axes: str | tuple[Mapping[str, Any], ...] = "XYZABC"  # a gantry's letters, or one table an axis
    speed_mm_s: float = 60.0
    acceleration_mm_s2: float = 500.0
    turn_speed_deg_s: float = 60.0
    crash_pin: str = ""  # the pin of a status report that a breakaway switch sits on

    @property
    def chain(self) -> KinematicChain:
        """The kinematics."""
        if isinstance(self.axes, str):
            turning = float(np.radians(self.turn_speed_deg_s))
            return KinematicChain.gantry(self.axes, speed=self.speed_mm_s, turn_speed=turning)
        return KinematicChain([_axis(told) for told in self.axes], se3.pose(np.diag([1.0, -1.0, -1.0])))


@dataclass(frozen=True)
class LimitConfig:
    """`[limits]`."""

    force_n: float = 60.0
    depth_mm: float = 1.6
    reach_mm: tuple[float, ...] = (-650.0, -650.0, -650.0, 650.0, 650.0, 650.0)  # of the flange
    workspace_mm: tuple[float, ...] = (-60.0, -60.0, -60.0, 60.0, 60.0, 60.0)  # where the object may be


@dataclass(frozen=True)
class EmulationConfig:
    """`[emulation]`, which an emulator writes."""

    clock: str = ""  # the file of its clock


@dataclass(frozen=True)
class DeviceConfig:
    """A whole set-up; without a stage it can show frames and nothing else."""

    path: Path
    array: ArrayConfig
    stage: StageConfig | None
    limits: LimitConfig
    artifact: Artifact | None = None  # what to calibrate on, where the stage finds it
    clock: Clock = MACHINE


def load_device(path: Path) -> DeviceConfig:
    """A set-up from its file."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(f"cannot read {path}; palpate hardware scan --out {path} writes one") from error
    except tomllib.TOMLDecodeError as error:
        raise PalpateError(f"{path} is not valid TOML: {error}") from error
    for name in table:
        if name not in _TABLES:
            raise PalpateError(f"{path}: unknown table [{name}]; there are {', '.join(_TABLES)}")
    if "array" not in table:
        raise PalpateError(f"{path}: the table [array] is missing, with port and protocol")
    array = _build(ArrayConfig, table["array"], path, "array")
    if array.protocol not in PROTOCOLS:
        raise PalpateError(f"{path}: no protocol {array.protocol!r}; there are {', '.join(PROTOCOLS)}")
    stage = _build(StageConfig, table["stage"], path, "stage") if "stage" in table else None
    if stage is not None and not (stage.port or stage.driver):
        raise PalpateError(
            f"{path} [stage]: give the port of a Grbl controller, or the driver of another stage"
        )
    limits = _build(LimitConfig, table.get("limits", {}), path, "limits")
    for name in ("reach_mm", "workspace_mm"):
        box = getattr(limits, name)
        if len(box) != 6 or not all(a < b for a, b in zip(box[:3], box[3:], strict=True)):
            raise PalpateError(f"{path} [limits]: {name} is X0,Y0,Z0,X1,Y1,Z1, the least corner first")
    if min(limits.force_n, limits.depth_mm) <= 0.0:
        raise PalpateError(f"{path} [limits]: force_n and depth_mm must be positive")
    emulation = _build(EmulationConfig, table.get("emulation", {}), path, "emulation")
    clock = ReadClock(Path(emulation.clock)) if emulation.clock else MACHINE
    artifact = Artifact.of(table["artifact"], f"{path} [artifact]") if "artifact" in table else None
    return DeviceConfig(path, array, stage, limits, artifact, clock)


def baud(config: ArrayConfig) -> int:
    """Of the array's port."""
    return config.baud or BAUDS[config.protocol]


def _build(kind: type[Any], table: Any, path: Path, name: str) -> Any:
    valid = {f.name: f for f in fields(kind)}
    for key, value in dict(table).items():
        if key not in valid:
            raise PalpateError(f"{path} [{name}]: unknown key {key!r}; valid keys: {', '.join(valid)}")
        numeric = valid[key].type in ("float", "int")
        if numeric and (isinstance(value, bool) or not isinstance(value, int | float)):
            raise PalpateError(f"{path} [{name}]: {key} must be a number, not {value!r}")
        if valid[key].type == "str" and not isinstance(value, str):
            raise PalpateError(f"{path} [{name}]: {key} must be text, not {value!r}")
    try:
        return kind(**{k: tuple(v) if isinstance(v, list) else v for k, v in dict(table).items()})
    except TypeError as error:
        raise PalpateError(f"{path} [{name}]: {str(error).split('__init__() ')[-1]}") from error


def _axis(told: Mapping[str, Any]) -> Axis:
    """One axis; a turning one's limits and speed are in degrees."""
    try:
        scale = np.pi / 180.0 if told.get("turns") else 1.0
        return Axis(
            told["letter"],
            bool(told.get("turns", False)),
            tuple(told["direction"]),
            scale * told.get("least", -1e6),
            scale * told.get("most", 1e6),
            scale * told.get("speed", 100.0),
            tuple(told.get("offset_mm", (0.0, 0.0, 0.0))),
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise PalpateError(f"[stage] axes: each needs letter, turns and direction ({error})") from error

"""The settings of a run: checked once, saved beside the result as `config.toml`.

Inside, lengths are mm and names carry no unit; in the file and on the command line the same settings are
called `feature_mm`, `pose_noise_mm`, and so on.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import from_quaternion
from primitives.toml_text import toml_lines

POLICIES = ("closure", "grid", "random", "raster")
SUPPORTS = ("none", "table")
UNITS = ("auto", "mm", "cm", "m", "in")
Pose = str | tuple[float, ...]  # "random", "as-is", or (x, y, z [mm], qw, qx, qy, qz)
_EDGE_NAMES = {"workspace": "workspace_mm", "feature": "feature_mm", "pose_noise": "pose_noise_mm"}
_NOT_SETTINGS = ("out", "overwrite")  # where a result goes is no part of what it is


@dataclass(frozen=True)
class ExploreOptions:
    """Everything `palpate explore` can be told."""

    part: str
    units: str = "auto"
    scale: float = 1.0
    body: int | None = None  # of a file that holds several, from 1
    facets: bool = False  # whether OpenSCAD's circles keep their flat sides
    workspace: tuple[float, ...] = (
        -300.0,
        -300.0,
        -300.0,
        300.0,
        300.0,
        300.0,
    )  # least, greatest corner [mm]
    feature: float = 10.0  # [mm] the smallest feature that must not be missed
    pose: Pose = "random"
    sensors: tuple[str, ...] = ("lts210", "fingertip")
    noise: float | None = None  # 1 sigma over the full-contact signal; None: as the sensor's preset says
    pose_noise: float = 0.0  # [mm] 1 sigma of the stage's reported position
    support: str = "none"  # or "table", on which the part then lies
    cover: str | None = None  # a CAD file of another body in the way, in the part's own coordinates
    seed: int = 0
    max_touches: int = 500
    max_minutes: float = 30.0  # of the stage
    policies: ClassVar[tuple[str, ...]] = POLICIES
    policy: str = "closure"  # how exploration chooses what it touches
    out: Path | None = None  # None: a new folder below runs/
    overwrite: bool = False
    device: str | None = None  # a set-up's TOML file, in the simulated part's place

    def __post_init__(self) -> None:
        _require(self.units in UNITS, f"--units {self.units!r} is not one of {', '.join(UNITS)}")
        _require(_positive(self.scale), f"--scale must be a positive number, not {self.scale}")
        _require(self.body is None or self.body >= 1, f"--body counts from 1, so {self.body} is none")
        _require(
            len(self.workspace) == 6 and all(map(math.isfinite, self.workspace)),
            "--workspace needs six numbers X0,Y0,Z0,X1,Y1,Z1 in mm",
        )
        low, high = self.workspace[:3], self.workspace[3:]
        _require(
            all(a < b for a, b in zip(low, high, strict=True)),
            "--workspace needs its least corner before its greatest: X0<X1, Y0<Y1, Z0<Z1",
        )
        _require(_positive(self.feature), f"--feature-mm must be a positive number, not {self.feature}")
        _require(
            bool(self.sensors) and all(name.strip() for name in self.sensors),
            "--sensor needs a name; palpate sensors lists them",
        )
        _require(
            self.noise is None or 0.0 <= self.noise < 1.0,
            f"--noise must be a fraction from 0 to below 1 of the full-contact signal, not {self.noise}; "
            "5 percent is 0.05",
        )
        _require(
            math.isfinite(self.pose_noise) and self.pose_noise >= 0,
            f"--pose-noise-mm must be 0 or more, not {self.pose_noise}",
        )
        _require(self.support in SUPPORTS, f"--support {self.support!r} is not one of {', '.join(SUPPORTS)}")
        _require(self.seed >= 0, f"--seed must be 0 or more, not {self.seed}")
        _require(
            self.policy in self.policies, f"--policy {self.policy!r} is not one of {', '.join(self.policies)}"
        )
        _require(self.max_touches >= 1, f"--max-touches must be 1 or more, not {self.max_touches}")
        _require(
            _positive(self.max_minutes), f"--max-minutes must be a positive number, not {self.max_minutes}"
        )

    @property
    def fixed_pose(self) -> Floats | None:
        """(4, 4) world_from_part, or None where the pose is to be drawn at random."""
        if self.pose == "random":
            return None
        if self.pose == "as-is":
            return np.eye(4)
        numbers = np.asarray(self.pose, dtype=float)
        return from_quaternion(numbers[3:], numbers[:3])


def parse_pose(text: str) -> Pose:
    """`random`, `as-is`, or the seven numbers X,Y,Z,QW,QX,QY,QZ."""
    if text in ("random", "as-is"):
        return text
    numbers = parse_numbers(text, 7, "--pose", "random, as-is or X,Y,Z,QW,QX,QY,QZ")
    _require(
        math.hypot(*numbers[3:]) > 1e-6,
        "--pose needs a quaternion QW,QX,QY,QZ that is not zero; none is 1,0,0,0",
    )
    return numbers


def parse_numbers(text: str, count: int, flag: str, form: str) -> tuple[float, ...]:
    """`count` finite numbers with commas between them."""
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    _require(len(numbers) == count and all(map(math.isfinite, numbers)), f"{flag} {text!r} is not {form}")
    return numbers


def to_toml(
    options: ExploreOptions,
    version: str,
    resolved: Mapping[str, object] | None = None,
    command: str = "explore",
) -> str:
    """`config.toml`: the settings, and under `[resolved]` what they came to (sensor presets, drawn poses)."""
    head = toml_lines({"version": version, "command": command})
    lines = [*head, "", "[settings]", *toml_lines(settings(options))]
    if resolved:
        lines += ["", "[resolved]", *toml_lines(resolved)]
    return "\n".join(lines) + "\n"


def settings(options: ExploreOptions) -> dict[str, object]:
    """The settings under the names that they have in files."""
    return {
        _EDGE_NAMES.get(field.name, field.name): getattr(options, field.name)
        for field in fields(options)
        if field.name not in _NOT_SETTINGS
    }


def from_toml(path: Path) -> ExploreOptions:
    """The settings of a saved run."""
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8"))["settings"]
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, KeyError) as error:
        raise PalpateError(f"{path} is not the config.toml of a run: {_first_line(error)}") from error
    names = {_EDGE_NAMES.get(field.name, field.name): field.name for field in fields(ExploreOptions)}
    unknown = sorted(set(told) - set(names))
    _require(not unknown, f"{path} has the unknown setting {', '.join(unknown)}; remove it")
    try:
        arguments: dict[str, Any] = {names[key]: _tuples(value) for key, value in told.items()}
        return ExploreOptions(**arguments)
    except TypeError as error:
        raise PalpateError(f"{path} is not the config.toml of a run: {_first_line(error)}") from error


def _tuples(value: object) -> object:
    return tuple(value) if isinstance(value, list) else value


def _positive(value: float) -> bool:
    return math.isfinite(value) and value > 0


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def _require(holds: bool, message: str) -> None:
    if not holds:
        raise PalpateError(message)

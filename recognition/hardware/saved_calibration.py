"""A calibration's file: the array's own numbers, and in `[mount]` where it sits on its flange."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np

from exploration.sensing.calibrating.mount import Mount
from exploration.sensing.calibration import Calibration
from exploration.sensing.calibration_toml import calibration_from_table, calibration_to_toml
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.toml_text import toml_lines


def save(calibration: Calibration, mount: Mount | None, path: Path) -> None:
    """Write it, whole or not at all."""
    text = calibration_to_toml(calibration)
    if mount is not None:
        table = {
            "translation_mm": mount.flange_from_sensor[:3, 3],
            "quaternion_wxyz": se3.quaternion_wxyz(mount.flange_from_sensor),
            "translation_sigma_mm": mount.translation_sigma,
            "rotation_sigma_deg": float(np.degrees(mount.rotation_sigma)),
        }
        text += "\n".join(["", "[mount]", *toml_lines(table)]) + "\n"
    _write(path, text)


def load(path: Path) -> tuple[Calibration, Floats | None]:
    """The calibration, and (4, 4) flange_from_sensor where the file tells it."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(f"cannot read calibration {path}; palpate hardware calibrate makes one") from error
    except tomllib.TOMLDecodeError as error:
        raise PalpateError(f"{path}: not valid TOML: {error}") from error
    mount = table.pop("mount", None)
    calibration = calibration_from_table(table, str(path))
    if mount is None:
        return calibration, None
    try:
        return calibration, se3.from_quaternion(mount["quaternion_wxyz"], mount["translation_mm"])
    except (KeyError, TypeError, ValueError) as error:
        raise PalpateError(f"{path} [mount]: needs translation_mm and quaternion_wxyz") from error


def told_in(config: Path, calibration: Path) -> None:
    """Name the calibration in a set-up's file, in place of the one named before."""
    text = config.read_text(encoding="utf-8")
    line = f'calibration = "{calibration.resolve()}"'
    if calibration.resolve().parent == config.resolve().parent:
        line = f'calibration = "{calibration.name}"'
    changed, count = re.subn(r"(?m)^calibration\s*=.*$", lambda _: line, text)
    if not count:
        changed = re.sub(r"(?m)^\[array\].*$", lambda head: f"{head[0]}\n{line}", text, count=1)
    _write(config, changed)


def _write(path: Path, text: str) -> None:
    partial = path.with_suffix(".partial")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    except OSError as error:
        raise PalpateError(
            f"cannot write {path} ({error.strerror or error}); choose another --out"
        ) from error

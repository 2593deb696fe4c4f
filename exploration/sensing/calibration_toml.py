"""A calibration as a TOML file: numbers and rows of numbers, readable and complete.

The curve is written as the gap of its plates or as its points, a response of the array's own as its line spread.
"""

import tomllib
from dataclasses import fields
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from exploration.sensing.calibration import Calibration
from exploration.sensing.curve import STRAIGHT, Curve, ParallelPlates, Sampled
from exploration.sensing.response import CELLS, Response
from primitives.arrays import frozen
from primitives.errors import PalpateError
from primitives.toml_text import toml_lines

_MAPS = ("zero", "gain")
_NUMBERS = (
    "spread",
    "stiffness",
    "noise",
    "margin",
    "spread_sigma",
    "stiffness_sigma",
    "full_scale",
    "threshold",
)
_POSITIVE = ("stiffness", "noise")


def calibration_to_toml(calibration: Calibration) -> str:
    """The text of a file; infinite numbers and what is not there are left out."""
    numbers = {name: float(getattr(calibration, name)) for name in _NUMBERS}
    table = {name: value for name, value in numbers.items() if isfinite(value)}
    lines = toml_lines(table)
    curve = calibration.curve
    if isinstance(curve, Sampled):
        lines += toml_lines({"curve": {"signals": curve.signals, "depths": curve.depths}})
    elif isinstance(curve, ParallelPlates) and isfinite(curve.gap):
        lines += toml_lines({"curve": {"gap": curve.gap}})
    if calibration.response is not None:
        told = calibration.response
        lines += toml_lines({"response": {"variance": told.variance, "line": told.table[:, 0]}})
    gain_sigma = np.asarray(calibration.gain_sigma)
    lines += toml_lines({name: getattr(calibration, name) for name in _MAPS})
    lines += toml_lines({"gain_sigma": gain_sigma, "dead": calibration.dead})
    return "\n".join(lines) + "\n"


def calibration_from_toml(source: str, name: str = "calibration") -> Calibration:
    """A calibration from a file's text."""
    try:
        table = tomllib.loads(source)
    except tomllib.TOMLDecodeError as error:
        raise PalpateError(f"{name}: not valid TOML: {error}") from error
    return calibration_from_table(table, name)


def calibration_from_table(table: dict[str, Any], name: str = "calibration") -> Calibration:
    """A calibration from a file's table."""
    valid = {field.name for field in fields(Calibration)}
    for key in table:
        if key not in valid:
            raise PalpateError(f"{name}: unknown key {key!r}; valid keys: {', '.join(sorted(valid))}")
    missing = [key for key in ("zero", "gain", "dead", "spread", "stiffness", "noise") if key not in table]
    if missing:
        raise PalpateError(f"{name}: missing {', '.join(missing)}")
    try:
        return _build(table)
    except (TypeError, ValueError, KeyError) as error:
        raise PalpateError(f"{name}: a value is not what it must be: {error}") from error


def load_calibration(path: Path) -> Calibration:
    """A calibration from a file."""
    try:
        return calibration_from_toml(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise PalpateError(f"cannot read calibration {path}: {error}") from error


def _build(table: dict[str, Any]) -> Calibration:
    zero = np.array(table["zero"], dtype=float)
    numbers = {key: float(table[key]) for key in _NUMBERS if key in table}
    for key in _POSITIVE:
        if not numbers[key] > 0:
            raise ValueError(f"{key} must be positive")
    maps = {key: np.array(table[key], dtype=float) for key in _MAPS}
    sigma = np.array(table.get("gain_sigma", 0.0), dtype=float)
    dead = np.array(table["dead"], dtype=np.bool_)
    if zero.ndim != 2 or any(m.shape != zero.shape for m in (*maps.values(), dead)):
        raise ValueError("zero, gain and dead must be rows of one shape")
    if sigma.shape not in ((), zero.shape) or not all(np.isfinite(m).all() for m in (*maps.values(), sigma)):
        raise ValueError("gain_sigma must be one number or a map, and all of them finite")
    if not (maps["gain"] > 0).all():
        raise ValueError("gains must be positive; a dead taxel may have any")
    rest: dict[str, Any] = {**numbers, **{key: frozen(m) for key, m in maps.items()}}
    return Calibration(
        dead=frozen(dead, np.bool_),
        gain_sigma=float(sigma) if sigma.ndim == 0 else frozen(sigma),
        curve=_curve(table.get("curve")),
        response=_response(table.get("response")),
        **rest,
    )


def _curve(table: dict[str, Any] | None) -> Curve:
    if table is None:
        return STRAIGHT
    if "gap" in table:
        return ParallelPlates(float(table["gap"]))
    return Sampled.of(table["signals"], table["depths"])


def _response(table: dict[str, Any] | None) -> Response | None:
    if table is None:
        return None
    line = np.array(table["line"], dtype=float)
    if line.shape != (CELLS + 1,):
        raise ValueError(f"response.line must be {CELLS + 1} numbers")
    return Response.of_line_spread(line, np.array(table["variance"], dtype=float))

"""What an environment may be asked for, checked when it is made: each mistake is one line that names the fix."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from exploration.sensing.spec import load_sensor
from models import parts
from models.formats.intake import looks_like_a_file, require_file
from models.library import Library
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.builtin import part_library


def part_names(part: str | Sequence[str]) -> list[str]:
    """Built-in parts and files, all of which there are; `@all` stands for every built-in part."""
    wanted = list(parts.names()) if part == "@all" else [part] if isinstance(part, str) else list(part)
    if not wanted:
        raise PalpateError("part is an empty list; name a built-in part, a file, or @all")
    for name in wanted:
        _require_part(name)
    return wanted


def library_of(library: str | Path | Sequence[str]) -> Library:
    """A folder of CAD files, as of `palpate identify --library`, or built-in parts by name."""
    if isinstance(library, str | Path):
        opened = Library.open(library)
    else:
        for name in library:
            if name not in parts.names():
                raise PalpateError(f"library: {parts.unknown(str(name))}")
        opened = part_library(library)
    if len(opened) < 2:
        raise PalpateError("a library of fewer than two parts leaves nothing to identify")
    return opened


def require_touching(sensor: str, noise: float | None, max_touches: int) -> None:
    """What every environment is told of the array and of how often it touches."""
    load_sensor(sensor)
    if noise is not None:
        require_between("noise", noise, 0.0)
    if isinstance(max_touches, bool) or not isinstance(max_touches, int | np.integer) or max_touches < 1:
        raise PalpateError(f"max_touches must be a whole number of 1 or more, not {max_touches!r}")


def require_between(name: str, value: float, least: float, most: float = math.inf) -> None:
    """Refuse what is no finite number within bounds."""
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not (number and math.isfinite(value) and least <= value <= most):
        bounds = f"of {least:g} or more" if most == math.inf else f"from {least:g} to {most:g}"
        raise PalpateError(f"{name} must be a number {bounds}, not {value!r}")


def require_no_rendering(render_mode: str | None) -> None:
    """Gymnasium's convention has the argument; there is nothing to render."""
    if render_mode is not None:
        raise PalpateError(
            f"render_mode {render_mode!r} is not to be had; leave it out (palpate replay shows recorded runs)"
        )


def checked_action(action: object, size: int) -> Floats:
    """(size,) finite numbers."""
    try:
        told = np.asarray(action, dtype=float)
    except (TypeError, ValueError):
        told = np.empty(0)
    if told.shape != (size,) or not np.isfinite(told).all():
        raise PalpateError(f"an action is {size} finite numbers from -1 to 1, not {_short(action)}")
    return told


def _require_part(name: object) -> None:
    if name in parts.names():
        return
    text = str(name)
    if not looks_like_a_file(text):
        raise PalpateError(f"part: {parts.unknown(text)}")
    require_file(Path(text))


def _short(value: object) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 80 else text[:79] + "…"

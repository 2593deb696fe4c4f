"""Units of length, and what size a part may have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError

Units = Literal["auto", "mm", "cm", "m", "in"]
MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}


@dataclass(frozen=True)
class SizeLimits:
    """What a part may measure along its longest side."""

    least: float = 1.0  # [mm]
    small: float = 10.0  # [mm] warned about below
    large: float = 1000.0  # [mm] warned about above
    most: float = 10_000.0  # [mm]


def checked_flags(units: str, scale: float) -> None:
    """Refuse what is no unit and no factor."""
    if units not in get_args(Units):
        raise PalpateError(f"no unit {units!r}; use one of {', '.join(get_args(Units))}")
    if not (np.isfinite(scale) and scale > 0):
        raise PalpateError(f"the scale must be a positive number, not {scale}")


def size_warnings(
    vertices: Floats, name: str, guessed: bool, limits: SizeLimits | None = None
) -> tuple[str, ...]:
    """What to say of a part's size [mm]; `guessed` where neither the file nor the user gave a unit."""
    bounds = limits or SizeLimits()
    size = float(np.ptp(vertices, axis=0).max())
    fits = [u for u, f in MM.items() if bounds.small <= size * f <= bounds.large]
    hint = f"give its unit, for example --units {fits[-1]}" if fits else "give --units or --scale"
    if size < bounds.least:
        raise PalpateError(f"{name} is {size:.4g} mm across, less than {bounds.least:g} mm; {hint}")
    if size > bounds.most:
        thousandths = int(np.ceil(np.log10(size / bounds.large) / 3)) if np.isfinite(size) else 1
        raise PalpateError(
            f"{name} is {size:.4g} mm across, more than 10 m; "
            f"give --units or --scale, for example --scale {1e-3**thousandths:g}"
        )
    if bounds.small <= size <= bounds.large:
        return ()
    if guessed:
        return (f"{name} is {size:.4g} mm across if it is in mm; if not, {hint}",)
    return ()

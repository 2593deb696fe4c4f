"""Which array a stack of bare numbers came from: what `--sensor` says, or else what the shape allows.

A stack is (frames, rows, columns), (frames, pads, rows, columns), one frame (rows, columns), or one frame a line,
(frames, rows * columns).  Without a sensor the last is read only where the count is that of a built-in array; an
array of which nothing but the shape is known gets a pitch of 1, so its lengths are in taxels.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.recordings.recording import Pad
from exploration.sensing.frame import TaxelArray
from exploration.sensing.spec import SensorSpec, load_sensor, sensor_names
from primitives.arrays import frozen
from primitives.errors import PalpateError

MOST_ON_A_SIDE = 1024  # [taxels]
MOST_PADS = 64
_LONGEST_GUESS = 64  # [taxels] a side of the largest single matrix taken for a frame
_SQUAREST = 3.0  # a single matrix longer than this many times its width is not taken for a frame


@dataclass(frozen=True)
class Layout:
    """How a stack's numbers make frames."""

    frames: int
    pads: tuple[Pad, ...]
    assumed: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """(frames, pads, rows, columns)."""
        return self.frames, len(self.pads), *self.pads[0].array.shape


def layout_of(
    where: str, shape: Sequence[int], spec: SensorSpec | None, full_scale: float = np.inf
) -> Layout:
    """The layout of a stack of this shape; `where` begins the message when there is none."""
    if 0 in shape or not 1 <= len(shape) <= 4:
        raise PalpateError(f"{where} has shape {_times(shape)}: no frames; give (frames, rows, columns)")
    counts = _as_stack(shape, spec)
    if counts is None:
        raise PalpateError(f"{where} has shape {_times(shape)}, {_misfit(shape, spec)}")
    frames, pads, rows, columns = counts
    if max(rows, columns) > MOST_ON_A_SIDE or pads > MOST_PADS:
        raise PalpateError(
            f"{where} has shape {_times(shape)}; at most {MOST_PADS} pads of {MOST_ON_A_SIDE} x "
            f"{MOST_ON_A_SIDE} taxels are read: give (frames, rows, columns)"
        )
    return Layout(
        frames,
        tuple(_pad(rows, columns, spec, full_scale, i if pads > 1 else None) for i in range(pads)),
        (f"read as {frames} x {rows} x {columns}: one frame a line",)
        if len(shape) == 2 and spec is None and (rows, columns) != tuple(shape)
        else (),
    )


def plain_warnings(pads: Sequence[Pad], timed: bool, posed: bool) -> tuple[str, ...]:
    """What was assumed of bare numbers."""
    told = []
    if pads[0].assumed_pitch:
        names = presets_with(pads[0].array.shape)
        hint = f"--sensor {names[0]}" if names else "--sensor FILE.toml"
        told.append(
            f"pitch unknown: 1 taxel counts as 1 mm; rubber and gain unknown: no force and no curvature "
            f"({hint} gives them)"
        )
    if not timed:
        told.append("no times in the recording")
    if not posed:
        told.append("no poses in the recording: frames only")
    return tuple(told)


def presets_with(shape: tuple[int, int]) -> list[str]:
    """Built-in arrays of this shape."""
    return [name for name in sensor_names() if load_sensor(name).array.shape == shape]


def preset_shapes(count: int) -> list[tuple[int, int]]:
    """Shapes of built-in arrays with so many taxels."""
    shapes = {load_sensor(name).array.shape for name in sensor_names()}
    return sorted(shape for shape in shapes if shape[0] * shape[1] == count)


def _as_stack(shape: Sequence[int], spec: SensorSpec | None) -> tuple[int, int, int, int] | None:
    rows, columns = spec.array.shape if spec else (0, 0)
    if len(shape) >= 3:
        fits = spec is None or tuple(shape[-2:]) == (rows, columns)
        pads = shape[1] if len(shape) == 4 else 1
        return (shape[0], pads, shape[-2], shape[-1]) if fits else None
    if spec is not None:
        if tuple(shape) == (rows, columns):
            return 1, 1, rows, columns
        flat = shape[-1] == rows * columns
        return (shape[0] if len(shape) == 2 else 1, 1, rows, columns) if flat else None
    return _guessed(shape)


def _guessed(shape: Sequence[int]) -> tuple[int, int, int, int] | None:
    flat = preset_shapes(shape[-1])
    if len(shape) == 2:
        low, high = sorted(shape)
        if presets_with((shape[0], shape[1])) or (low > 1 and high <= min(_SQUAREST * low, _LONGEST_GUESS)):
            return 1, 1, shape[0], shape[1]
    return (shape[0] if len(shape) == 2 else 1, 1, *flat[0]) if flat else None


def _misfit(shape: Sequence[int], spec: SensorSpec | None) -> str:
    if spec is None:
        return "which fits no built-in array a line; say which it is: --sensor NAME or FILE.toml (palpate sensors)"
    rows, columns = spec.array.shape
    if tuple(shape[-2:]) == (columns, rows):
        return f"but {spec.name} is {rows} x {columns} (rows along y): transpose the frames"
    names = presets_with((shape[-2], shape[-1])) if len(shape) > 1 else []
    ways = f"--sensor {' or '.join(names)}, " if names else ""
    size = f"rows = {shape[-2]} and columns = {shape[-1]}" if len(shape) > 1 else "its rows and columns"
    return f"but {spec.name} is {rows} x {columns}; give {ways}a FILE.toml with {size}, or leave --sensor out"


def _pad(rows: int, columns: int, spec: SensorSpec | None, full_scale: float, index: int | None) -> Pad:
    absent = frozen(np.zeros((rows, columns)), np.bool_)
    name = spec.name if spec else f"{rows}x{columns}"
    label = name if index is None else f"{name}-{index}"
    if spec is not None:
        pitch = spec.array.pitch
        return Pad(TaxelArray(label, rows, columns, pitch), absent, spec, None, spec.electronics.full_scale)
    plain = TaxelArray(label, rows, columns, (1.0, 1.0))
    return Pad(plain, absent, None, None, full_scale, assumed_pitch=True)


def _times(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape)) or "()"

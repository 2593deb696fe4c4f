"""`.dsa`: what the software of Weiss's DSA arrays records; bzip2-compressed XML, read as it inflates.

`sensor` lists the matrices: cells, pitch, static mask, full scale.  `data/frame` has a time stamp in ms and
`frame_data`: big-endian float32 written as hex, matrix after matrix in rows of `cells_x`, where a negative
value -n stands for n zeros.  `joint_angles/angle` has the hand's joints in degrees, on the same clock.  What is
below the controller's threshold arrives as zero, so an untouched cell reads 0.  There are no poses.

Documents with a DOCTYPE are refused (no recording has one, and entities can inflate without bound), and depth,
text and cells are bounded, so a hostile file ends in an error before it fills the memory.
"""

from __future__ import annotations

import bz2
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NoReturn
from xml.parsers import expat

import numpy as np

from exploration.recordings.intake import LARGEST, inflated_too_far, opened
from exploration.recordings.recording import JointTrace, Pad, PadFrame, Recording
from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.spec import SensorSpec, load_sensor
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError

PRESET = "dsa"  # whose rubber and gain stand in for those of the real pads
_CHUNK = 1 << 16
_DEEPEST = 16  # elements within one another
_LONGEST = 1 << 20  # characters of one element
_MOST_CELLS = 1 << 16  # of all matrices together
_MOST_ELEMENTS = 4_000_000  # two hours of frames and joint angles
_GROUPS = ("matrix", "frame", "angle")


@dataclass(frozen=True)
class _Item:
    """One `matrix`, `frame` or `angle` element: its leaves' texts."""

    kind: str
    texts: Mapping[str, str]


def read_dsa(path: Path, spec: SensorSpec | None = None) -> Recording:
    """A DSA recording; `spec` gives rubber and gain in the preset's place."""
    physics = spec or load_sensor(PRESET)
    pads: list[Pad] = []
    began: float | None = None
    jointed = False
    for item in _items(path):
        if item.kind == "matrix":
            pads.append(_pad(path, item.texts, len(pads), physics))
            if sum(pad.absent.size for pad in pads) > _MOST_CELLS:
                raise PalpateError(f"{path}: more than {_MOST_CELLS} cells; no such array is made")
        elif item.kind == "frame" and began is None:
            began = _number(path, item.texts, "time_stamp")
        jointed = jointed or item.kind == "angle"
    if not pads:
        raise PalpateError(f"{path}: no matrix is described; record it again with the DSA software")
    if began is None:
        raise PalpateError(f"{path}: no frame in it; record it again")
    start, layout = began, tuple(pads)
    return Recording(
        path=path,
        sensor=physics.name,
        pads=layout,
        replay=lambda: _frames(path, layout, start),
        timed=True,
        posed=False,
        warnings=(f"gain and rubber are those of {physics.name}: force and curvature are nominal",),
        joints=(lambda: _joints(path, start)) if jointed else None,
    )


def cells_of(text: str, total: int) -> Floats | None:
    """(total,) counts of one frame's hex, runs of zeros filled in; None where it is not that many."""
    try:
        values = np.frombuffer(bytes.fromhex(text), ">f4").astype(np.float64)
    except ValueError:
        return None
    run = values < 0
    length = np.where(run, -values, 1.0)
    if not (length <= total).all() or (length % 1.0).any() or length.sum() != total:
        return None
    return np.repeat(np.where(run, 0.0, values), length.astype(np.int64))


def _frames(path: Path, pads: Sequence[Pad], start: float) -> Iterator[PadFrame]:
    ends = np.cumsum([pad.absent.size for pad in pads])
    index = 0
    for item in _items(path):
        if item.kind != "frame":
            continue
        cells = cells_of(item.texts.get("frame_data", ""), int(ends[-1]))
        if cells is None:
            raise PalpateError(
                f"{path}: frame {index} is not {ends[-1]} cells; the file is damaged, copy it again"
            )
        time = (_number(path, item.texts, "time_stamp") - start) / 1000.0
        for i, (pad, part) in enumerate(zip(pads, np.split(cells, ends[:-1]), strict=True)):
            yield PadFrame(i, TaxelFrame(frozen(part.reshape(pad.array.shape)), time, index))
        index += 1


def _joints(path: Path, start: float) -> JointTrace:
    times, angles = [], []
    for item in _items(path):
        if item.kind == "angle":
            times.append((_number(path, item.texts, "time_stamp") - start) / 1000.0)
            try:
                angles.append([float(text) for text in item.texts.get("angle_data", "").split(",")])
            except ValueError:
                raise PalpateError(
                    f"{path}: joint angles {len(angles)} are not numbers; copy it again"
                ) from None
    if len({len(row) for row in angles}) > 1:
        raise PalpateError(f"{path}: the number of joint angles changes; the file is damaged, copy it again")
    return JointTrace(frozen(times), frozen(np.radians(np.array(angles))))


def _pad(path: Path, texts: Mapping[str, str], index: int, physics: SensorSpec) -> Pad:
    columns, rows = (_number(path, texts, name) for name in ("cells_x", "cells_y"))
    pitch = _number(path, texts, "texel_width"), _number(path, texts, "texel_height")
    if not (1 <= rows <= 1024 and 1 <= columns <= 1024 and rows % 1 == columns % 1 == 0 and min(pitch) > 0):
        raise PalpateError(
            f"{path}: matrix {index} is {rows:g} x {columns:g} cells of {pitch} mm; not an array"
        )
    array = TaxelArray(f"{physics.name}-{index}", int(rows), int(columns), pitch)
    absent = _absent(texts.get("static_mask", ""), array.shape)
    full = _number(path, texts, "fullscale") if "fullscale" in texts else physics.electronics.full_scale
    return Pad(array, absent, physics, zero=0.0, full_scale=full, foreign=True)


def _absent(mask: str, shape: tuple[int, int]) -> Bools:
    """Cells that the static mask leaves out; none where it has another shape."""
    digits = [digit == "0" for digit in mask if digit in "01"]
    whole = len(digits) == shape[0] * shape[1]
    return frozen(np.array(digits).reshape(shape) if whole else np.zeros(shape), np.bool_)


def _number(path: Path, texts: Mapping[str, str], name: str) -> float:
    try:
        value = float(texts[name])
    except (KeyError, ValueError):
        value = np.nan
    if not np.isfinite(value):
        raise PalpateError(f"{path}: a {name} is missing or no number; the file is damaged, copy it again")
    return value


def _items(path: Path) -> Iterator[_Item]:
    """Every matrix, frame and angle in the order of the file."""
    found: list[_Item] = []
    parser = _parser(path, found)
    try:
        with opened(path) as file:
            for chunk in _inflated(path, file):
                parser.Parse(chunk, False)
                yield from found
                found.clear()
            parser.Parse(b"", True)
            yield from found
    except expat.ExpatError as error:
        raise PalpateError(
            f"{path}: not whole XML at line {error.lineno} ({expat.ErrorString(error.code)}); copy it again"
        ) from None


def _parser(path: Path, found: list[_Item]) -> expat.XMLParserType:
    depth, length, elements = 0, 0, 0
    texts: dict[str, str] = {}
    text: list[str] = []

    def start(name: str, _: object) -> None:
        nonlocal depth, length, elements
        depth, length, elements = depth + 1, 0, elements + 1
        text.clear()
        if elements > _MOST_ELEMENTS:
            raise PalpateError(f"{path}: more than {_MOST_ELEMENTS:,} elements; record in shorter pieces")
        if depth > _DEEPEST:
            raise PalpateError(f"{path}: elements nest deeper than {_DEEPEST}; not a DSA recording")
        if depth == 1 and name != "root":
            raise PalpateError(f"{path}: its XML begins with <{name[:40]}>; not a DSA recording")
        if name in _GROUPS:
            texts.clear()

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        if name in _GROUPS:
            found.append(_Item(name, dict(texts)))
        elif len(texts) < 64:
            texts[name] = "".join(text).strip()

    def data(part: str) -> None:
        nonlocal length
        length += len(part)
        if length > _LONGEST:
            raise PalpateError(f"{path}: an element is longer than {_LONGEST >> 20} MB; not a DSA recording")
        text.append(part)

    def doctype(*_: object) -> NoReturn:
        raise PalpateError(f"{path}: it declares a document type, as no DSA recording does; refused")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = data, doctype
    return parser


def _inflated(path: Path, file: BinaryIO) -> Iterator[bytes]:
    """The XML in pieces; as it is where it was not compressed."""
    start = file.read(3)
    file.seek(0)
    if start != b"BZh":
        while chunk := file.read(_CHUNK):
            yield chunk
        return
    total = 0
    inflater = bz2.BZ2Decompressor()
    try:
        while not inflater.eof:
            compressed = file.read(_CHUNK) if inflater.needs_input else b""
            if inflater.needs_input and not compressed:
                raise PalpateError(f"{path} is cut short within its bzip2 data; copy it again")
            piece = inflater.decompress(compressed, _CHUNK)
            total += len(piece)
            if total > LARGEST:
                raise inflated_too_far(path)
            yield piece
    except OSError:
        raise PalpateError(f"{path}: damaged bzip2 data; copy it again") from None

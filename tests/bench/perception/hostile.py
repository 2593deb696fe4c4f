"""Frames that no working array gives: each must end in no line, or in one clear error."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from perception.arrays import PAD, array
from perception.edges import OURS, Finder
from perception.noise import Noise
from perception.score import row

from exploration.sensing.calibration import correct
from exploration.sensing.frame import TactileImage, TaxelFrame
from exploration.sensing.touch import perceive
from primitives.arrays import Floats
from primitives.errors import PalpateError


def hostile_rows(find: Finder, noise: Noise, frames: int) -> list[dict[str, Any]]:
    """Lines out of such frames, and errors of another kind than ours."""
    rng = np.random.default_rng(13)
    lines, other, seen = 0, 0, 0
    for _ in range(max(1, frames // 10)):
        for make in _frames(noise, rng):
            seen += 1
            try:
                image = make()
                touch = perceive(image)
                lines += bool(find(image)) or bool(touch.lines)
            except PalpateError:
                continue
            except Exception:
                other += 1
    return [
        row(OURS, "hostile frames with a line", 100 * lines / seen, "%", 0.0),
        row(OURS, "hostile frames that end in an unclear error", 100 * other / seen, "%", 0.0),
    ]


def _frames(noise: Noise, rng: np.random.Generator) -> Iterator[Callable[[], TactileImage]]:
    rows, columns = PAD.array.shape
    some = 10.0 * rng.standard_normal(PAD.array.shape)
    edge = some + np.where(np.arange(columns) < rng.integers(4, 12), 200.0, 0.0)
    broken = edge.copy()
    broken[rng.integers(rows), rng.integers(columns)] = rng.choice([np.nan, np.inf, -np.inf])
    single = some.copy()
    single[rng.integers(rows), rng.integers(columns)] = rng.uniform(200.0, 4000.0)
    for counts in (broken, np.full_like(edge, np.nan), -edge, np.full_like(edge, 245.0), single):
        yield lambda counts=counts: _image(counts, noise)
    yield lambda: _image(edge[:-1], noise)
    yield lambda: _image(edge.T.copy(), noise)
    yield lambda: replace(_image(edge, noise), sigma=np.full(edge.shape, np.inf))
    one = array(1, 1, 3.0)
    yield lambda: correct(
        TaxelFrame(np.array([[rng.uniform(0, 255)]]), 0.0, 0), noise.calibration(one), one.array
    )


def _image(counts: Floats, noise: Noise) -> TactileImage:
    return correct(TaxelFrame(counts, 0.0, 0), noise.calibration(PAD), PAD.array)

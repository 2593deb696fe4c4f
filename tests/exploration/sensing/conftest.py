"""Tactile frames made the slow way: a finely sampled depth field, scipy's Gaussian blur, taxel means, noise."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from exploration.sensing.frame import TactileImage, TaxelArray
from primitives.arrays import Floats

Field = Callable[[Floats, Floats], Floats]
FINE = 8  # samples per taxel and axis


@lru_cache
def carrier(count: int, pitch: float, spread: float, skin: float) -> tuple[Floats, Floats]:
    """Sample positions (m,), on a skin that ends in a mirror, and their shares in taxels (count, m)."""
    step = pitch / FINE
    margin = int(np.ceil(min(skin, 5 * spread) / step - 1e-9))
    m = count * FINE + 2 * margin
    blur = gaussian_filter1d(np.eye(m), spread / step, axis=0, truncate=5, mode="reflect")
    return (np.arange(m) - (m - 1) / 2) * step, blur[margin : m - margin].reshape(count, FINE, m).mean(axis=1)


class Frames:
    """Frames of one array, with its noise."""

    def __init__(
        self,
        rows: int = 10,
        columns: int = 16,
        pitch: float = 1.8,
        spread: float = 1.8,
        noise: float = 0.025,
        margin: float = np.inf,
    ) -> None:
        self.array = TaxelArray("test", rows, columns, (pitch, pitch))
        self.spread, self.noise, self.margin = spread, noise, margin

    def __call__(
        self, field: Field, rng: np.random.Generator | None = None, count: float = 0.0025
    ) -> TactileImage:
        x, to_columns = carrier(self.array.columns, self.array.pitch[0], self.spread, self.margin)
        y, to_rows = carrier(self.array.rows, self.array.pitch[1], self.spread, self.margin)
        depth = to_rows @ field(*np.meshgrid(x, y)) @ to_columns.T
        if rng is not None:
            depth = np.round((depth + self.noise * rng.standard_normal(depth.shape)) / count) * count
        sigma = np.full(depth.shape, np.hypot(self.noise, count / np.sqrt(12)))
        return TactileImage(self.array, depth, sigma, self.spread, 0.1, 0.0, self.margin)

    @staticmethod
    def half(angle: float, offset: float, side: int = 1, width: float = 0.225) -> Field:
        """1 on the material's side of a line, smoothed over a sample's width."""
        return lambda x, y: np.clip(
            side * (y * np.cos(angle) - x * np.sin(angle) - offset) / width + 0.5, 0.0, 1.0
        )

    @staticmethod
    def plane(depth: float = 0.5, slope: tuple[float, float] = (0.0, 0.0)) -> Field:
        return lambda x, y: np.maximum(0.0, depth + slope[0] * x + slope[1] * y)

    @staticmethod
    def edge(
        angle: float,
        offset: float,
        side: int = 1,
        depth: float = 0.5,
        slope: tuple[float, float] = (0.0, 0.0),
    ) -> Field:
        cover, face = Frames.half(angle, offset, side), Frames.plane(depth, slope)
        return lambda x, y: cover(x, y) * face(x, y)

    @staticmethod
    def sphere(radius: float, x0: float = 0.0, y0: float = 0.0, depth: float = 0.5) -> Field:
        return lambda x, y: np.maximum(
            0.0, depth - radius + np.sqrt(np.maximum(0.0, radius**2 - (x - x0) ** 2 - (y - y0) ** 2))
        )

    @staticmethod
    def cylinder(radius: float, angle: float = 0.0, offset: float = 0.0, depth: float = 0.5) -> Field:
        def field(x: Floats, y: Floats) -> Floats:
            t = y * np.cos(angle) - x * np.sin(angle) - offset
            return np.maximum(0.0, depth - radius + np.sqrt(np.maximum(0.0, radius**2 - t**2)))

        return field


@pytest.fixture
def frames() -> Frames:
    return Frames()


@pytest.fixture
def make_frames() -> type[Frames]:
    return Frames

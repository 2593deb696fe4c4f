"""Where pad and housing went without contact: boxes that hold no material.

A box fills the sensor's outline from behind the housing to the skin.  While the skin feels nothing the box ends
at the skin; pressed, it ends as deep behind the skin as the deepest taxel is indented.  A straight advance is one
long box.  An untouched taxel beside touched ones says that no material rises past the skin over it (our
derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from exploration.control.feel import Felt
from exploration.control.procedures.approach import touched
from exploration.devices.guard import Guard, Observation
from primitives import pose as se3
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import FreeSpace


@dataclass(frozen=True)
class SweptConfig:
    """What counts as free."""

    margin: float = 0.15  # [mm] kept between a box and the skin
    turned: float = 0.03  # [rad] of turning, from which a new box begins
    aside: float = 1.0  # [mm] of motion across the pad's normal, likewise
    share: float = 0.12  # of the press, below which a taxel may be untouched
    sigmas: float = 4.0  # of its noise, likewise
    press: float = 0.3  # [mm] of the pad as a whole, from which its free taxels speak
    thick: float = 1.5  # [mm] of the space behind an untouched taxel
    rim: float = 0.4  # [taxels] that such a space is narrower than its taxels
    deep: float = 30.0  # [mm] from the skin to the housing's back, at least


class Swept:
    """Grows while it watches a guard."""

    def __init__(self, guard: Guard, config: SweptConfig | None = None) -> None:
        self._guard, self._config = guard, config or SweptConfig()
        self._runs: list[tuple[Floats, Floats]] = []  # first and last pose of each straight advance

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Note every pose at which the skin feels nothing."""
        before = self._guard.learners
        self._guard.learners = (*before, self._see)
        try:
            yield
        finally:
            self._guard.learners = before

    def boxes(self) -> FreeSpace:
        """What was swept."""
        made = [
            _box(
                self._guard,
                last,
                self._config,
                self._config.margin,
                float(np.linalg.norm(last[:3, 3] - first[:3, 3])),
            )
            for first, last in self._runs
        ]
        return _space(made)

    def _see(self, seen: Observation) -> None:
        if touched(seen.image):
            return
        here = seen.world_from_sensor
        if self._runs:
            first, last = self._runs[-1]
            step = here[:3, 3] - first[:3, 3]
            aside = step - first[:3, 2] * float(step @ first[:3, 2])
            turned = float(np.linalg.norm(here[:3, 2] - first[:3, 2]))
            if float(np.linalg.norm(aside)) < self._config.aside and turned < self._config.turned:
                farther = float((here[:3, 3] - last[:3, 3]) @ first[:3, 2]) > 0.0
                self._runs[-1] = (first, here if farther else last)
                return
        self._runs.append((here, here))


def behind_skin(guard: Guard, seen: Observation, config: SweptConfig | None = None) -> FreeSpace:
    """The pad and its housing where the pad lies pressed."""
    config = config or SweptConfig()
    live = np.isfinite(seen.image.sigma)
    deepest = float(np.where(live, seen.image.depth, 0.0).max(initial=0.0))
    return _space([_box(guard, seen.world_from_sensor, config, deepest + config.margin, 0.0)])


def over_free_taxels(seen: Observation, felt: Felt, config: SweptConfig | None = None) -> FreeSpace:
    """Thin boxes over the taxels that feel nothing; none where the press is light."""
    config = config or SweptConfig()
    if felt.depth < config.press:
        return _space([])
    image = seen.image
    low = np.maximum(config.share * felt.depth, config.sigmas * image.sigma)
    free = np.isfinite(image.sigma) & (image.depth < low) & ~binary_dilation(felt.mask)
    px, py = image.array.pitch
    made = []
    for top, bottom, left, right in rectangles(free):
        x = 0.5 * (image.array.x[left] + image.array.x[right - 1])
        y = 0.5 * (image.array.y[top] + image.array.y[bottom - 1])
        wide, high = (right - left - config.rim) * px, (bottom - top - config.rim) * py
        half = 0.5 * np.array([wide, high, config.thick])
        place = se3.pose(translation=[x, y, -config.margin - 0.5 * config.thick])
        made.append((seen.world_from_sensor @ place, half))
    return _space(made)


def rectangles(mask: Bools) -> list[tuple[int, int, int, int]]:
    """Disjoint (top, bottom, left, right) rectangles that fill a mask: runs of a row, grown while they fit."""
    left_over, found = mask.copy(), []
    for row in range(mask.shape[0]):
        column = 0
        while column < mask.shape[1]:
            if not left_over[row, column]:
                column += 1
                continue
            end = column
            while end < mask.shape[1] and left_over[row, end]:
                end += 1
            bottom = row + 1
            while bottom < mask.shape[0] and left_over[bottom, column:end].all():
                bottom += 1
            left_over[row:bottom, column:end] = False
            found.append((row, bottom, column, end))
            column = end
    return found


def _box(
    guard: Guard, place: Floats, config: SweptConfig, front: float, length: float
) -> tuple[Floats, Floats]:
    """World_from_box and half extents: the pad's outline, from `front` [mm] behind the skin to the housing's back.

    `length` [mm] that it came straight ahead are added behind.
    """
    x, y = guard.sensor.array.size
    depth = length + config.deep
    middle = se3.pose(translation=[0.0, 0.0, -front - 0.5 * depth])
    return place @ middle, np.array([0.5 * x, 0.5 * y, 0.5 * depth])


def _space(boxes: list[tuple[Floats, Floats]]) -> FreeSpace:
    if not boxes:
        return FreeSpace(frozen(np.empty((0, 4, 4))), frozen(np.empty((0, 3))))
    return FreeSpace(frozen(np.stack([b[0] for b in boxes])), frozen(np.stack([b[1] for b in boxes])))

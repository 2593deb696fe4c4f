"""Pits in a flat contact: places well inside it where the skin is pressed less, as over a hole in the face.

The rubber blurs a hole and loses nothing of it: what is missing of the face's depth, divided by that depth and
added up, is the hole's area, however wide the blur (our derivation)::

    pi r^2 = sum over taxels of (1 - z / z_face) * taxel area.

So a hole narrower than the blur's shadow, over which no taxel is quite free, is found by a glance at every frame.
How round it is, and exactly how wide, a look at its rim tells (`round_hole`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, find_objects, label

from exploration.sensing.frame import TactileImage
from primitives.arrays import Bools, Floats

_ALL_ROUND = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True)
class PitsConfig:
    """What counts as a pit."""

    pressed: float = 0.15  # [mm] of the face beside it, and
    sigmas: float = 5.0  # of a taxel's noise, from which the face is pressed well
    on: float = 0.6  # of the face's depth, from which a taxel lies on it
    deep: float = 0.55  # of it, to which the deepest taxel of a pit falls
    around: int = 2  # taxels round a pit, over which the blur spreads it
    radii: tuple[float, float] = (1.2, 6.0)  # [mm] of a pit's area
    contact: int = 24  # taxels on the face
    longer: float = 2.0  # times as long as it is wide, from which it is a slot's mouth and no pit


@dataclass(frozen=True)
class Pit:
    """One in an image."""

    center: Floats  # (2,) [mm] in the pad's plane
    depth: float  # [mm] of the face there
    radius: float  # [mm] of a circle of its area


def pits(image: TactileImage, config: PitsConfig = PitsConfig()) -> list[Pit]:
    """Pits of one frame, whose contact is taken for flat."""
    live = np.isfinite(image.sigma)
    top = float(np.quantile(image.depth[live], 0.9)) if live.any() else 0.0
    noise = float(np.median(image.sigma[live])) if live.any() else np.inf
    if top < max(config.pressed, config.sigmas * noise):
        return []
    face = _plane(image, live & (image.depth > config.on * top))
    if face is None:
        return []
    share = np.where(live & (face > 0.5 * top), image.depth / np.maximum(face, 0.5 * top), 1.0)
    low = share < config.on
    if np.count_nonzero(~low & live) < config.contact or not low.any():
        return []
    return _inside(image, face, share, low, config)


def _inside(image: TactileImage, face: Floats, share: Floats, low: Bools, config: PitsConfig) -> list[Pit]:
    """Of the lots of taxels that are low, those with the face all round them."""
    lots, _ = label(low, _ALL_ROUND)
    area = float(np.prod(image.array.pitch))
    found: list[Pit] = []
    for number, (rows, columns) in enumerate(find_objects(lots), start=1):
        inner = (
            rows.start > 0 and columns.start > 0 and rows.stop < low.shape[0] and columns.stop < low.shape[1]
        )
        mine = lots == number
        if not inner or float(share[mine].min()) > config.deep:
            continue
        others = binary_dilation(low & ~mine, _ALL_ROUND)
        near = binary_dilation(mine, _ALL_ROUND, config.around) & ~others
        missing = np.where(near, 1.0 - share, 0.0)
        radius = float(np.sqrt(max(missing.sum() * area, 0.0) / np.pi))
        if config.radii[0] < radius < config.radii[1]:
            weight = np.maximum(missing, 0.0) / np.maximum(missing, 0.0).sum()
            center = np.array([weight.sum(axis=0) @ image.array.x, weight.sum(axis=1) @ image.array.y])
            if _slender(image, weight, center) > config.longer:
                continue
            found.append(Pit(center, float((weight * face).sum()), radius))
    return found


def _slender(image: TactileImage, weight: Floats, center: Floats) -> float:
    """How many times as long as wide what (rows, columns) `weight` tells of is, blurred as it is."""
    x, y = image.array.x - center[0], image.array.y - center[1]
    xx, yy, xy = weight.sum(axis=0) @ x**2, weight.sum(axis=1) @ y**2, y @ weight @ x
    least, most = np.linalg.eigvalsh(np.array([[xx, xy], [xy, yy]]))
    return float(np.sqrt(most / max(least, 1e-9)))


def _plane(image: TactileImage, on: Bools) -> Floats | None:
    """(rows, columns) depth of the plane through the taxels that are on a face."""
    rows, columns = np.nonzero(on)
    if len(rows) < 3:
        return None
    x, y = image.array.x, image.array.y
    told = np.column_stack([np.ones(len(rows)), x[columns], y[rows]])
    flat, _, rank, _ = np.linalg.lstsq(told, image.depth[on], rcond=None)
    return None if rank < 3 else np.asarray(flat[0] + flat[1] * x[None, :] + flat[2] * y[:, None])

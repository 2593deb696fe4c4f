"""Narrow holes in flat faces, as their pictures show them.

A single image shows no hole that lies half under the pad, or close beside an edge; the picture of the whole face
does.  The rubber blurs a disc of radius r with a Gaussian of sigma s, so that over its middle is left of the face

    exp(-r^2 / (2 s^2)),

which tells r where the hole is narrow; where it is wide, the picture is half there at its rim (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, find_objects, label

from exploration.planning.known.mosaic import Lattice, Mosaic, Picture
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim
from primitives.arrays import Bools, Floats
from primitives.pose import frame_along

_ALL_ROUND = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True)
class PicturedPitsConfig:
    """What counts as one."""

    cells: int = 12  # felt places of the face, at least
    margin: float = 4.0  # [mm] round them, of the picture
    levels: tuple[float, float] = (0.75, 0.35)  # shares, down from the first: an island under one of them,
    steps: int = 9  # in so many steps
    deep: float = 0.6  # share of the face over its middle, at most
    told: float = 0.12  # likewise, down to which that tells its radius
    radii: tuple[float, float] = (1.2, 6.0)  # [mm]
    longer: float = 1.6  # times as long as wide, from which it is a slot's mouth
    sigma: float = 0.3  # [mm] of its radius


def pictured_pits(
    known: Sequence[KnownFace], mosaic: Mosaic, config: PicturedPitsConfig = PicturedPitsConfig()
) -> list[RoundRim]:
    """Their rims, of all known flat faces."""
    found: list[RoundRim] = []
    for own in known:
        if own.fit.kind != "plane" or len(own.cells) < config.cells:
            continue
        axis, anchor = own.side * own.fit.shape.direction, own.fit.shape.anchor
        lain = mosaic.flush(anchor, axis)
        if not lain:
            continue
        along = frame_along(axis)[:, :2]
        lattice = Lattice.over(own.cells, along, mosaic.config.step, config.margin)
        blur = float(np.hypot(np.median([image.spread for image in lain]), mosaic.config.blur))
        for middle, radius in _islands(mosaic.picture(anchor, axis, lattice), lattice, blur, config):
            center = along @ middle + (anchor @ axis) * axis
            found.append(RoundRim(center, axis, radius, config.sigma, own.face.id))
    return found


def _islands(
    seen: Picture, lattice: Lattice, blur: float, config: PicturedPitsConfig
) -> Iterator[tuple[Floats, float]]:
    """(2,) middles [mm] and radii of what is missing of a picture with the face all round it."""
    taken = np.zeros(lattice.shape, dtype=bool)
    for level in np.linspace(*config.levels, config.steps):
        lots, _ = label(seen.known & (seen.share < level), _ALL_ROUND)
        for number, (rows, columns) in enumerate(find_objects(lots), start=1):
            mine = lots == number
            inner = min(rows.start, columns.start) > 0
            inner &= rows.stop < lattice.shape[0] and columns.stop < lattice.shape[1]
            if not inner or (mine & taken).any() or not seen.known[binary_dilation(mine, _ALL_ROUND)].all():
                continue
            taken |= mine
            least = float(seen.share[mine].min())
            middle, longer = _middle(mine, level - seen.share)
            radius = _radius(least, int((mine & (seen.share < 0.5)).sum()), lattice.step, blur, config)
            if least < config.deep and longer < config.longer and config.radii[0] < radius < config.radii[1]:
                yield lattice.origin + lattice.step * middle, radius


def _radius(least: float, cells: int, step: float, blur: float, config: PicturedPitsConfig) -> float:
    if least > config.told:
        return blur * float(np.sqrt(-2.0 * np.log(least)))
    return step * float(np.sqrt(cells / np.pi))


def _middle(mine: Bools, weight: Floats) -> tuple[Floats, float]:
    """(2,) the place of an island on its lattice, and how many times as long as wide it is."""
    at, weights = np.argwhere(mine).astype(np.float64), weight[mine]
    middle = weights @ at / weights.sum()
    away = at - middle
    spread = (weights * away.T) @ away / weights.sum() + np.eye(2) / 12.0
    least, most = np.linalg.eigvalsh(spread)
    return middle, float(np.sqrt(most / least))

"""What the whole skin felt, against what it would have felt on an object at a pose.

A contact tells where the surface is; the picture of a touch also tells where it ends.  Under a hypothesis the skin
gives way as springs side by side do, is dented where rays meet the surface, and the rubber spreads that::

    felt(r) = G * max(0, dent(r)) + d G * 1 + slope . G * r + shift . grad (G * dent)

with the last three, of this one touch, and a spin by least squares with a prior: a pose is never exact, and what
fits only moved far aside is worth less.  What is left over counts, and the move, as normal errors do, taxels that
the rubber spreads into one another together; beyond what any touch is off, and up to a bound.
A pose that is not known well enough to say what lay under the pad loses nothing (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter

from models.library import Entry
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Imprint
from recognition.matching.belief import Hypothesis
from recognition.matching.evidence import Evidence


@dataclass(frozen=True)
class ImprintConfig:
    """How far the skin is trusted, and whose word is asked."""

    split: int = 2  # rays a taxel, along x and along y
    deepest: float = 2.0  # [mm] of a dent that is told apart
    off: float = (
        0.1  # of the deepest dent, by which taxels err together: gains, play, rubber that is no spring
    )
    floor: float = 0.015  # [mm] likewise, at least
    allowed: float = 2.0  # log likelihood that one touch is off for nothing,
    bound: float = 8.0  # and that it costs beyond that, at most
    depth: float = 0.2  # [mm] sigma of how deep the pad lay
    slope: float = 0.02  # [rad] of its tilt
    aside: float = 0.15  # [mm] of its place along the skin, besides that of the hypothesis
    placed: float = 0.6  # [mm] error of the place, beyond which a hypothesis is not asked
    turned: float = 0.05  # [rad] likewise


def log_imprints(
    h: Hypothesis, entry: Entry, evidence: Evidence, config: ImprintConfig | None = None
) -> float:
    """Logarithm of what is left of a hypothesis after all that the skin felt; 0 where it fits."""
    config = config or ImprintConfig()
    if h.translation_sigma > config.placed or h.rotation_sigma > config.turned:
        return 0.0
    solid = entry.solid.placed(h.pose)
    aside = float(np.hypot(config.aside, h.translation_sigma))
    own = np.array([aside, aside, config.depth, config.slope, config.slope, config.slope])
    off = (
        fitted(imprint, foreseen(imprint, solid, config), own, config).off for imprint in evidence.imprints
    )
    return -sum(min(max(each - config.allowed, 0.0), config.bound) for each in off)


class Fitted(NamedTuple):
    """One imprint on a posed solid, its pad's own move taken for what is likeliest."""

    off: float  # half the squared sigmas, of the move too
    information: Floats  # (6, 6) on a move of the object, in the pad's frame
    pull: Floats  # (6,)


def fitted(imprint: Imprint, foretold: tuple[Floats, Floats], own: Floats, config: ImprintConfig) -> Fitted:
    """Against what `foreseen` tells; (6,) `own` are the sigmas [mm, rad] of the pad's own pose."""
    expected, bases = foretold
    live = np.isfinite(imprint.sigma)
    deepest = max(float(imprint.depth[live].max(initial=0.0)), float(expected.max()))
    sigma = np.sqrt(imprint.sigma[live] ** 2 + config.floor**2 + (config.off * deepest) ** 2)
    left, rows = (imprint.depth - expected)[live] / sigma, bases[:, live] / sigma
    alike = together(imprint)
    curved, pull = rows @ rows.T / alike, rows @ left / alike
    blurred = np.linalg.solve(curved + np.diag(own**-2.0), np.column_stack([curved, pull]))
    off = 0.5 * (float(left @ left) / alike - float(pull @ blurred[:, 6]))
    return Fitted(off, curved - curved @ blurred[:, :6], pull - curved @ blurred[:, 6])


def together(imprint: Imprint) -> float:
    """Taxels that the rubber spreads into one another."""
    pitch = _pitch(imprint.x), _pitch(imprint.y)
    return max(1.0, 4.0 * np.pi * imprint.spread**2 / (pitch[0] * pitch[1]))


def foreseen(imprint: Imprint, solid: Solid, config: ImprintConfig) -> tuple[Floats, Floats]:
    """(rows, columns) [mm] felt on a solid, and (6, rows, columns) how that changes as the pad moves.

    Moves are (v [mm], w [rad]) of the sensor in its own frame.
    """
    (x, beside), (y, above) = (_finer(line, imprint.margin, config.split) for line in (imprint.x, imprint.y))
    dent = _dents(imprint.pose, x, y, solid, config.deepest)
    met = (dent > 0.0).astype(np.float64)
    step = x[1] - x[0], y[1] - y[0]
    width = imprint.spread / step[1], imprint.spread / step[0]

    def spread(image: Floats) -> Floats:
        return np.asarray(gaussian_filter(image, width, mode="reflect")) if imprint.spread > 0 else image

    felt = spread(dent)
    along_y, along_x = map(np.asarray, np.gradient(felt, step[1], step[0]))
    up = y[:, None]
    tilts = spread(met * up), -spread(met * x), x * along_y - up * along_x
    images = [felt, along_x, along_y, spread(met), *tilts]
    split = config.split
    inner = np.stack(images)[:, above : len(y) - above, beside : len(x) - beside]
    shape = (len(images), len(imprint.y), split, len(imprint.x), split)
    taxels = inner.reshape(shape).mean(axis=(2, 4))
    return taxels[0], taxels[1:]


def _finer(centers: Floats, margin: float, split: int) -> tuple[Floats, int]:
    """(n,) [mm] places of rays over taxels and the skin past them, and how many of these lie past either end."""
    step = _pitch(centers) / split
    past = max(0, round(margin / step))
    first = centers[0] - 0.5 * (split - 1) * step
    return first + step * np.arange(-past, len(centers) * split + past), past


def _pitch(centers: Floats) -> float:
    return float(centers[1] - centers[0]) if len(centers) > 1 else 1.0


def _dents(at: Floats, x: Floats, y: Floats, solid: Solid, deepest: float) -> Floats:
    """(rows, columns) [mm] that a solid stands in the skin, up to the deepest."""
    grid = np.stack([*np.meshgrid(x, y), np.full((len(y), len(x)), -deepest)], axis=-1).reshape(-1, 3)
    origins = np.ascontiguousarray(grid @ at[:3, :3].T + at[:3, 3], dtype=np.float32)
    ways = np.ascontiguousarray(np.broadcast_to(at[:3, 2], origins.shape), dtype=np.float32)
    reached, triangle = solid.first_hits(origins, ways)
    facing = solid.body.triangle_normals[triangle] @ (solid.pose[:3, :3].T @ at[:3, 2])
    inside = (triangle >= 0) & (facing > 0.0)
    dent = np.where(inside, deepest, np.clip(deepest - reached.astype(float), 0.0, deepest))
    return dent.reshape(len(y), len(x))

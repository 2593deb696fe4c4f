"""How probable contacts are on an object at a pose, and on an object that is in no library.

A contact is a uniform sample of a surface of area A, seen with noise, or with probability w anywhere in a ball of
volume V::

    p(z | object, pose) = (1 - w) / A  N(d; sigma) ((1 - t) N2(angle; tau) + t / (4 pi)) + w / V / (4 pi)

with N2 over the sphere of normals, left out where none was felt, and t the share of pads that lay on an edge,
with any normal (Thrun, Burgard and Fox 2005, section 6.3, has the mixture; the area, which keeps a larger model
from winning for its size, is our derivation).  An object in no library is like one of it with every second
contact off, half of these by some millimeters and half anywhere::

    p(z | unknown) = 1/2 p(z | object, pose) + 1/4 / V / (4 pi)
                     + 1/4 / A  exp(-|d| / b) / 2b  (1/2 N2 + 1/2 / (4 pi))

Where nobody told how far contacts scatter, Laplace's density exp(-d / b) / 2b takes the normal one's place: its
tails forgive, and its likeliest pose is that of the least mean distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats
from recognition.matching.facets import TILTED


@dataclass(frozen=True)
class NoiseConfig:
    """The parts of the mixtures."""

    outliers: float = 0.01  # share of contacts that say nothing of the object
    broad: float = 0.06  # times the object's size [mm]: how far an unknown object's surface is off
    loosest: float = 8.0  # up to which factor noise that nobody told may be more or less


def log_likelihoods(distances: Floats, angles: Floats, felt: Bools, sigma: Floats, tau: Floats, area: float,
                    size: float, volume: float, config: NoiseConfig,
                    absolute: bool = False) -> tuple[Floats, Floats]:  # fmt: skip
    """(k, n) logarithms of p(z | object, pose) and of p(z | an unknown like it)."""
    d2, a2 = (distances / sigma) ** 2, (angles / tau) ** 2
    turned = np.where(felt, np.exp(-0.5 * np.minimum(a2, 700)) / (2 * np.pi * tau**2), 1.0)
    everywhere = np.where(felt, 1.0 / (4 * np.pi), 1.0)
    near = np.exp(-0.5 * np.minimum(d2, 700)) / (np.sqrt(2 * np.pi) * sigma)
    if absolute:
        near = np.exp(-np.sqrt(np.minimum(d2, 5e5))) / (2 * sigma)
    stray = everywhere / volume
    facing = (1 - TILTED) * turned + TILTED * everywhere
    known = (1 - config.outliers) / area * near * facing + config.outliers * stray
    b = config.broad * size
    off = np.where(np.isfinite(distances), distances, 4.0 * b)
    loose = np.exp(-off / b) / (2 * b) * (0.5 * turned + 0.5 * everywhere) / area
    return np.log(known), np.log(0.5 * known + 0.25 * loose + 0.25 * stray)

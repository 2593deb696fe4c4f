"""How probable contacts are on an object at a pose, and on an object that is in no library.

A contact lies somewhere along a surface with the density a of `places`, seen with noise, or with probability w
anywhere within the object's size s of it::

    p(z | object, pose) = a ((1 - w) N(d; sigma) ((1 - t) N2(angle; tau) + t / (4 pi)) + w / s / (4 pi))

with N2 over the sphere of normals, left out where none was felt, and t the share of pads that lay on an edge,
with any normal (Thrun, Burgard and Fox 2005, section 6.3, has the mixture).  An object in no library is like one
of it with a share f of its contacts off, half of these by some millimeters and half anywhere; nobody knows f, so
it is integrated out::

    p(Z | unknown) = integral over f in [0, 1] of  product over contacts of
                     (1 - f) p(z | object, pose) + f p(z | off)
    p(z | off) = a (1/2 / s / (4 pi) + 1/2 exp(-|d| / b) / 2b  (1/2 N2 + 1/2 / (4 pi)))

which costs an object of the library that fits about a factor of the number of contacts (our derivation).

Where nobody told how far contacts scatter, Laplace's density exp(-d / b) / 2b takes the normal one's place: its
tails forgive, and its likeliest pose is that of the least mean distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from primitives.arrays import Bools, Floats
from recognition.matching.facets import TILTED

_NODES = 12  # of the integral over the share that is off


@dataclass(frozen=True)
class NoiseConfig:
    """The parts of the mixtures."""

    outliers: float = 0.002  # share of contacts that say nothing of the object
    broad: float = 0.06  # times the object's size [mm]: how far an unknown object's surface is off
    loosest: float = 8.0  # up to which factor noise that nobody told may be more or less


def log_likelihoods(distances: Floats, angles: Floats, felt: Bools, sigma: Floats, tau: Floats, size: float,
                    config: NoiseConfig, absolute: bool = False) -> tuple[Floats, Floats]:  # fmt: skip
    """(k, n) logarithms of p(z | object, pose) / a and of p(z | off) / a."""
    d2, a2 = (distances / sigma) ** 2, (angles / tau) ** 2
    turned = np.where(felt, np.exp(-0.5 * np.minimum(a2, 700)) / (2 * np.pi * tau**2), 1.0)
    everywhere = np.where(felt, 1.0 / (4 * np.pi), 1.0)
    near = np.exp(-0.5 * np.minimum(d2, 700)) / (np.sqrt(2 * np.pi) * sigma)
    if absolute:
        near = np.exp(-np.sqrt(np.minimum(d2, 5e5))) / (2 * sigma)
    stray = everywhere / size
    facing = (1 - TILTED) * turned + TILTED * everywhere
    known = (1 - config.outliers) * near * facing + config.outliers * stray
    b = config.broad * size
    off = np.where(np.isfinite(distances), distances, 4.0 * b)
    loose = np.exp(-off / b) / (2 * b) * (0.5 * turned + 0.5 * everywhere)
    return np.log(known), np.log(0.5 * loose + 0.5 * stray)


def log_unlike(known: Floats, off: Floats, shares: Floats) -> Floats:
    """(k,) logarithms of p(Z | an unknown like it), of the two (k, n) of `log_likelihoods`."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    f = 0.5 * (nodes + 1.0)
    both = np.logaddexp(known[:, None] + np.log1p(-f)[:, None], off[:, None] + np.log(f)[:, None])
    return np.asarray(logsumexp(both @ shares + np.log(0.5 * weights), axis=1))

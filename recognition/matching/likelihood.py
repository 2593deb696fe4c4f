"""How probable contacts are on an object at a pose, and on an object that is in no library.

A contact lies somewhere along a surface with the density a of `places`, seen with noise; or it is off: anywhere
within the object's size s of it, or by some millimeters, or near it and turned some other way::

    p(z | on)  = a N(d; sigma) ((1 - c) N2(angle; tau) + c N2(angle; CREASE / 2))
    p(z | off) = a (l / s / (4 pi) + l exp(-|d| / b) / 2b  (1/2 N2 + 1/2 / (4 pi)) + e N(d; sigma) / (4 pi))

with N2 over the sphere of normals, left out where none was felt, c the share of contacts on coarse facets, whose
normal is not the one between the corners, e that of pads that lay on an edge or on a surface that crosses this,
and 2 l + e = 1 (Thrun, Burgard and Fox 2005, section 6.3, has the mixture).  Nobody knows the share f that is off,
so it is integrated out, under one prior for the object itself and another for one in no library that is like it::

    p(Z | object, pose) = integral over f of p(f) product over contacts of (1 - f) p(z | on) + f w p(z | off)

Few sensors stray at all and some do in a few of a hundred contacts: of the object itself p(f) falls as f^(-3/2)
between `rarest` and `commonest`.  What strays was met on the way to the object, on a cable or on another body, or
in the air: w is `through` where it would lie behind the object's surface, where no finger comes.  Of an object in
no library f is anything from 0 to 1, on either side: it costs an object of the library that fits about a factor of
the number of contacts (our derivation).

Where nobody told how far contacts scatter, Laplace's density exp(-d / b) / 2b takes the normal one's place: its
tails forgive, and its likeliest pose is that of the least mean distance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import gammaln, logsumexp

from primitives.arrays import Bools, Floats, frozen
from recognition.matching.facets import CREASE

_NODES = 12  # of the integral over the share that is off, of an unknown object
_BENT = CREASE / 2.0  # [rad] of a facet's normal to that between its corners
_FALLING = 1.5  # power of the share that is off, with which its density falls, of a known object
_A_DECADE = 5  # nodes a decade of the same integral, of a known one


@dataclass(frozen=True)
class NoiseConfig:
    """The parts of the mixtures."""

    rarest: float = 2e-4  # share of contacts that are off an object, at least,
    commonest: float = 0.1  # and at most
    through: float = 0.05  # how likely one that is off lies behind the surface, beside one in front
    crossing: float = 0.1  # share of those that are off, that lie near the surface with any normal
    faceted: float = 0.02  # share of contacts on the surface with a normal that a coarse facet bends
    broad: float = 0.06  # times the object's size [mm]: how far an unknown object's surface is off
    loosest: float = 8.0  # up to which factor noise that nobody told may be more or less

    @property
    def outliers(self) -> float:
        """The share that is off to be expected of one contact."""
        f, log_weights = _rare(self)
        return float(f @ np.exp(log_weights))


def log_likelihoods(distances: Floats, angles: Floats, felt: Bools, sigma: Floats, tau: Floats, size: float,
                    config: NoiseConfig, absolute: bool = False) -> tuple[Floats, Floats]:  # fmt: skip
    """(k, n) logarithms of p(z | on) / a and of p(z | off) / a."""
    d2, a2 = (distances / sigma) ** 2, (angles / tau) ** 2
    turned = np.where(felt, np.exp(-0.5 * np.minimum(a2, 700)) / (2 * np.pi * tau**2), 1.0)
    everywhere = np.where(felt, 1.0 / (4 * np.pi), 1.0)
    if absolute:
        near = -np.sqrt(np.minimum(d2, 5e5)) - np.log(2 * sigma)
    else:
        near = -0.5 * np.minimum(d2, 700) - np.log(np.sqrt(2 * np.pi) * sigma)
    bent = np.where(felt, np.exp(-0.5 * np.minimum((angles / _BENT) ** 2, 700)) / (2 * np.pi * _BENT**2), 1.0)
    facing = (1 - config.faceted) * turned + config.faceted * bent
    b = config.broad * size
    away = np.where(np.isfinite(distances), distances, 4.0 * b)
    loose = np.exp(-away / b) / (2 * b) * (0.5 * turned + 0.5 * everywhere)
    e = config.crossing
    off = 0.5 * (1 - e) * (loose + everywhere / size) + e * np.exp(near) * everywhere
    return near + np.log(facing), np.log(off)


def log_strays(off: Floats, behind: Bools, config: NoiseConfig) -> Floats:
    """(k, n) logarithms of w p(z | off) / a, of contacts that lie (k, n) behind the surface or not."""
    return np.asarray(off + np.where(behind, np.log(config.through), 0.0))


def log_each(on: Floats, off: Floats, config: NoiseConfig) -> Floats:
    """(k, n) logarithms of each contact's own probability, of the two of `log_likelihoods`."""
    f = config.outliers
    return np.asarray(np.logaddexp(on + np.log1p(-f), off + np.log(f)))


def log_known(on: Floats, off: Floats, shares: Floats, config: NoiseConfig) -> Floats:
    """(k,) logarithms of p(Z | object, pose), of contacts that count for (n,) shares."""
    return _integrated(on, off, shares, *_rare(config))


def log_unlike(on: Floats, off: Floats, shares: Floats) -> Floats:
    """(k,) logarithms of p(Z | an unknown like it)."""
    return _integrated(on, off, shares, *_anything())


def log_astray(times: float, contacts: float, bound: float) -> float:
    """What contradictions by empty space leave of an unknown object: each is a place more where it is another.

    Under a uniform f, n contacts that fit and m places that do not have the probability m! (n + 1)! / (n + m + 1)!
    over that of the contacts alone; never less than `bound`, what they leave of the known one.
    """
    return max(bound, float(gammaln(times + 1) + gammaln(contacts + 2) - gammaln(contacts + times + 2)))


def log_scattered(points: Floats, felt: Bools, shares: Floats, volume: float) -> float:
    """Logarithm of p(contacts) if they were scattered round a point of a `volume` [mm^3], width unknown."""
    n = float(shares.sum())
    square = float(shares @ ((points - shares @ points / n) ** 2).sum(axis=1))
    widths = np.geomspace(5.0, 200.0, 8)
    each = -0.5 * square / widths**2 - 1.5 * (n - 1) * np.log(2 * np.pi * widths**2) - 1.5 * np.log(n)
    turned = np.log(4 * np.pi) * float(shares[felt].sum())
    return float(logsumexp(each) - np.log(len(widths)) - np.log(volume) - turned)


@cache
def _anything() -> tuple[Floats, Floats]:
    """Gauss-Legendre nodes between 0 and 1, and the logarithms of their weights."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return frozen(0.5 * (nodes + 1.0)), frozen(np.log(0.5 * weights))


@cache
def _rare(config: NoiseConfig) -> tuple[Floats, Floats]:
    """Nodes of f, even in its logarithm, and the logarithms of their weights."""
    many = 1 + max(1, round(_A_DECADE * np.log10(config.commonest / config.rarest)))
    f = np.geomspace(config.rarest, config.commonest, many)
    log_weights = (1.0 - _FALLING) * np.log(f)
    return frozen(f), frozen(log_weights - logsumexp(log_weights))


def _integrated(on: Floats, off: Floats, shares: Floats, f: Floats, log_weights: Floats) -> Floats:
    both = np.logaddexp(on[:, None] + np.log1p(-f)[:, None], off[:, None] + np.log(f)[:, None])
    return np.asarray(logsumexp(both @ shares + log_weights, axis=1))

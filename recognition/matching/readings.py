"""A mesh read in two ways: as the round faces that its facets stand for, or as the facets that it has.

Of a file of triangles nobody knows which is meant.  The part that it was made for is round, and so is one that was
turned from it; one that was printed, cast from a coarse model or simulated has the facets.  A normal is half a
fold off at most, which counts for little where facets are fine, and for several sigmas where they are coarse.  One
object is one or the other everywhere::

    p(Z | mesh) = 1/2 p(Z | its facets bend into one another) + 1/2 p(Z | its facets are flat)

Where the surfaces are known, as of a STEP file or a tree of solids, there is nothing to be read twice (our
derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from models.body import Body
from primitives.arrays import Bools, Floats
from recognition.matching.align import Aligned
from recognition.matching.facets import is_exact
from recognition.matching.likelihood import (
    NoiseConfig,
    log_each,
    log_known,
    log_likelihoods,
    log_strays,
    log_unlike,
)


class Weighed(NamedTuple):
    """Of contacts at each of k poses."""

    each: Floats  # (k, n) logarithms of each contact's own probability
    known: Floats  # (k,) of p(Z | object, pose)
    unlike: Floats  # (k,) of p(Z | an unknown like it)


def readings(done: Aligned, body: Body) -> list[Floats]:
    """(k, n) angles [rad] to the normals of the bent surface and, where it is not known exactly, of facets."""
    return [done.angles] if is_exact(body) else [done.angles, done.facet_angles]


def weighed(
    distances: Floats,
    angles: Floats,
    felt: Bools,
    sigma: Floats,
    tau: Floats,
    shares: Floats,
    behind: Bools,
    size: float,
    noise: NoiseConfig,
    absolute: bool,
) -> Weighed:
    """By one reading; `behind` (k, n): which lie behind the surface."""
    on, off = log_likelihoods(distances, angles, felt, sigma, tau, size, noise, absolute)
    strays = log_strays(off, behind, noise)
    return Weighed(
        log_each(on, strays, noise), log_known(on, strays, shares, noise), log_unlike(on, off, shares)
    )


def read_both(told: Sequence[Weighed]) -> Weighed:
    """By one reading or the other, each as likely; each contact as the likelier one has it."""
    if len(told) == 1:
        return told[0]
    bent, flat = told
    each = np.where((bent.known >= flat.known)[:, None], bent.each, flat.each)
    known, unlike = (np.logaddexp(a, b) - np.log(2.0) for a, b in zip(bent[1:], flat[1:], strict=True))
    return Weighed(each, known, unlike)

"""Where contacts on one flat surface are of two faces: a strip between them that is empty, and by no chance.

Contacts fall on a face like rain, rho of them on each mm^2, so a strip of it that is g wide and W long stays empty
with probability exp(-rho g W).  Two of n contacts bound some n^2 strips, so that one of them is empty by chance in
no more than a share of exp(-c) of all faces where it must have

    rho g W > 2 ln n + c                                                              (our derivation).

W is that along which contacts are seen near the strip on both its sides, so that a strip across the hollow of a
ring counts where it crosses the ring alone.  With c = 3, discs, squares and strips of 4 to 1,000 contacts were
parted in less than 1 of 100, thin rings in 3 of 100 (`tests/primitives/segmentation/test_parts.py` has some).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class StripOptions:
    """How strips are looked for."""

    surprise: float = 3.0  # c
    directions: int = 32  # in which one may run
    deep: float = 3.0  # spacings from a strip, to which contacts are near it
    beside: float = 0.35  # spacings to each side of such a contact that the face is held to reach


def apart(flat: Floats, rho: float, options: StripOptions | None = None) -> list[Ints]:
    """Rows of (n, 2) contacts [mm] by the face that they lie on, where `rho` [1/mm^2] fall on one."""
    options = options or StripOptions()
    done: list[Ints] = []
    left = [np.arange(len(flat))]
    while left:
        rows = left.pop()
        two = _emptiest(flat[rows], rho, options)
        if two is None:
            done.append(rows)
        else:
            left += [rows[two[0]], rows[two[1]]]
    return done


def _emptiest(flat: Floats, rho: float, options: StripOptions) -> tuple[Ints, Ints] | None:
    """The contacts on both sides of the strip that is least likely to be empty, if one is too unlikely."""
    n = len(flat)
    spacing = 1.0 / np.sqrt(rho)
    most, best = 2.0 * np.log(max(n, 1)) + options.surprise, None
    for turn in np.arange(options.directions) * np.pi / options.directions:
        across = flat @ np.array([np.cos(turn), np.sin(turn)])
        along = flat @ np.array([-np.sin(turn), np.cos(turn)])
        order = np.argsort(across)
        across, along = across[order], along[order]
        bound = rho * np.diff(across) * (_common(along) + 2.0 * options.beside * spacing)
        for k in np.flatnonzero(bound > most):
            low = (across <= across[k]) & (across > across[k] - options.deep * spacing)
            high = (across >= across[k + 1]) & (across < across[k + 1] + options.deep * spacing)
            width = _overlap(along[low], along[high], options.beside * spacing)
            empty = rho * (across[k + 1] - across[k]) * width
            if empty > most:
                most, best = empty, (order[: k + 1], order[k + 1 :])
    return best


def _common(along: Floats) -> Floats:
    """(n - 1,) length to which the first k and the others reach both, for every k."""
    low = np.minimum.accumulate(along)[:-1], np.minimum.accumulate(along[::-1])[::-1][1:]
    high = np.maximum.accumulate(along)[:-1], np.maximum.accumulate(along[::-1])[::-1][1:]
    return np.asarray(np.maximum(np.minimum(*high) - np.maximum(*low), 0.0))


def _overlap(first: Floats, second: Floats, beside: float) -> float:
    """Length that both sets of places cover, each place `beside` to both its sides."""
    (low, high), (other_low, other_high) = _covered(first, beside), _covered(second, beside)
    shared = np.minimum(high[:, None], other_high) - np.maximum(low[:, None], other_low)
    return float(np.maximum(shared, 0.0).sum())


def _covered(places: Floats, beside: float) -> tuple[Floats, Floats]:
    """Where the intervals round sorted places that touch one another begin, and end."""
    ordered = np.sort(places)
    cut = np.flatnonzero(np.diff(ordered) > 2.0 * beside)
    return ordered[np.r_[0, cut + 1]] - beside, ordered[np.r_[cut, len(ordered) - 1]] + beside

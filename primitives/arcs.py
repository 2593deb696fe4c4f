"""Circles through places in a plane, and the round pieces of outlines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats, Ints


@dataclass(frozen=True)
class ArcConfig:
    """When a piece of an outline is round."""

    step: float = 1.0  # [mm] between the places of an outline that are looked at
    spans: tuple[float, ...] = (6.0, 10.0, 16.0, 26.0)  # [mm] between places that a circle is laid through
    near: float = 0.35  # [mm] from the circle
    least: float = 14.0  # [mm] of an arc,
    turn: float = 2.4  # [rad] of it
    widest: float = 80.0  # [mm] of a radius
    most: int = 8  # arcs of one outline


@dataclass(frozen=True)
class Arc:
    """A round piece of an outline."""

    center: Floats  # (2,) [mm]
    radius: float  # [mm]
    turn: float  # [rad] that it goes round


def circle_through(flat: Floats) -> tuple[Floats, float] | None:
    """(2,) center and radius of the circle nearest to (n, 2) places round the origin; None where there is none."""
    x, y = flat[:, 0], flat[:, 1]
    rows = np.column_stack([2.0 * x, 2.0 * y, np.ones(len(x))])
    (cx, cy, rest), _, rank, _ = np.linalg.lstsq(rows, x**2 + y**2, rcond=None)
    squared = float(rest + cx**2 + cy**2)
    return None if rank < 3 or squared <= 0.0 else (np.array([cx, cy]), float(np.sqrt(squared)))


def around(angles: Floats) -> float:
    """[rad] of a turn that angles lie over: all of it but their widest gap."""
    angle = np.sort(angles)
    return float(2.0 * np.pi - np.diff(np.append(angle, angle[0] + 2.0 * np.pi)).max())


def evenly(rim: Floats, step: float = 1.0) -> Floats:
    """(m, 2) places about a `step` [mm] apart along a closed rim of (n, 2) corners."""
    closed = np.concatenate([rim, rim[:1]])
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    count = max(3, round(float(reached[-1]) / step))
    at = np.arange(count) * reached[-1] / count
    return np.column_stack([np.interp(at, reached, closed[:, axis]) for axis in (0, 1)])


def arcs(rim: Floats, config: ArcConfig = ArcConfig()) -> list[Arc]:
    """The round pieces of a closed rim of (n, 2) corners, the longest first; no place is of two.

    A circle is laid through every three places of it that are equally far apart along it, and the longest run on
    one of them is an arc (our derivation).
    """
    places = evenly(rim, config.step)
    on, middles = _circles(places, config)
    left, found = np.ones(len(places), dtype=bool), list[Arc]()
    while len(found) < config.most and (run := _longest(on & left, middles)) is not None:
        if run.sum() * config.step < config.least:
            break
        left &= ~run
        if (arc := _fitted(places[run], config)) is not None:
            found.append(arc)
    return found


def _circles(places: Floats, config: ArcConfig) -> tuple[Bools, Ints]:
    """(k, n) which of n places lie on each of k circles, and (k,) the middle one that each was laid through."""
    n, on, middles = len(places), [np.empty((0, len(places)), dtype=bool)], [np.empty(0, dtype=np.int64)]
    for span in config.spans:
        k = round(span / config.step)
        if 3 * k <= n:
            at = np.arange(0, n, max(1, k // 3))
            center, radius = _through(*(places[(at + shift) % n] for shift in (-k, 0, k)))
            away = np.linalg.norm(places[None] - center[:, None], axis=2)
            on.append((np.abs(away - radius[:, None]) < config.near) & (radius[:, None] < config.widest))
            middles.append(at)
    return np.concatenate(on), np.concatenate(middles)


def _through(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """(k, 2) centers and (k,) radii of circles through three (k, 2) places each; without end on a line."""
    ab, ac = b - a, c - a
    twice = 2.0 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
    twice = np.where(np.abs(twice) < 1e-9, 1e-9, twice)
    b2, c2 = (ab**2).sum(axis=1), (ac**2).sum(axis=1)
    off = np.column_stack([ac[:, 1] * b2 - ab[:, 1] * c2, ab[:, 0] * c2 - ac[:, 0] * b2]) / twice[:, None]
    return a + off, np.linalg.norm(off, axis=1)


def _longest(on: Bools, middles: Ints) -> Bools | None:
    """(n,) the longest run of places that hang together, round the end of the row, of those on one circle."""
    if not len(on):
        return None
    n = on.shape[1]
    turned = np.take_along_axis(on, (middles[:, None] + np.arange(n)) % n, axis=1)
    ahead = np.where(turned.all(axis=1), n, np.argmin(turned, axis=1))
    behind = np.where(ahead == n, 0, np.argmin(turned[:, ::-1], axis=1))
    best = int(np.argmax(np.where(turned[:, 0], ahead + behind, 0)))
    if not turned[best, 0]:
        return None
    run = np.zeros(n, dtype=bool)
    run[(middles[best] + np.arange(-behind[best], ahead[best])) % n] = True
    return run


def _fitted(places: Floats, config: ArcConfig) -> Arc | None:
    """The arc of a run of places, where that turns far enough."""
    middle = places.mean(axis=0)
    made = circle_through(places - middle)
    if made is None or made[1] > config.widest:
        return None
    center, radius = middle + made[0], made[1]
    turn = around(np.arctan2(*(places - center).T[::-1]))
    return Arc(center, radius, turn) if turn > config.turn else None

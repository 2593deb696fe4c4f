"""Circles through places in a plane, and the round pieces of outlines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats


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
    left, found = np.ones(len(places), dtype=bool), list[Arc]()
    while len(found) < config.most:
        run = _longest(places, left, config)
        if run is None:
            break
        left &= ~run
        if (arc := _fitted(places[run], config)) is not None:
            found.append(arc)
    return found


def _longest(places: Floats, left: Bools, config: ArcConfig) -> Bools | None:
    """(n,) the longest run of the places that are left, all near one circle through three of them."""
    best, found = config.least / config.step, None
    for span in config.spans:
        k = round(span / config.step)
        if 3 * k > len(places):
            continue
        for i in np.flatnonzero(left)[:: max(1, k // 3)]:
            three = places[[i, (i + k) % len(places), (i + 2 * k) % len(places)]]
            made = circle_through(three - three.mean(axis=0))
            if made is None or made[1] > config.widest:
                continue
            away = np.linalg.norm(places - three.mean(axis=0) - made[0], axis=1)
            on = left & (np.abs(away - made[1]) < config.near)
            run = _run_of(on, int(i))
            if run.sum() > best:
                best, found = float(run.sum()), run
    return found


def _run_of(on: Bools, i: int) -> Bools:
    """(n,) those `on` that hang together with place i, round the end of the row."""
    n = len(on)
    turned = np.roll(on, -i)
    gaps = np.flatnonzero(~turned)
    out = np.ones(n, dtype=bool)
    if len(gaps):
        out[gaps[0] : gaps[-1] + 1] = False
    return np.roll(out & turned, i)


def _fitted(places: Floats, config: ArcConfig) -> Arc | None:
    """The arc of a run of places, where that turns far enough."""
    middle = places.mean(axis=0)
    made = circle_through(places - middle)
    if made is None or made[1] > config.widest:
        return None
    center, radius = middle + made[0], made[1]
    angle = np.sort(np.arctan2(*(places - center).T[::-1]))
    turn = float(2.0 * np.pi - np.diff(np.append(angle, angle[0] + 2.0 * np.pi)).max())
    return Arc(center, radius, turn) if turn > config.turn else None

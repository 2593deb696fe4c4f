"""Which objects of a library a sensor cannot tell apart, before anything is touched.

Let B lie on A as well as it can (`overlay`).  A contact at a point of A that lies d from B has the log-likelihood
ratio of mean d^2 / 2 sigma^2 and variance d^2 / sigma^2, so after contacts with distances d_i the likelier of the
two is the wrong one with probability (our derivation, two Gaussians at equal odds)::

    Phi(-D / 2),   D^2 = sum d_i^2 / sigma^2:   0.5 for equal objects, never more.

`probability` takes those places on either that differ most and that the array can reach, `budget` of them: what
the sensor itself cannot do better than.  `after_random` takes contacts anywhere within reach, by area, and is the
mean over which of the two is there; it is what touching blindly leaves.  The pose is taken to be as well known as
the overlay needs.  Pairs whose surfaces differ in their principal radii by more than `gate` are left out: blind
touches tell them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.special import ndtr

from exploration.sensing.spec import SensorSpec
from models.library import Entry, Library, SampleConfig, SurfaceSamples, surface_samples
from primitives.arrays import Bools, Floats, frozen
from primitives.pose import inverse, transform_points
from recognition.confusable.overlay import Spread, overlay, spread_of
from recognition.confusable.reach import touchable


@dataclass(frozen=True)
class ConfusableConfig:
    """What is looked at, and what counts as told apart."""

    gate: float = 0.08  # of the greatest principal radius; radii that differ by more are told by any touches
    samples: int = 6000  # on each of a pair that is looked at
    least: int = 12  # samples on a face
    budget: int = 3  # touches that may be chosen
    random: tuple[int, ...] = (12, 50)  # contacts anywhere
    told: float = 0.01  # probability of the wrong name below which a pair counts as told apart
    differs: float = 4.0  # standard deviations of a contact from which a place counts as different
    counted: float = 3.0  # standard deviations that one contact counts for where a pair is left out
    apart: float = 12.0  # [mm] between places that are proposed
    asked: int = 60  # places that are tried for reach, the most telling first


@dataclass(frozen=True, eq=False)
class Separation:
    """A touch that tells two objects apart."""

    on: str  # the object whose surface has the point
    point: Floats  # (3,) [mm] in its frame
    normal: Floats  # (3,) outward
    gap: float  # [mm] from the other object's surface there

    def as_json(self) -> dict[str, Any]:
        """As `library confusable` lists it."""
        return {
            "on": self.on,
            "point_mm": self.point.tolist(),
            "normal": self.normal.tolist(),
            "gap_mm": self.gap,
        }


@dataclass(frozen=True, eq=False)
class Pair:
    """Two objects that blind touches do not tell at once."""

    a: str
    b: str
    probability: float  # of naming the wrong one after the best touches
    after_random: dict[int, float]  # the same after so many contacts anywhere
    share: float  # of the surfaces' area that differs, within reach or not
    touches: tuple[Separation, ...]  # the best ones; none where even they leave more than `told`
    b_from_a: Floats  # (4, 4) the overlay


def confusable(
    library: Library,
    sensor: SensorSpec,
    sigma: float,
    config: ConfusableConfig | None = None,
    watch: Callable[[int, int, str], object] | None = None,
) -> list[Pair]:
    """The pairs that are alike for a contact's `sigma` [mm], the most alike first."""
    config, told = config or ConfusableConfig(), watch or (lambda done, of, last: None)
    names = list(library)
    spreads = {name: spread_of(library[name]) for name in names}
    close = [(a, b) for a, b in combinations(names, 2) if _close(spreads[a], spreads[b], config.gate, sigma)]
    dense: dict[str, SurfaceSamples] = {}
    found = []
    for done, (a, b) in enumerate(close, 1):
        told(done, len(close), f"{a}, {b}")
        b_from_a = _laid(library[a], library[b])
        if _plain(library[a], library[b], b_from_a, sigma, config):
            continue
        for name in {a, b} - dense.keys():
            dense[name] = surface_samples(library[name].solid, SampleConfig(config.samples, config.least))
        pair = _compared(library[a], library[b], b_from_a, dense[a], dense[b], sensor, sigma, config)
        if max(pair.probability, pair.after_random[config.random[0]]) >= config.told:
            found.append(pair)
    return sorted(found, key=lambda p: (-p.probability, -p.after_random[config.random[0]]))


def _close(a: Spread, b: Spread, gate: float, sigma: float) -> bool:
    return bool(np.abs(a.radii - b.radii).max() <= gate * max(a.radii[0], b.radii[0]) + 4 * sigma)


def _laid(a: Entry, b: Entry) -> Floats:
    """The overlay of the object with less surface on the other: walls that only one has pull at neither."""
    if a.samples.area.sum() <= b.samples.area.sum():
        return overlay(a, b)
    return inverse(overlay(b, a))


def _plain(a: Entry, b: Entry, b_from_a: Floats, sigma: float, config: ConfusableConfig) -> bool:
    """Whether a few contacts anywhere tell two objects, so that no closer look is needed."""
    worst = 0.0  # of both ways: a hollow inside one of them shows on that one's surface only
    for mine, other, motion in ((a, b, b_from_a), (b, a, inverse(b_from_a))):
        z = np.abs(other.field.signed_distance(transform_points(motion, mine.samples.points))) / sigma
        worst = max(worst, _blind(mine.samples, np.minimum(z, config.counted), config)[config.random[0]])
    return worst < config.told / 100


def _compared(
    a: Entry,
    b: Entry,
    b_from_a: Floats,
    on_a: SurfaceSamples,
    on_b: SurfaceSamples,
    sensor: SensorSpec,
    sigma: float,
    config: ConfusableConfig,
) -> Pair:
    sides = []
    for mine, samples, other, motion in ((a, on_a, b, b_from_a), (b, on_b, a, inverse(b_from_a))):
        away = np.abs(other.solid.signed_distance(transform_points(motion, samples.points)))
        sides.append(_side(mine, samples, away / sigma, sensor, config))
    spots = sorted(
        (Separation(entry.name, s.points[k], s.normals[k], float(z[k] * sigma))
         for entry, s, z, places in ((a, on_a, *sides[0][:2]), (b, on_b, *sides[1][:2])) for k in places),
        key=lambda spot: -spot.gap,
    )  # fmt: skip
    best = tuple(spots[: config.budget])
    strength = np.sqrt(sum((spot.gap / sigma) ** 2 for spot in best))
    return Pair(
        a.name,
        b.name,
        float(ndtr(-strength / 2)),
        {n: float(np.mean([side[3][n] for side in sides])) for n in config.random},
        float(np.mean([side[2] for side in sides])),
        best if ndtr(-strength / 2) < config.told else (),
        frozen(b_from_a),
    )


_Side = tuple[Floats, list[int], float, dict[int, float]]


def _side(
    entry: Entry, samples: SurfaceSamples, z: Floats, sensor: SensorSpec, config: ConfusableConfig
) -> _Side:
    """Distances in sigmas, the places to propose, the share that differs, and the error after blind touches."""
    differs = z >= config.differs
    share = float(samples.area[differs].sum() / samples.area.sum())
    order = np.argsort(-z, kind="stable")
    places: list[int] = []
    tried: list[int] = []
    reached: list[int] = []
    for k in order[: config.samples]:
        if len(places) >= config.budget or len(tried) >= config.asked:
            break
        if any(np.linalg.norm(samples.points[k] - samples.points[j]) < config.apart / 4 for j in tried):
            continue
        if z[k] < 0.5:
            break
        tried.append(int(k))
        if touchable(entry, samples.points[[k]], samples.normals[[k]], sensor)[0]:
            reached.append(int(k))
            if all(np.linalg.norm(samples.points[k] - samples.points[j]) > config.apart for j in places):
                places.append(int(k))
    blind = _blind(samples, np.where(_within_reach(samples, tried, reached, differs), z, 0.0), config)
    return z, places, share, blind


def _within_reach(samples: SurfaceSamples, tried: list[int], reached: list[int], differs: Bools) -> Bools:
    """(n,) whether each sample can be touched: as the nearest that was tried; only what differs is asked."""
    out = np.ones(len(samples), dtype=bool)
    if tried and differs.any():
        rows = np.flatnonzero(differs)
        apart = np.linalg.norm(samples.points[rows, None] - samples.points[None, tried], axis=2)
        out[rows] = np.isin(np.array(tried)[apart.argmin(axis=1)], reached)
    return out


def _blind(samples: SurfaceSamples, z: Floats, config: ConfusableConfig) -> dict[int, float]:
    rng = np.random.default_rng(0)
    share = samples.area / samples.area.sum()
    out = {}
    for n in config.random:
        drawn = rng.choice(len(z), size=(2000, n), p=share)
        out[n] = float(ndtr(-np.sqrt((z[drawn] ** 2).sum(axis=1)) / 2).mean())
    return out

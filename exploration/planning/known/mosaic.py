"""A flat face as the pad's images show it, put side by side: where it is under the skin, and where it is not.

A taxel of a pad that lies on a plane is pressed as deep as the plane stands before it where the face is there, and
not at all past its rim; between the two the rubber's spread makes a soft step, half way at the rim.  So the share
of that depth which each taxel has, image beside image and weighed by its noise, is a picture of the face, finer
than the taxels are apart, and its rim is where the share is one half (our derivation).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from exploration.devices.guard import Observation
from primitives.arrays import Bools, Floats
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class MosaicConfig:
    """Which images count, and how fine the picture is."""

    flush: float = 0.9985  # least cosine between the pad's normal and the face's
    pressed: tuple[float, float] = (0.15, 2.5)  # [mm] of the plane before a taxel
    step: float = 0.5  # [mm] between places of the picture
    blur: float = 0.8  # [mm] over which images are joined
    known: float = 20.0  # squared depths over squared noises, from which a place is known
    most: float = 1.5  # of the share of one taxel, which a higher face may press on
    square: float = 0.035  # most cosine between the pad's normal and the axis of a cylinder that it lies on
    beside: float = 2.0  # [mm] from the line on which it lies, where a taxel tells of it,
    round: float = 0.7  # or of its radius, where it tells of the place under it
    nothing: tuple[float, float] = (
        0.15,
        0.06,
    )  # of how deep a cylinder stands before taxels, and [mm], to which they are pressed where nothing is


@dataclass(frozen=True)
class Picture:
    """Of one face, on a lattice in its plane."""

    share: Floats  # (n, m) of the face under the skin: 1 where it is there, 0 where it is not
    known: Bools  # (n, m)

    @property
    def there(self) -> Bools:
        """(n, m)."""
        return np.asarray(self.known & (self.share > 0.5))


@dataclass(frozen=True)
class Lattice:
    """Places in a plane: origin + step (i, j), along two directions."""

    along: Floats  # (3, 2) columns
    origin: Floats  # (2,) [mm] along them
    step: float  # [mm]
    shape: tuple[int, int]

    @staticmethod
    def over(places: Floats, along: Floats, step: float, margin: float) -> Lattice:
        """Of (n, 3) places, and so many mm more all round."""
        flat = places @ along
        low = flat.min(axis=0) - margin
        count = np.ceil((flat.max(axis=0) + margin - low) / step).astype(int) + 1
        return Lattice(along, low, step, (int(count[0]), int(count[1])))


@dataclass(frozen=True)
class Band:
    """Of a cylinder: by sectors round its axis and by heights along it."""

    share: Floats  # (sectors, n) of the face under the skin
    known: Bools  # (sectors, n)
    heights: Floats  # (n,) [mm] from the cylinder's anchor


@dataclass(frozen=True)
class Unrolled:
    """Of a cylinder: by heights along it and by turns round its axis."""

    share: Floats  # (n, m) of the face under the skin
    known: Bools  # (n, m)
    edge: Floats  # (n, m) beyond one half, the share at an edge whose wall lies on the side of growing turns
    heights: Floats  # (n,) [mm] from the cylinder's anchor
    turns: Floats  # (m,) [rad] in its frame, once round

    def part(self, rows: slice, column: int) -> Unrolled:
        """Some rows, from another column on; turns are from that."""
        share, edge = (np.roll(lot[rows], -column, axis=1) for lot in (self.share, self.edge))
        known = np.roll(self.known[rows], -column, axis=1)
        return Unrolled(share, known, edge, self.heights[rows], self.turns)


@dataclass(frozen=True)
class Lain:
    """The image of a pad that lay on a plane."""

    places: Floats  # (n, 3) [mm] of the taxels
    before: Floats  # (n,) [mm] that the plane stands before each of them
    depth: Floats  # (n,) [mm] that each is pressed in
    sigma: Floats  # (n,) [mm] of that
    spread: float  # [mm] of the rubber


@dataclass(frozen=True)
class _Image:
    pose: Floats  # (4, 4) world_from_sensor
    places: Floats  # (n, 3) [mm] of the taxels in the world, on the skin at rest
    depth: Floats  # (n,) [mm]
    sigma: Floats  # (n,) [mm]
    spread: float  # [mm] of the rubber


class Mosaic:
    """Grows with every image."""

    def __init__(self, config: MosaicConfig = MosaicConfig()) -> None:
        self.config = config
        self._images: list[_Image] = []

    def __len__(self) -> int:
        """How many images there are."""
        return len(self._images)

    def look(self, seen: Observation, own: Callable[[Floats], Bools] | None = None) -> None:
        """Remember an image, where (n, 3) places are the object's `own` or nothing's."""
        array, pose = seen.image.array, seen.world_from_sensor
        x, y = np.meshgrid(array.x, array.y)
        depth, sigma = seen.image.depth.ravel(), seen.image.sigma.ravel()
        whole = np.isfinite(depth) & np.isfinite(sigma)  # not of dead taxels
        flat = np.column_stack([x.ravel(), y.ravel()])[whole]
        places = pose[:3, 3] + flat @ pose[:3, :2].T
        mine = np.ones(len(places), dtype=bool) if own is None else own(places)
        depth, sigma = depth[whole][mine], sigma[whole][mine]
        self._images.append(_Image(pose, places[mine], depth, sigma, seen.image.spread))

    def band(self, shape: Cylinder, low: float, high: float, sectors: int = 12) -> Band:
        """Of a convex cylinder between two heights [mm] from its anchor."""
        config, count = self.config, int(np.ceil((high - low) / self.config.step)) + 1
        sums, weights = np.zeros((2, sectors, count))
        for image in self._images:
            out = _lying_along(image, shape, config.square)
            if out is None:
                continue
            away = image.places - shape.anchor
            cell = np.round((away @ shape.direction - low) / config.step).astype(np.int64)
            before, aside = (
                -shape.signed_distance(image.places),
                np.abs(away @ np.cross(shape.direction, out)),
            )
            on = (before > config.pressed[0]) & (before < config.pressed[1]) & (cell >= 0) & (cell < count)
            on &= (aside < config.beside) & (away @ out > 0.0)
            turn = np.arctan2(*(shape.frame[:, 1::-1].T @ out))
            sector = int((turn / (2.0 * np.pi) % 1.0) * sectors) % sectors
            weight = (before[on] / image.sigma[on]) ** 2
            each = np.clip(image.depth[on] / before[on], -config.most, config.most)
            sums[sector] += np.bincount(cell[on], weight * each, count)
            weights[sector] += np.bincount(cell[on], weight, count)
        blur = config.blur / config.step
        sums, weights = (gaussian_filter1d(lot, blur, axis=1, mode="constant") for lot in (sums, weights))
        known = weights > config.known
        share: Floats = np.divide(sums, weights, out=np.zeros_like(sums), where=known)
        return Band(share, known, low + config.step * np.arange(count, dtype=np.float64))

    def bare(self, shape: Cylinder, over: Callable[[Floats], Bools]) -> float:
        """How deep under a convex cylinder [mm] skin came and felt nothing, over some (n, 3) places; 0 for none.

        Walls beside these should be farther off than the rubber spreads.
        """
        config, deepest = self.config, 0.0
        for image in self._images:
            out = _lying_along(image, shape, config.square)
            if out is None:
                continue
            away = image.places - shape.anchor
            on = (np.abs(away @ np.cross(shape.direction, out)) < config.beside) & (away @ out > 0.0)
            on &= over(image.places)
            if on.sum() > 1:
                before = float(np.median(-shape.signed_distance(image.places[on])))
                share, most = config.nothing
                if float(image.depth[on].mean()) < min(share * before, most):
                    deepest = max(deepest, before)
        return deepest

    def unrolled(self, shape: Cylinder, low: float, high: float) -> Unrolled:
        """Of a convex cylinder between two heights [mm] from its anchor, each place under the taxel over it.

        Rubber that spreads with a Gaussian reads b / 2 + s spread / sqrt(2 pi) at the edge of a wall that stands b
        before it and rises by s from there on: on a cylinder, less than half beside the line that the pad lies on.
        """
        config, rows = self.config, int(np.ceil((high - low) / self.config.step)) + 1
        columns = max(round(2.0 * np.pi * shape.radius / config.step), 8)
        sums, edges, weights = np.zeros((3, rows * columns))
        for image in self._images:
            out = _lying_along(image, shape, config.square)
            if out is None:
                continue
            aside = np.cross(shape.direction, out)
            away = image.places - shape.anchor
            across = away @ aside
            level = np.sqrt(np.maximum(shape.radius**2 - across**2, 0.0))
            before = level - away @ out
            place = (np.outer(across, aside) + np.outer(level, out)) @ shape.frame[:, :2]
            turn = np.arctan2(place[:, 1], place[:, 0]) / (2.0 * np.pi)
            row = np.round((away @ shape.direction - low) / config.step).astype(np.int64)
            on = (np.abs(across) < config.round * shape.radius) & (row >= 0) & (row < rows)
            on &= (before > config.pressed[0]) & (before < config.pressed[1])
            cell = row[on] * columns + np.round(turn[on] * columns).astype(np.int64) % columns
            weight = (before[on] / image.sigma[on]) ** 2
            each = np.clip(image.depth[on] / before[on], -config.most, config.most)
            spread = float(np.hypot(image.spread, config.blur))
            rise = -across[on] / level[on] * spread / (np.sqrt(2.0 * np.pi) * before[on])
            sums += np.bincount(cell, weight * each, len(sums))
            edges += np.bincount(cell, weight * np.clip(rise, -0.5, 0.5), len(sums))
            weights += np.bincount(cell, weight, len(sums))
        sums, edges, weights = (
            gaussian_filter(lot.reshape(rows, columns), config.blur / config.step, mode=("constant", "wrap"))
            for lot in (sums, edges, weights)
        )
        known = weights > config.known
        share, edge = (np.divide(lot, weights, out=np.zeros_like(lot), where=known) for lot in (sums, edges))
        heights = low + config.step * np.arange(rows, dtype=np.float64)
        return Unrolled(share, known, edge, heights, 2.0 * np.pi * np.arange(columns) / columns)

    def pictured(self, anchor: Floats, normal: Floats) -> Floats:
        """(n, 3) [mm] the middles of pads that lay on the plane through a (3,) place, of (3,) outward normal."""
        return np.array([image.pose[:3, 3] for image in self._flush(anchor, normal)]).reshape(-1, 3)

    def _flush(self, anchor: Floats, normal: Floats) -> list[_Image]:
        low, high = self.config.pressed
        return [
            image
            for image in self._images
            if -float(image.pose[:3, 2] @ normal) > self.config.flush
            and low < float((anchor - image.pose[:3, 3]) @ normal) < high
        ]

    def flush(self, anchor: Floats, normal: Floats) -> list[Lain]:
        """What each pad that lay on the plane through a (3,) place, of (3,) outward normal, has of it."""
        return [
            Lain(image.places, (anchor - image.places) @ normal, image.depth, image.sigma, image.spread)
            for image in self._flush(anchor, normal)
        ]

    def picture(self, anchor: Floats, normal: Floats, lattice: Lattice) -> Picture:
        """Of the plane through a (3,) place, of (3,) outward normal, on a lattice in it."""
        low, high = self.config.pressed
        flush = self._flush(anchor, normal)
        if not flush:
            return Picture(np.zeros(lattice.shape), np.zeros(lattice.shape, dtype=bool))
        places, depth, sigma = (
            np.concatenate([getattr(image, name) for image in flush]) for name in ("places", "depth", "sigma")
        )
        before = (anchor - places) @ normal
        cell = np.round((places @ lattice.along - lattice.origin) / lattice.step).astype(np.int64)
        on = (before > low) & (before < high) & ((cell >= 0) & (cell < lattice.shape)).all(axis=1)
        where, before = cell[on] @ [lattice.shape[1], 1], before[on]
        share = np.clip(depth[on] / before, -self.config.most, self.config.most)
        weight = (before / sigma[on]) ** 2
        sums, weights = (
            gaussian_filter(
                np.bincount(where, lot, int(np.prod(lattice.shape))).reshape(lattice.shape).astype(float),
                self.config.blur / lattice.step,
            )
            for lot in (weight * share, weight)
        )
        known = weights > self.config.known
        return Picture(np.divide(sums, weights, out=np.zeros_like(sums), where=known), known)


def _lying_along(image: _Image, shape: Cylinder, square: float) -> Floats | None:
    """(3,) the way out of a cylinder on which a pad lies along its axis; None where it does not."""
    out = -image.pose[:3, 2]
    up = float(out @ shape.direction)
    return None if abs(up) > square else np.asarray((out - up * shape.direction) / np.sqrt(1.0 - up**2))

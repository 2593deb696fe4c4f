"""Flat faces that were felt, and the stretches of the lines on which two of them meet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class Flat:
    """A flat face."""

    normal: Floats  # (3,) outward
    offset: float  # [mm]
    felt: Floats  # (n, 3) places


@dataclass(frozen=True)
class Stretch:
    """Of the line on which two flat faces meet, as much as both were felt beside."""

    corner: Floats  # (3,) [mm] on it
    along: Floats  # (3,)
    low: float  # [mm] along it
    high: float

    @staticmethod
    def of(one: Flat, other: Flat, near: Sequence[Floats], ends: float) -> Stretch | None:
        """Beside (n, 3) places of each face near it, less `ends` [mm] at either end; None where one has none."""
        if not all(len(places) for places in near):
            return None
        along: Floats = np.cross(one.normal, other.normal)
        along = along / np.linalg.norm(along)
        planes = np.stack([one.normal, other.normal, along])
        corner = np.asarray(np.linalg.solve(planes, [one.offset, other.offset, 0.0]), dtype=np.float64)
        low = max(float((places @ along).min()) for places in near) + ends
        high = min(float((places @ along).max()) for places in near) - ends
        return Stretch(corner, along, low, high)

    @property
    def length(self) -> float:
        """[mm]; negative where they were felt beside different parts of it."""
        return self.high - self.low

    def beside(self, places: Floats) -> Bools:
        """(n,) which of (n, 3) places are beside it."""
        at = places @ self.along
        return np.asarray((at > self.low) & (at < self.high))

    def rows(self, count: int) -> Floats:
        """(count, 3) [mm] from the corner to places along it."""
        return np.outer(np.linspace(self.low, self.high, count), self.along)


def flats(faces: Sequence[Face]) -> Iterator[Flat]:
    """Flat faces that were felt."""
    for face in faces:
        if isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane):
            felt = face.contacts.select(face.contacts.touch != NOT_FELT)
            if len(felt):
                plane = face.fit.shape
                way = plane.direction * (
                    1.0 if float(np.nanmean(felt.normals @ plane.direction)) > 0.0 else -1.0
                )
                yield Flat(way, float(plane.anchor @ way), felt.points)


def from_wall(fit: Fit) -> Callable[[Floats], Floats]:
    """[mm] inside of where a cylinder's or hole's wall would meet its end, of (n, 3) places."""
    side = -1.0 if fit.convex else 1.0
    return lambda places: side * fit.shape.signed_distance(places)

"""A hand without a tactile image: contacts by ray casting, with a stated noise, for many identifications.

The pad comes down, rolls flush about the first place that it meets, and feels what lies within its press: four
contacts of a flat patch, one of a curved one, a bare point where it cannot lie flush.  All contacts of one touch,
and what the skin feels, share an error of the place and one of the attitude, as those of one stage pose do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter

from exploration.devices.guard import Cost
from exploration.planning.touching.lone_touch import Approach, LoneTouch
from exploration.planning.touching.pace import Pace
from exploration.planning.ways.round_ball import Ball, length_of, way_out, way_round
from exploration.planning.ways.search import sweeps
from models.solid import Solid
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import Contacts, FreeSpace, Imprint
from primitives.pose import pose, rotation_exp

ROWS, COLUMNS, PITCH = 10, 16, 1.8
PRESS = 0.6  # [mm]
SPREAD = 1.2  # [mm] of the rubber
FINE = 3  # rays a taxel, along x and along y
DEEP = 30.0  # [mm] from the skin to the housing's back


@dataclass(frozen=True)
class RayNoise:
    """What touches of one kind get wrong, 1 sigma."""

    place: float = 0.1  # [mm] of a touch, along its normal
    turn: float = 0.01  # [rad] of a touch
    each: float = 0.02  # [mm] of a contact, besides
    flat: float = 0.04  # [mm] a patch that departs less from a plane counts as flat
    taxel: float = 0.01  # [mm] of what one taxel feels
    aslant: float = 0.75  # cosine of the lean beyond which the housing meets the object first,
    steep: float = 0.35  # and beyond which coming again does not help


@dataclass
class RayHand:
    """On a stage that is where it is told to be."""

    solid: Solid  # at its pose
    rng: np.random.Generator
    noise: RayNoise = field(default_factory=RayNoise)
    cost: Cost = field(default_factory=Cost)
    here: Floats = field(default_factory=lambda: pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 300.0]))
    pad: tuple[float, float] = (COLUMNS * PITCH, ROWS * PITCH)
    pace: Pace = field(default_factory=Pace)
    _back: Floats | None = None

    def find(self, box: Floats) -> Iterator[LoneTouch]:
        """Downward, from the box's middle outward."""
        for start, end in sweeps(box, self.pad):
            length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
            self._go([start])
            made = self._made(Approach(start, length))
            yield made
            if made.met and len(made.contacts):
                return
            self.leave()

    def touch(self, approach: Approach, ball: Ball) -> LoneTouch:
        """Round the ball, and down."""
        self._go(way_round(self.here, approach.start, ball))
        return self._made(approach)

    def leave(self, ball: Ball | None = None) -> None:
        """Back to where the approach began, or only out of the ball."""
        if self._back is not None:
            self._go([self._back if ball is None else way_out(self.here, self._back, ball)])
            self._back = None

    def reachable(self, approach: Approach) -> bool:
        """Everywhere."""
        return True

    def _go(self, way: list[Floats]) -> None:
        self.cost.seconds += self.pace.travel(self.here, way)
        self.cost.travel += length_of(self.here, way)[0]
        self.here = way[-1]

    def _made(self, approach: Approach) -> LoneTouch:
        self.cost.touches += 1
        number, self._back = self.cost.touches, approach.start
        cast = self.solid.cast_rays(*_rays(approach.start))
        k = int(np.argmin(cast.distance))
        met = bool(cast.distance[k] <= approach.length)
        depth = float(cast.distance[k]) if met else approach.length
        if approach.flown:
            self._go([approach.felt.start])
        felt = max(depth - approach.flown, 0.0)
        self.cost.seconds += float(self.pace.approach(0.0, felt)) + self.pace.settling * met
        self.cost.travel += felt
        lying = approach.start @ pose(np.eye(3), [0.0, 0.0, depth])
        swept = _box(lying, felt)
        normal = cast.normals[k] if met else np.zeros(3)
        self.here = lying
        facing = float(-normal @ lying[:3, 2])
        self.cost.seconds += self.pace.failing * (met and facing < self.noise.aslant)
        if not met or facing < self.noise.steep:
            note = "the housing was in the way" if met else "nothing"
            return LoneTouch(number, approach, Contacts.of([]), (), swept, False, note, lying)
        self.cost.strokes += 1
        point = _rays(approach.start)[0][k] + depth * approach.direction
        axis = np.cross(lying[:3, 2], -normal)
        angle = np.arctan2(np.linalg.norm(axis), float(-normal @ lying[:3, 2]))
        turn = rotation_exp(axis / max(float(np.linalg.norm(axis)), 1e-12) * angle)
        self.here = pose(turn @ lying[:3, :3], point + turn @ (lying[:3, 3] - point))
        return self._felt(number, approach, swept, point, normal)

    def _felt(
        self, number: int, approach: Approach, swept: FreeSpace, point: Floats, normal: Floats
    ) -> LoneTouch:
        origins, ways = _rays(self.here)
        cast = self.solid.cast_rays(origins - 15.0 * ways, ways)
        gap = cast.distance - 15.0
        if (gap < -0.3).any():
            bare = point + 0.3 * self.rng.standard_normal(3)
            contacts = Contacts.of(bare, None, 0.4, touch=number)
            return LoneTouch(number, approach, contacts, (), swept, True, "something sharp", self.here)
        touched = gap < PRESS - 0.1
        tilt = rotation_exp(self.noise.turn * self.rng.standard_normal(3))
        shift = self.noise.place * self.rng.standard_normal()
        contacts = self._contacts(number, origins, gap, touched, point, normal, tilt, shift)
        free = gap > PRESS + 0.2
        untouched = (
            origins[free] + PRESS * self.here[:3, 2] if contacts.has_normal.all() else np.empty((0, 3))
        )
        middle = contacts.points.mean(axis=0)
        told = pose(tilt @ self.here[:3, :3], middle + tilt @ (self.here[:3, 3] - middle) + shift * normal)
        return LoneTouch(
            number, approach, contacts, (), swept, True, "a face", self.here, untouched,
            self._imprint(told, number),
        )  # fmt: skip

    def _imprint(self, told: Floats, touch: int) -> Imprint:
        """What every taxel feels, at the pose that the stage tells."""
        origins, ways = _rays(self.here, FINE)
        gap = self.solid.cast_rays(origins - 3.0 * ways, ways).distance - 3.0
        dent = np.maximum(PRESS - gap, 0.0).reshape(ROWS * FINE, COLUMNS * FINE)
        felt = gaussian_filter(dent, SPREAD * FINE / PITCH, mode="reflect")
        felt = felt.reshape(ROWS, FINE, COLUMNS, FINE).mean(axis=(1, 3))
        x, y = ((np.arange(n) - 0.5 * (n - 1)) * PITCH for n in (COLUMNS, ROWS))
        noise = self.noise.taxel
        felt = felt + noise * self.rng.standard_normal(felt.shape)
        # the pad at the press: its undented skin lies that much past the surface
        told = told @ pose(np.eye(3), [0.0, 0.0, PRESS])
        return Imprint(told, x, y, felt, np.full(felt.shape, noise), SPREAD, 0.0, touch)

    def _contacts(
        self,
        number: int,
        origins: Floats,
        gap: Floats,
        touched: Bools,
        point: Floats,
        normal: Floats,
        tilt: Floats,
        shift: float,
    ) -> Contacts:
        noise, way = self.noise, self.here[:3, 2]
        if touched.sum() >= 12 and float(np.ptp(gap[touched])) < noise.flat:
            local = (origins[touched] - self.here[:3, 3]) @ self.here[:3, :2]
            values, vectors = np.linalg.eigh(np.cov(local.T))
            arms = np.sqrt(2.0 * np.maximum(values, 0.1)) * vectors
            at = local.mean(axis=0) + np.concatenate([arms.T, -arms.T])
            at = local[np.linalg.norm(at[:, None] - local, axis=2).argmin(axis=1)]
            middle = self.here[:3, 3] + self.here[:3, :2] @ local.mean(axis=0)
            places = self.here[:3, 3] + at @ self.here[:3, :2].T + float(gap[touched].mean()) * way
            places = middle + (places - middle) @ tilt.T
        else:
            places = point[None]
        places = places + (shift + noise.each * self.rng.standard_normal((len(places), 1))) * normal
        sigma = float(np.hypot(noise.place, noise.each))
        return Contacts.of(
            places, np.tile(tilt @ normal, (len(places), 1)), sigma, noise.turn, touch=number, stroke=number
        )


def _rays(at: Floats, fine: int = 1) -> tuple[Floats, Floats]:
    """Row by row over the skin, or so many times finer."""
    x, y = ((np.arange(n * fine) - 0.5 * (n * fine - 1)) * PITCH / fine for n in (COLUMNS, ROWS))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    origins = at[:3, 3] + grid @ at[:3, :2].T
    return origins, np.ascontiguousarray(np.broadcast_to(at[:3, 2], origins.shape))


def _box(lying: Floats, length: float) -> FreeSpace:
    depth = length + DEEP
    half = 0.5 * np.array([COLUMNS * PITCH, ROWS * PITCH, depth])
    at = lying @ pose(np.eye(3), [0.0, 0.0, -0.15 - 0.5 * depth])
    return FreeSpace(frozen(at[None]), frozen(half[None]))

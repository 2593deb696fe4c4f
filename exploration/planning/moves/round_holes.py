"""Round holes that no array has room in: their rims looked at, and what lies between two of them inferred.

The pad lies over a rim and averages; one circle explains all frames (`sensing.lines.round_hole`).  Two rims of
one radius on one axis, in faces that look away from each other, are taken for the ends of one hole.  That is
likely and not measured, so its wall is marked as inferred.  A rim with no such partner, into which an array went,
is a hole as deep as that; any other tells of its depth nothing (our derivation).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from exploration.control.dwell import dwell
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.round_hole import RoundHole, fit_round_hole
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Shape

_ALONG = np.array([-0.35, 0.0, 0.35])  # of a hole's depth, from its middle, where its wall is


@dataclass(frozen=True)
class RoundHolesConfig:
    """How rims are looked at, and when two are of one hole."""

    frames: int = 16  # averaged
    under: float = 0.35  # of the pad's shorter side: a hole of less radius is seen whole by one look
    looks: int = 4  # at a larger one
    most: int = 6  # touches for one rim
    over: float = 1.5  # [mm] of the pad's middle outside the rim of a large one
    apart: float = 0.6  # [rad] between two looks
    off: float = 2.5  # [mm] of the pad from the face, that it lies on yet
    flush: float = 0.93  # least cosine between the two, likewise
    upright: float = 0.1  # most cosine between a hole's axis and the face behind an edge beside it
    edge: float = 40.0  # [mm] from its axis, where an edge is beside it
    felt: float = 20.0  # [mm] from that, within which that face was felt
    own_outer: float = 1.0  # [mm] from the outer circle of its ring, within which an edge is that circle
    just_past: tuple[float, float] = (1.0, 4.0)  # [mm] past an edge, where a face was felt that goes on
    strays: int = 3  # contacts there, up to which it ends all the same
    beside: float = 4.0  # [mm] between rims that are tried as one,
    as_wide: float = 4.0  # [mm] and between their radii
    opposed: float = 0.98  # least cosine between the axes of two ends of a hole
    aside: float = 0.4  # [mm] of one end's center from the other's axis
    slant: float = 0.005  # [rad] the same, over the hole's depth
    radii: float = 0.25  # [mm] between their radii
    sigmas: float = 2.0  # of the radii, on top of both
    guessed: tuple[float, float] = (0.6, 1.2)  # [mm] least and most sigma of a rim that was not looked at,
    guessed_share: float = 0.045  # and of its radius in between
    least_depth: float = 2.0  # [mm] that an array went in
    row: float = 8.0  # [mm] between places that follow each other
    sigma: float = 0.02  # [mm] of the wall, besides the radius' own
    normal_sigma: float = 0.02  # [rad]
    mouth: float = 1.0  # [mm] before a hole, that is its mouth
    lip: float = 0.2  # [mm] round it, likewise


class RoundHoles:
    """The rims of one exploration."""

    def __init__(self, study: Study, reach: Reach, config: RoundHolesConfig = RoundHolesConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._seen = Attempts(1, config.beside)
        self._missed: list[RoundRim] = []

    def next(self, openings: Sequence[RoundRim]) -> Callable[[], Done] | None:
        """A look at the nearest rim that was not looked at yet."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [rim for rim in openings if not self._given_up(rim)]
        if not left:
            return None
        nearest = min(left, key=lambda rim: float(np.linalg.norm(rim.center - here)))
        return partial(self._measure, nearest)

    def _given_up(self, rim: RoundRim) -> bool:
        """Whether one was seen there, or none about as wide: a far end is guessed as wide as the near one."""
        return self._seen.given_up(rim.center) or any(
            float(np.linalg.norm(rim.center - other.center)) < self.config.beside
            and abs(rim.radius - other.radius) < self.config.as_wide
            for other in self._missed
        )

    def _measure(self, rim: RoundRim) -> Done:
        pad, frames, used = self.study.pad, list[tuple[TactileImage, Floats]](), list[Floats]()
        small = rim.radius < self.config.under * min(pad.size)
        looks, led = 1 if small else self.config.looks, 0
        found: RoundHole | None = None
        ends = self._ends(rim)
        for give, (way, pose) in product((False, True), self._places(rim, small)):
            if not small and any(way @ other > np.cos(self.config.apart) for other in used):
                continue
            met = self.reach.touch(pose, give)
            led += self.reach.led
            if met and self._lies(rim):
                seen = dwell(pad.guard, self.config.frames)
                frames.append((seen.image, seen.world_from_sensor))
                used.append(way)
                found = fit_round_hole(frames, rim.center, rim.axis, rim.radius, rim.outer, ends)
            if led >= self.config.most or (found is not None and len(frames) >= looks):
                break
        if found is None:
            self._missed.append(rim)
            self.study.found.refuted += [rim.center] if frames else []
            return None, "no round rim was made out"
        better = replace(rim, center=found.center, radius=found.radius, sigma=found.sigma, measured=True)
        self._seen.note(rim.center, found.center)
        self.study.found.rims.append(better)
        return None, "looked at the rim of a round hole"

    def _lies(self, rim: RoundRim) -> bool:
        """Whether the pad lies on the face that a rim is on, and has not rolled off it."""
        pose = self.study.pad.guard.world_from_sensor
        off = abs(float((pose[:3, 3] - rim.center) @ rim.axis))
        return off < self.config.off and float(pose[:3, 2] @ rim.axis) < -self.config.flush

    def _ends(self, rim: RoundRim) -> list[tuple[Shape, float]]:
        """What its face ends at beside it: upright faces felt near it, each with the sign of distances past it.

        A neck behind a flange is no end of the flange's face, which was felt past it.
        """
        found: list[tuple[Shape, float]] = []
        faces = self.study.found.graph.faces
        own = Contacts.concatenate([face.contacts for face in faces if face.id == rim.face]).points
        for face in faces:
            if not isinstance(face.fit, Fit) or not len(face.contacts):
                continue
            shape, side = face.fit.shape, 1.0 if face.fit.convex else -1.0
            foot = shape.project(rim.center[None])[0]
            past = side * float(shape.signed_distance(rim.center[None])[0])
            leans = abs(float(shape.normals(foot[None])[0] @ rim.axis))
            near = float(np.linalg.norm(face.contacts.points - foot, axis=1).min()) < self.config.felt
            beyond = side * shape.signed_distance(own[np.linalg.norm(own - foot, axis=1) < self.config.felt])
            first, end = self.config.just_past
            if np.count_nonzero((beyond > first) & (beyond < end)) > self.config.strays:
                continue
            if abs(past + rim.outer) < self.config.own_outer:
                continue  # the ring's own outer circle, which is told by `outer` already
            if near and leans < self.config.upright and -self.config.edge < past < -0.5 * rim.radius:
                found.append((shape, side))
        return found

    def _places(self, rim: RoundRim, small: bool) -> list[tuple[Floats, Floats]]:
        """Ways from the center of a rim, each with a (4, 4) place of the pad over it; the best first."""
        half = 0.5 * min(self.study.pad.size)
        ways = rim.places(16)[1][[0, 4, 8, 12, 2, 6, 10, 14, 1, 5, 9, 13, 3, 7, 11, 15]]
        found: list[tuple[Floats, Floats]] = []
        over = min(rim.radius + self.config.over, 0.5 * (rim.radius + rim.outer))
        for far in (0.0, 0.5 * half, half) if small else (over,):
            for way in ways[::4] if far == 0.0 else ways:
                for along in (np.cross(rim.axis, way), way):
                    turn = self.study.pad.attitude(rim.axis, along)
                    found.append((way, se3.pose(turn, rim.center + far * way)))
        return found


@dataclass(frozen=True)
class Hole:
    """A round hole that is taken for known, upright on the faces at its ends."""

    middle: Floats  # (3,) [mm] half way down
    axis: Floats  # (3,)
    radius: float  # [mm]
    depth: float  # [mm]
    sigma: float  # [mm] of the radius

    def wall(self, config: RoundHolesConfig = RoundHolesConfig()) -> Contacts:
        """Contacts of its wall, looking to the axis; nobody felt it."""
        ring, ways = RoundRim(self.middle, self.axis, self.radius, self.sigma, -1).places()
        points = np.concatenate([ring + share * self.depth * self.axis for share in _ALONG])
        sigma = float(np.hypot(config.sigma, self.sigma))
        normals = np.tile(-ways, (len(_ALONG), 1))
        return Contacts.of(points, normals, sigma, config.normal_sigma, touch=NOT_FELT)

    def holds(self, points: Floats, config: RoundHolesConfig = RoundHolesConfig()) -> Bools:
        """(n,) whether (n, 3) points are in it or in one of its mouths."""
        along = (points - self.middle) @ self.axis
        aside = np.linalg.norm(points - self.middle - along[:, None] * self.axis, axis=1)
        near = np.abs(along) < 0.5 * self.depth + config.mouth
        return np.asarray(near & (aside < self.radius + config.lip))

    def off(self, face: Face) -> Face:
        """A face without its contacts in a mouth.

        The contacts of a pad that lay over a mouth stand for the plane round it, not for places of their own.
        """
        if not isinstance(face.fit, Fit) or face.fit.kind != "plane":
            return face
        return face.only(~self.holds(face.contacts.points))


def holes_of(
    rims: Sequence[RoundRim],
    inside: Floats,
    shut: Callable[[RoundRim], float] = lambda _: np.inf,
    config: RoundHolesConfig = RoundHolesConfig(),
) -> tuple[list[Hole], list[RoundRim]]:
    """Each hole that is taken for known, and the rims that are left.

    Of the two rims of a hole one at least was looked at.  An array was at (n, 3) places `inside`; behind a rim it
    is `shut` so many [mm] down, and who is there did not go through.
    """
    left, out = [_doubted(rim, config) for rim in rims], list[Hole]()
    while (pair := _nearest_ends(left, config)) is not None:
        left = [rim for rim in left if rim is not pair[0] and rim is not pair[1]]
        out.append(_between(*pair))
    for rim in list(left):
        depth = _gone_in(rim, inside, shut(rim), config)
        if depth > config.least_depth:
            left = [other for other in left if other is not rim]
            out.append(_between(rim, replace(rim, center=rim.center - depth * rim.axis, axis=-rim.axis)))
    return out, left


def _doubted(rim: RoundRim, config: RoundHolesConfig) -> RoundRim:
    """A rim that was not looked at is no better known than the places felt round it tell."""
    unsure = float(np.clip(config.guessed_share * rim.radius, *config.guessed))
    return rim if rim.measured else replace(rim, sigma=max(rim.sigma, unsure))


def _nearest_ends(rims: Sequence[RoundRim], config: RoundHolesConfig) -> tuple[RoundRim, RoundRim] | None:
    """Of all that may be the two ends of a hole, those that are nearest to each other."""
    pairs = [(a, b) for k, a in enumerate(rims) for b in rims[k + 1 :] if ends_of_one(a, b, config)]
    return min(pairs, key=lambda p: float(np.linalg.norm(p[0].center - p[1].center)), default=None)


def ends_of_one(a: RoundRim, b: RoundRim, config: RoundHolesConfig = RoundHolesConfig()) -> bool:
    """Whether two rims are likely the ends of one hole: as wide, on one axis, in faces that look away."""
    apart = a.center - b.center
    depth = float(apart @ a.axis)
    aside = float(np.linalg.norm(apart - depth * a.axis))
    unsure = config.sigmas * float(np.hypot(a.sigma, b.sigma))
    return (
        (a.measured or b.measured)
        and float(a.axis @ b.axis) < -config.opposed
        and depth > 0.0
        and aside < config.aside + config.slant * depth + unsure
        and abs(a.radius - b.radius) < config.radii + unsure
    )


def _gone_in(rim: RoundRim, inside: Floats, most: float, config: RoundHolesConfig) -> float:
    """[mm] behind a rim, `most` at most, down to which (n, 3) places that an array was in follow each other."""
    deep = (rim.center - inside) @ rim.axis
    aside = np.linalg.norm(inside - rim.center + deep[:, None] * rim.axis, axis=1)
    row = np.sort(deep[(aside < rim.radius) & (deep > 0.0) & (deep < most)])
    breaks = np.flatnonzero(np.diff(row, prepend=0.0) > config.row)
    return float(row[: breaks[0] if len(breaks) else len(row)].max(initial=0.0))


def _between(a: RoundRim, b: RoundRim) -> Hole:
    """The hole of two ends, of which the better known counts for more."""
    trust = np.array([a.sigma, b.sigma]) ** -2
    share = float(trust[1] / trust.sum())
    axis = a.axis - b.axis
    axis = axis / np.linalg.norm(axis)
    depth = float((a.center - b.center) @ axis)
    middle = (1.0 - share) * (a.center - 0.5 * depth * axis) + share * (b.center + 0.5 * depth * axis)
    radius = (1.0 - share) * a.radius + share * b.radius
    return Hole(middle, axis, radius, depth, float(1.0 / np.sqrt(trust.sum())))

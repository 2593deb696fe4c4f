"""Round holes that no array has room in, inferred from their rims.

Two rims of one radius on one axis, in faces that look away from each other, are taken for the ends of one hole.
That is likely and not measured, so its wall is marked as inferred.  Where a hole slants into a face its rim is
an ellipse, and passes for a circle a little wider: of two rims that lean to each other the narrower tells how the
hole runs, if that leads to the middle of the other.  Two mouths in round faces lean as these do, so that the way
from one to the other is the axis.  A rim with no partner, into which an array went, is a hole as deep as that; any
other tells of its depth nothing (our derivation).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from exploration.planning.open.round_rims import RoundRim, aside
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face

_ALONG = np.array([-0.35, 0.0, 0.35])  # of a hole's depth, from its middle, where its wall is


@dataclass(frozen=True)
class HolesConfig:
    """When two rims are of one hole."""

    opposed: float = 0.98  # least cosine between the axes of its two ends
    aside: float = 0.4  # [mm] of one end's center from the other's axis
    slant: float = 0.005  # [rad] the same, over the hole's depth
    radii: float = 0.25  # [mm] between their radii
    sigmas: float = 2.0  # of the radii, on top of both
    guessed: tuple[float, float] = (0.6, 1.2)  # [mm] least and most sigma of a rim that was not looked at,
    guessed_share: float = 0.045  # and of its radius in between
    least_depth: float = 2.0  # [mm] that an array went in
    row: float = 8.0  # [mm] between places that follow each other
    sigma: float = 0.06  # [mm] of the wall, besides the radius' own
    normal_sigma: float = 0.02  # [rad]
    mouth: float = 1.0  # [mm] before a hole, that is its mouth
    lip: float = 0.2  # [mm] round it, likewise
    shut: float = 1.0  # [mm] past a face touched across it, where a hole across a round body may end
    leaning: float = 0.93  # least cosine between the axes of two mouths in round faces and the way between
    slanting: float = 0.6  # least cosine between the axes of two ends, where the hole slants into one face
    meeting: float = 0.25  # of the radius, that the center of the longer rim is off the axis of the other


@dataclass(frozen=True)
class Hole:
    """A round hole that is taken for known."""

    middle: Floats  # (3,) [mm] half way down
    axis: Floats  # (3,)
    radius: float  # [mm]
    depth: float  # [mm]
    sigma: float  # [mm] of the radius

    def wall(self, config: HolesConfig = HolesConfig()) -> Contacts:
        """Contacts of its wall, looking to the axis; nobody felt it."""
        ring, ways = RoundRim(self.middle, self.axis, self.radius, self.sigma, -1).places()
        points = np.concatenate([ring + share * self.depth * self.axis for share in _ALONG])
        sigma = float(np.hypot(config.sigma, self.sigma))
        normals = np.tile(-ways, (len(_ALONG), 1))
        return Contacts.of(points, normals, sigma, config.normal_sigma, touch=NOT_FELT)

    def holds(self, points: Floats, config: HolesConfig = HolesConfig()) -> Bools:
        """(n,) whether (n, 3) points are in it or in one of its mouths."""
        along = (points - self.middle) @ self.axis
        near = np.abs(along) < 0.5 * self.depth + config.mouth
        return np.asarray(near & (aside(points, self.middle, self.axis) < self.radius + config.lip))

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
    config: HolesConfig = HolesConfig(),
) -> tuple[list[Hole], list[RoundRim]]:
    """Each hole that is taken for known, and the rims that are left.

    Of the two rims of a hole one at least was looked at.  An array was at (n, 3) places `inside`; behind a rim it
    is `shut` so many [mm] down, and who is there did not go through.
    """
    left, out = [_doubted(rim, config) for rim in rims], list[Hole]()
    while (pair := _nearest_ends(left, shut, config)) is not None:
        left = [rim for rim in left if rim is not pair[0] and rim is not pair[1]]
        out.append(_between(*pair))
    while (pair := next((p for p in permutations(left, 2) if _slants(*p, config)), None)) is not None:
        left = [rim for rim in left if rim is not pair[0] and rim is not pair[1]]
        out.append(_slanting(*pair))
    for rim in list(left):
        depth = _gone_in(rim, inside, shut(rim), config)
        if depth > config.least_depth:
            left = [other for other in left if other is not rim]
            out.append(_between(rim, replace(rim, center=rim.center - depth * rim.axis, axis=-rim.axis)))
    return out, left


def _doubted(rim: RoundRim, config: HolesConfig) -> RoundRim:
    """A rim that was not looked at is no better known than the places felt round it tell."""
    unsure = float(np.clip(config.guessed_share * rim.radius, *config.guessed))
    return rim if rim.measured else replace(rim, sigma=max(rim.sigma, unsure))


def _nearest_ends(
    rims: Sequence[RoundRim], shut: Callable[[RoundRim], float], config: HolesConfig
) -> tuple[RoundRim, RoundRim] | None:
    """Of all that may be the two ends of a hole, those that are nearest to each other, and not shut in between."""
    pairs = [(a, b) for a, b in combinations(rims, 2) if ends_of_one(a, b, config)]
    apart = [float(np.linalg.norm(a.center - b.center)) for a, b in pairs]
    for k in np.argsort(apart, kind="stable"):
        a, b = pairs[k]
        if not (a.bent and b.bent) or apart[k] < min(shut(a), shut(b)) + config.shut:
            return a, b
    return None


def ends_of_one(a: RoundRim, b: RoundRim, config: HolesConfig = HolesConfig()) -> bool:
    """Whether two rims are likely the ends of one hole: as wide, on one axis, in faces that look away."""
    apart = a.center - b.center
    if a.bent and b.bent:
        return _across(a, b, config)
    depth = float(apart @ a.axis)
    off = float(aside(b.center[None], a.center, a.axis)[0])
    unsure = config.sigmas * float(np.hypot(a.sigma, b.sigma))
    return (
        (a.measured or b.measured)
        and float(a.axis @ b.axis) < -config.opposed
        and depth > 0.0
        and off < config.aside + config.slant * depth + unsure
        and abs(a.radius - b.radius) < config.radii + unsure
    )


def _slants(a: RoundRim, b: RoundRim, config: HolesConfig) -> bool:
    """Whether a hole that runs straight into one rim's face comes out slanting at the other rim."""
    apart, lean = a.center - b.center, -float(a.axis @ b.axis)
    if not (a.measured and b.measured and config.slanting < lean < config.opposed and apart @ a.axis > 0.0):
        return False
    unsure = config.radii + config.sigmas * float(np.hypot(a.sigma, b.sigma))
    off = float(aside(b.center[None], a.center, a.axis)[0])
    return a.radius <= b.radius < a.radius / lean + unsure and off < config.meeting * a.radius + unsure


def _slanting(a: RoundRim, b: RoundRim) -> Hole:
    """The hole straight into one rim's face, as deep as to the other's center."""
    depth = float((a.center - b.center) @ a.axis)
    return Hole(a.center - 0.5 * depth * a.axis, a.axis, a.radius, depth, a.sigma)


def _across(a: RoundRim, b: RoundRim, config: HolesConfig) -> bool:
    """Whether two mouths as wide in round faces look away from each other, as on a cone's two sides."""
    way = (a.center - b.center) / max(float(np.linalg.norm(a.center - b.center)), 1e-9)
    unsure = config.radii + config.sigmas * float(np.hypot(a.sigma, b.sigma))
    return (
        min(float(a.axis @ way), float(-b.axis @ way)) > config.leaning and abs(a.radius - b.radius) < unsure
    )


def _gone_in(rim: RoundRim, inside: Floats, most: float, config: HolesConfig) -> float:
    """[mm] behind a rim, `most` at most, down to which (n, 3) places that an array was in follow each other."""
    deep = (rim.center - inside) @ rim.axis
    within = aside(inside, rim.center, rim.axis) < rim.radius
    row = np.sort(deep[within & (deep > 0.0) & (deep < most)])
    breaks = np.flatnonzero(np.diff(row, prepend=0.0) > config.row)
    return float(row[: breaks[0] if len(breaks) else len(row)].max(initial=0.0))


def _between(a: RoundRim, b: RoundRim) -> Hole:
    """The hole of two ends, of which the better known counts for more."""
    trust = np.array([a.sigma, b.sigma]) ** -2
    share = float(trust[1] / trust.sum())
    axis = a.center - b.center if a.bent and b.bent else a.axis - b.axis
    axis = axis / np.linalg.norm(axis)
    depth = float((a.center - b.center) @ axis)
    middle = (1.0 - share) * (a.center - 0.5 * depth * axis) + share * (b.center + 0.5 * depth * axis)
    radius = (1.0 - share) * a.radius + share * b.radius
    return Hole(middle, axis, radius, depth, float(1.0 / np.sqrt(trust.sum())))

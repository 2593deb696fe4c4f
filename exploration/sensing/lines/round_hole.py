"""A round hole in a flat face, from frames of a pad that lay over its rim: one circle for all of them.

In the face's plane, with a the distance of a taxel from the hole's center and F the blurred disc of its radius
(`blurred_disc`), each frame sees

    depth = (d + g . p) S + w^2 g . grad S,    S = 1 - F(a / w, R / w),

its own plane (d, g) under the same circle: what the blur makes of a plane where S is its share, the last term the
moment that it takes across an edge.  On a narrow ring, over which a pad easily leans, that is tenths of a mm.  The
planes are linear, so only center and radius are searched for (variable projection, Golub and Pereyra 1973).
Taxels far outside the rim tell of other things and are left out; where a circle explains the others badly, as
beside an edge that nobody knows of, so are all but those at the rim.
So are those over a keyway or a nick: where no circle explains all taxels, one may explain most that see the rim.
A face that is a ring about the hole ends at a known circle of radius S, and 1 becomes F(b / w, S / w), with b
from the center of that; where other known surfaces bound it, it ends as the normal distribution does, Phi(-e / w),
with e the distance past them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.blurred_disc import of_disc, slope_of_disc
from exploration.sensing.response import response_of
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.shapes import Shape

_LEAST = 12  # taxels of a look
_STEP = 0.05  # [mm] of the slope of what is not a circle
_OPPOSED = -0.7  # cosine of the ways out of a face at two of its ends, at most
_LEVEL = 0.003  # 1 sigma of how a face leans against a pad that is told to be flush


@dataclass(frozen=True)
class RoundHoleConfig:
    """What belongs to the rim, and what is round."""

    outside: float = 3.0  # [widths] of the blur outside the rim, up to which taxels are looked at
    close: float = 1.2  # [widths] the same, where farther out the face may end at what is not known
    systematic: float = 0.02  # of the deepest taxel: what the model leaves out
    shift: float = 5.0  # [mm] of the center from where it was thought to be
    change: float = 4.0  # [mm] of the radius, likewise
    least: float = 1.5  # [mm] radius, below which the skin sees no hole
    ring: float = 0.5  # [mm] of material round it at least, where the face's own circle is known
    misfit: float = 3.0  # chi2 per degree of freedom, above which the hole is not round
    worth: float = 1.2  # times less misfit, for which fewer taxels are believed
    sure: float = 1.0  # chi2 per degree of freedom, from which it is tried to explain fewer taxels
    certain: float = 0.3  # [mm] of the radius, that it must be known to
    stray: float = 4.0  # [standard deviations] from which a taxel tells of a keyway
    sees: float = 0.2  # of the largest slope by the radius, from which a taxel sees the rim
    nick: float = 0.9  # [rad] to both sides of a keyway or a nick, within which
    one_nick: float = 0.75  # share of what is left over that lies there, at least
    chosen: float = 1.8  # chi2 per degree of freedom, the same for what is left without strays
    round: float = 0.7  # share of those that must agree
    on_face: float = 0.8  # of what the best taxel sees of the face, that one sees which tells where it is


@dataclass(frozen=True)
class RoundHole:
    """A circle in a face, where the face is not."""

    center: Floats  # (3,) [mm]
    radius: float  # [mm]
    sigma: float  # [mm] of the radius
    misfit: float  # chi2 per degree of freedom
    face: Floats  # (n, 3) [mm] places of the face round it, under the taxels that see it best


@dataclass(frozen=True)
class _Look:
    """Taxels of one frame, in the face's plane."""

    flat: Floats  # (n, 2) [mm]
    rows: Floats  # (n, 3) of its plane: 1, x, y
    depth: Floats  # (n,)
    weight: Floats  # (n,) 1 / sigma
    width: float  # [mm]
    face: Floats  # (n,) of each, that would lie on the face if it had no hole
    slope: Floats  # (n, 2) [1/mm] of that, along the pad's x and y
    axes: Floats  # (2, 2) those, in the face's plane
    pose: Floats  # (4, 4) world_from_sensor
    leans: Floats  # (2,) slope of the depth along the pad's x and y, where it is known; else nan

    def only(self, kept: Bools) -> _Look:
        """Of some taxels."""
        return _Look(
            self.flat[kept],
            self.rows[kept],
            self.depth[kept],
            self.weight[kept],
            self.width,
            self.face[kept],
            self.slope[kept],
            self.axes,
            self.pose,
            self.leans,
        )


def fit_round_hole(
    frames: Sequence[tuple[TactileImage, Floats]],
    center: Floats,
    axis: Floats,
    radius: float,
    outer: float = np.inf,
    ends: Sequence[tuple[Shape, float]] = (),
    config: RoundHoleConfig = RoundHoleConfig(),
    flush: bool = False,
) -> RoundHole | None:
    """The hole of (3,) center, (3,) axis and radius thought of, as images at (4, 4) world poses show it.

    The face is a disc of radius `outer` [mm] about the center thought of, and `ends` at shapes: each with the sign
    of its distance past it.  A narrow ring that leans looks like one of another width; pads that kept the attitude
    they came at are `flush`, and it leans only as their poses do.
    """
    close = replace(config, outside=config.close)
    tries = [
        (ends, config),
        (ends, close),
        *([((), close)] if ends else []),
    ]  # it may go on past what ends it
    best: RoundHole | None = None
    for known, each in tries:
        found = _fitted(frames, (center, axis), (radius, outer), known, each, flush)
        if found is not None and (best is None or config.worth * found.misfit < best.misfit):
            best = found
        if best is not None and best.misfit < config.sure:
            break
    width = max((response_of(image).mean_width for image, _ in frames), default=0.0)
    return None if best is None or _squeezed(best, ends, width) else best


def _squeezed(hole: RoundHole, ends: Sequence[tuple[Shape, float]], width: float) -> bool:
    """Whether its face is seen to end beside it on two opposite sides: a gap in a band looks no different."""
    at = hole.center[None]
    near = [
        side * shape.normals(shape.project(at))[0]
        for shape, side in ends
        if -side * float(shape.signed_distance(at)[0]) - hole.radius < width
    ]
    return any(float(one @ other) < _OPPOSED for one, other in combinations(near, 2))


def _fitted(
    frames: Sequence[tuple[TactileImage, Floats]],
    line: tuple[Floats, Floats],
    radii: tuple[float, float],
    ends: Sequence[tuple[Shape, float]],
    config: RoundHoleConfig,
    flush: bool,
) -> RoundHole | None:
    """The hole about a (3,) center and (3,) axis, of as many taxels round it as `config` says."""
    (center, axis), (radius, outer) = line, radii
    turn = se3.frame_along(axis)
    looks = [
        _look(image, (pose, turn, center), (radius, outer), ends, config, flush) for image, pose in frames
    ]
    looks = [look for look in looks if len(look.depth) > _LEAST]
    if not looks:
        return None
    top = [config.shift, config.shift, radius + config.change]
    low = [-config.shift, -config.shift, max(config.least, radius - config.change)]

    def residual(circle: Floats) -> Floats:
        return np.concatenate([_residual(look, circle) for look in looks])

    start = [0.0, 0.0, max(radius, config.least)]
    found, most = least_squares(residual, start, bounds=(low, top)), config.misfit
    if _misfit(found, len(looks)) > config.misfit:
        robust = least_squares(residual, start, bounds=(low, top), loss="cauchy", f_scale=2.0)
        looks = _without_strays(
            looks, robust.x[:2], residual(robust.x), np.abs(np.asarray(robust.jac)[:, 2]), config
        )
        if not looks:
            return None
        found, most = least_squares(residual, robust.x, bounds=(low, top)), config.chosen
    misfit = _misfit(found, len(looks))
    slopes = np.asarray(found.jac)
    inverse = np.linalg.pinv(slopes.T @ slopes)
    sigma = float(np.sqrt(inverse[2, 2] * max(misfit, 1.0)))
    ring = outer - float(found.x[2]) - float(np.linalg.norm(found.x[:2]))
    if misfit > most or sigma > config.certain or (found.active_mask != 0).any() or ring < config.ring:
        return None
    face = np.concatenate([_places(look, found.x, config) for look in looks])
    return RoundHole(center + turn[:, :2] @ found.x[:2], float(found.x[2]), sigma, misfit, face)


def _misfit(found: OptimizeResult, looks: int) -> float:
    """Chi2 per degree of freedom."""
    return float(2.0 * found.cost / max(len(found.fun) - 3 - 3 * looks, 1))


def _without_strays(
    looks: Sequence[_Look], center: Floats, off: Floats, slope: Floats, config: RoundHoleConfig
) -> list[_Look]:
    """The looks without taxels that are `off` a circle; none where too few that see its rim are on it, or all are.

    Nor are there any where those off it lie all round the (2,) center, as over the corners of a hexagon.  `slope`
    is that of each residual by the radius.
    """
    near = np.abs(off) < config.stray
    sees = slope > config.sees * float(slope.max(initial=0.0))
    if near.all() or float(near[sees].mean()) < config.round:
        return []
    ways = (np.concatenate([look.flat for look in looks]) - center)[~near]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    weight = off[~near] ** 2
    middle = weight @ ways
    together = ways @ middle > np.cos(config.nick) * float(np.linalg.norm(middle))
    if float(weight @ together) < config.one_nick * float(weight.sum()):
        return []
    parts = np.split(near, np.cumsum([len(look.depth) for look in looks])[:-1])
    return [look.only(kept) for look, kept in zip(looks, parts, strict=True) if kept.sum() > _LEAST]


def _look(
    image: TactileImage,
    where: tuple[Floats, Floats, Floats],
    radii: tuple[float, float],
    ends: Sequence[tuple[Shape, float]],
    config: RoundHoleConfig,
    flush: bool,
) -> _Look:
    (pose, turn, center), (radius, outer) = where, radii
    x, y = (grid.ravel() for grid in np.meshgrid(image.array.x, image.array.y))
    depth, sigma = image.depth.ravel(), image.sigma.ravel()
    width = response_of(image).mean_width
    places = se3.transform_points(pose, np.column_stack([x, y, -np.maximum(depth, 0.0)]))
    flat = ((places - center) @ turn)[:, :2]
    near = np.linalg.norm(flat, axis=1) < radius + config.outside * width

    def share(at: Floats) -> Floats:
        """(n,) of taxels at (n, 3) places, that would lie on the face if it had no hole."""
        away = np.linalg.norm((at - center) @ turn[:, :2], axis=1)
        face = of_disc(away / width, outer / width) if np.isfinite(outer) else np.ones(len(at))
        for shape, side in ends:
            face = face * ndtr(-side * shape.signed_distance(at) / width)
        return face

    face, steps = share(places), _STEP * pose[:3, :2].T
    slope = np.stack([(share(places + h) - share(places - h)) / (2.0 * _STEP) for h in steps], axis=1)
    kept = near & np.isfinite(sigma) & (sigma > 0.0)
    rows = np.column_stack([np.ones(len(x)), x, y])[kept]
    floor = config.systematic * float(depth[kept].max(initial=0.0))
    weight = 1.0 / np.hypot(sigma[kept], floor)
    axes, normal = (turn.T @ pose[:3, :2])[:2], pose[:3, :3].T @ turn[:, 2]
    leans = normal[:2] / normal[2] if flush else np.full(2, np.nan)
    return _Look(flat[kept], rows, depth[kept], weight, width, face[kept], slope[kept], axes, pose, leans)


def _residual(look: _Look, circle: Floats) -> Floats:
    """(n,) what the best plane under a circle (x, y, radius) leaves, in standard deviations."""
    plane, share = _plane(look, circle)
    return np.asarray(share @ plane - look.depth * look.weight)


def _places(look: _Look, circle: Floats, config: RoundHoleConfig) -> Floats:
    """(n, 3) [mm] places of the face, where the taxels are that a good part of it lies under."""
    plane, share = _plane(look, circle)
    there = share[:, 0] / look.weight
    best = there > config.on_face * float(there.max(initial=0.0))
    rows = look.rows[best]
    return se3.transform_points(look.pose, np.column_stack([rows[:, 1:], -rows @ plane]))


def _plane(look: _Look, circle: Floats) -> tuple[Floats, Floats]:
    """(3,) the best plane under a circle, and (n, 3) what each taxel sees of it, in standard deviations."""
    out, width, radius = look.flat - circle[:2], look.width, float(circle[2]) / look.width
    away = np.linalg.norm(out, axis=1)
    there = look.face - of_disc(away / width, radius)
    steep = slope_of_disc(away / width, radius) / (width * np.maximum(away, 1e-9))
    moment = width**2 * (look.slope - steep[:, None] * (out @ look.axes))
    rows = look.rows * there[:, None] + np.column_stack([np.zeros(len(away)), moment])
    rows, seen = rows * look.weight[:, None], look.depth * look.weight
    known = np.zeros((2, 3)) if np.isnan(look.leans).any() else np.eye(3)[1:] / _LEVEL
    told = np.zeros(2) if np.isnan(look.leans).any() else look.leans / _LEVEL
    plane, *_ = np.linalg.lstsq(np.vstack([rows, known]), np.append(seen, told), rcond=None)
    return plane, rows

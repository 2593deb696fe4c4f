"""Round holes that come out of a face of which nobody saw the rim there.

A look at a hole's rim tells its radius and axis.  Where the face that lies behind, and looks the other way, was
found to be missing just where the hole would come out, the hole goes through: that its other rim was not made
out says less than that.  Where that face was touched across the hole, it is shut there, or comes out narrower, as
a counterbore does; skin bridges a narrow hole, so that only a look tells.  A hole that leads straight into a bore
comes out there, unless that was felt where it would (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim, aside
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cylinder, Shape


@dataclass(frozen=True)
class FarEndsConfig:
    """When a face is missing where a hole would come out."""

    upright: float = 0.98  # least cosine between the face's normal and the hole's axis
    deepest: float = 80.0  # [mm] behind a rim
    own: float = 0.5  # [mm] behind it, where the surface ends that it lies on
    within: float = 0.9  # of the radius round the axis, where the face was found missing
    least: int = 3  # such places
    bare: float = 0.5  # of the radius round the axis, where it was touched nowhere
    beside: float = 12.0  # [mm] round the hole, within which the face was touched
    past: float = 1.0  # [mm] past a ring's outer circle, at which a face was touched that is no such ring
    narrower: tuple[float, float] = (2.0, 0.6)  # [mm], and of the radius, that a narrower end has
    inside: float = 0.75  # of the radius round the axis, where the face was touched that a hole narrows in,
    around: int = 4  # in so many places at least,
    lopsided: float = (
        0.7  # with the mean of the ways there no longer than this: a pad's overhang is on one side
    )


# For the other rim of a hole: where nobody felt that it does not come out.
WHERE_TO_LOOK = FarEndsConfig(least=0)


def far_ends(
    rims: Sequence[RoundRim], known: Sequence[KnownFace], config: FarEndsConfig = FarEndsConfig()
) -> list[RoundRim]:
    """Of each rim that was looked at the other end of its hole, in the first face that is missing behind it."""
    found: list[RoundRim] = []
    for rim in (rim for rim in rims if rim.measured):
        ends = [end for own in known if (end := _end(rim, own, config)) is not None]
        found += sorted(ends, key=lambda end: float((rim.center - end.center) @ rim.axis))[:1]
    return found


def into_bores(
    rims: Sequence[RoundRim], faces: Sequence[Face], config: FarEndsConfig = FarEndsConfig()
) -> list[RoundRim]:
    """Where holes in a tube's wall come out in its bore, of which nobody may have felt anything there."""
    found: list[RoundRim] = []
    for rim, face in product(rims, faces):
        if not isinstance(face.fit, Fit) or not isinstance(face.fit.shape, Cylinder) or face.fit.convex:
            continue
        deep = _straight_out(rim, face.fit.shape, -1.0, config)
        if deep is None:
            continue
        end, along = rim.center - deep * rim.axis, face.fit.shape.direction
        heights = (face.contacts.points - end) @ along
        goes_on = heights.min() < config.beside and heights.max() > -config.beside
        if goes_on and not _stopped(rim, deep, faces, config):
            found.append(replace(rim, center=end, axis=-rim.axis, face=face.id, measured=False))
    return found


def narrower_ends(
    rims: Sequence[RoundRim], known: Sequence[KnownFace], config: FarEndsConfig = FarEndsConfig()
) -> list[RoundRim]:
    """Where holes may come out narrower, whose rims were looked at: in the first face touched across each."""
    found: list[RoundRim] = []
    least, share = config.narrower
    for rim in (rim for rim in rims if rim.measured and share * rim.radius > least):
        across = [(deep, own, touched) for own in known for deep, touched in _across(rim, own, config)]
        for deep, own, touched in sorted(across, key=lambda item: item[0])[:1]:
            radius = float(np.clip(touched, least, share * rim.radius))
            found.append(_opposite(rim, deep, own, radius, config))
    return found


def narrowed_ends(
    rims: Sequence[RoundRim],
    known: Sequence[KnownFace],
    inside: Floats,
    config: FarEndsConfig = FarEndsConfig(),
) -> list[RoundRim]:
    """Where holes come out narrower that an array passed: in a face that was felt all round within their width.

    Of a rim that is not round, as of a square bore behind a round one, nobody makes a circle.  The array was at
    (n, 3) places `inside`.
    """
    found, through = list[RoundRim](), replace(config, deepest=np.inf)  # however long: the array went there
    for rim, own in product((rim for rim in rims if rim.measured), known):
        deep = _deep(rim, own, through)
        if deep is None:
            continue
        center = rim.center - deep * rim.axis
        away = _near(own.cells, center, rim, config) - center
        away = away - np.outer(away @ rim.axis, rim.axis)
        off = np.linalg.norm(away, axis=1)
        near = off < config.inside * rim.radius
        if near.sum() < config.around or off[near].min() < config.narrower[0]:
            continue
        ways = away[near] / off[near, None]
        gone = (aside(inside, center, rim.axis) < off[near].min()) & ((center - inside) @ rim.axis > 0.0)
        if gone.any() and float(np.linalg.norm(ways.mean(axis=0))) < config.lopsided:
            found.append(_opposite(rim, deep, own, float(off[near].min()), config))
    return found


def shut(rim: RoundRim, known: Sequence[KnownFace], config: FarEndsConfig = FarEndsConfig()) -> float:
    """[mm] behind a rim, where a face was touched across its hole, which does not come out there as wide."""
    return min((deep for own in known for deep, _ in _across(rim, own, config)), default=np.inf)


def _end(rim: RoundRim, own: KnownFace, config: FarEndsConfig) -> RoundRim | None:
    deep = _deep(rim, own, config)
    if deep is None:
        return None
    center = rim.center - deep * rim.axis
    touched, missing = (
        aside(_near(places, center, rim, config), center, rim.axis) for places in (own.cells, own.free)
    )
    gone = int((missing < config.within * rim.radius).sum()) >= config.least
    bare = config.bare * rim.radius < touched.min(initial=np.inf) < rim.radius + config.beside
    return _opposite(rim, deep, own, rim.radius, config) if gone and bare else None


def _across(rim: RoundRim, own: KnownFace, config: FarEndsConfig) -> list[tuple[float, float]]:
    """[mm] behind a rim and from its axis, where a face was touched across its hole; empty where it was not."""
    deep = _deep(rim, own, config)
    if deep is None:
        return []
    cells = _near(own.cells, rim.center - deep * rim.axis, rim, config)
    touched = float(aside(cells, rim.center, rim.axis).min(initial=np.inf))
    return [(deep, touched)] if touched < config.bare * rim.radius else []


def _deep(rim: RoundRim, own: KnownFace, config: FarEndsConfig) -> float | None:
    """[mm] behind a rim, where its axis comes straight out of a face; None where it does not."""
    return _straight_out(rim, own.fit.shape, own.side, config) if len(own.cells) else None


def _straight_out(rim: RoundRim, shape: Shape, side: float, config: FarEndsConfig) -> float | None:
    """[mm] behind a rim, where its axis comes straight out of a surface whose outward normal is `side` its own.

    The rim lies on a surface itself, which is not that.
    """
    hits = shape.cast_rays((rim.center - config.own * rim.axis)[None], -rim.axis[None])
    deep, slope = float(hits.distance[0]) + config.own, side * float(hits.normals[0] @ rim.axis)
    return deep if deep < config.deepest and slope < -config.upright else None


def _stopped(rim: RoundRim, deep: float, faces: Sequence[Face], config: FarEndsConfig) -> bool:
    """Whether anything was felt across a hole between its rim and where it would come out."""
    felt = np.concatenate([face.contacts.points[face.contacts.touch != NOT_FELT] for face in faces])
    down = (rim.center - felt) @ rim.axis
    across = aside(felt, rim.center, rim.axis) < config.bare * rim.radius
    return bool((across & (down > config.past) & (down < deep + config.past)).any())


def _near(places: Floats, center: Floats, rim: RoundRim, config: FarEndsConfig) -> Floats:
    """Those of (n, 3) places of a face that are about where a hole comes out; its axis meets a bore twice."""
    return np.asarray(places[np.linalg.norm(places - center, axis=1) < rim.radius + config.beside])


def _opposite(rim: RoundRim, deep: float, own: KnownFace, radius: float, config: FarEndsConfig) -> RoundRim:
    """The rim on a face behind; that may reach farther from the axis than the face that the first rim is on."""
    center: Floats = rim.center - deep * rim.axis
    wide = float(aside(own.cells, center, rim.axis).max()) > rim.outer + config.past
    outer = np.inf if wide else rim.outer
    return replace(
        rim, center=center, axis=-rim.axis, radius=radius, face=own.face.id, measured=False, outer=outer
    )

"""Ends of a turned face on either side of a gap that an array went into, as between the knuckles of a hinge.

Contacts on one axis and of one radius make one face, however far apart they lie.  Where nothing was felt at some
height, and an array was there on both sides of the axis, the face is parted: it ends between the last contact and
the place that was free.  How exactly, their distance says (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from primitives.arcs import around
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cylinder


@dataclass(frozen=True)
class PartedEndsConfig:
    """When a face is parted, and where."""

    gap: float = 4.0  # [mm] along the axis without a contact
    clear: float = 0.5  # [mm] of the contacts at its ends
    deep: float = 0.6  # of the radius, nearer than which to the axis an array was,
    shell: tuple[float, float] = (0.7, 1.0)  # of it, and [mm] under the face, between which it was, too
    sector: float = 0.2  # [rad] round the axis, from where the face was felt to where it was
    bore: float = 1.5  # [mm] from a round hollow, in which it may have been instead
    core: float = 2.0  # [mm] farther out than that, up to which who was there went through what is bored
    coaxial: float = 0.99  # least cosine between the axes of a cylinder and of a bore in it
    places: int = 3  # of either, at least
    around: float = 3.3  # [rad] round the axis, over which it was: past it, and no notch from one side
    most: float = 8.0  # [mm] between a contact and such a place, from which nobody knows where the end is
    ring: int = 12  # places round an end
    out: tuple[float, ...] = (0.5, 0.8)  # of the radius, where they are
    normal_sigma: float = 0.02  # [rad]


def parted_ends(
    faces: Sequence[Face], inside: Floats, config: PartedEndsConfig = PartedEndsConfig()
) -> list[Contacts]:
    """Contacts of the ends of cylinders beside gaps; an array was at (n, 3) places `inside`."""
    lots: list[Contacts] = []
    for hollow in faces:
        if isinstance(hollow.fit, Fit) and not hollow.fit.convex and len(inside):
            inside = inside[hollow.fit.shape.signed_distance(inside) > config.bore]
    for face in faces:
        fit = face.fit
        felt = face.contacts.points[face.contacts.touch != NOT_FELT]
        if not isinstance(fit, Fit) or not isinstance(fit.shape, Cylinder) or not fit.convex or not len(felt):
            continue
        shape = fit.shape
        away = (inside - shape.anchor) @ shape.frame
        axis = shape.frame[:, 2]
        radial = np.hypot(away[:, 0], away[:, 1])
        low, under = config.shell
        came = (radial > low * shape.radius) & (radial < shape.radius - under)
        shell = np.sort(away[came & _over_felt(away, (felt - shape.anchor) @ shape.frame, config), 2])
        bores = [bore for hollow in faces if (bore := _bored(hollow, shape, config)) is not None]
        near = [radial < config.deep * shape.radius]
        for radius, low_end, high_end in bores:
            beside = radial < radius + config.bore + config.core
            near.append(beside & (away[:, 2] > low_end) & (away[:, 2] < high_end))
        free = np.sort(away[np.any(near, axis=0), 2])
        heights = np.sort((felt - shape.anchor) @ axis)
        for k in np.flatnonzero(np.diff(heights) > config.gap):
            below, above = float(heights[k]), float(heights[k + 1])
            between = free[(free > below + config.clear) & (free < above - config.clear)]
            came = shell[(shell > below + config.clear) & (shell < above - config.clear)]
            if min(len(between), len(came)) < config.places:
                continue
            here = (away[:, 2] > below + config.clear) & (away[:, 2] < above - config.clear)
            here &= radial < shape.radius - under
            if around(np.arctan2(away[here, 1], away[here, 0])) < config.around:
                continue
            for felt_at, free_at, way in ((below, between[0], 1.0), (above, between[-1], -1.0)):
                if abs(free_at - felt_at) < config.most:
                    lots.append(
                        _end(shape, 0.5 * (felt_at + float(free_at)), way, abs(free_at - felt_at), config)
                    )
    return lots


def _over_felt(away: Floats, felt: Floats, config: PartedEndsConfig) -> Bools:
    """(n,) which of (n, 3) places lie where a face was felt, seen along its axis: it may not go all round."""
    turns = [np.arctan2(places[:, 1], places[:, 0]) for places in (felt, away)]
    ways = [np.column_stack([np.cos(turn), np.sin(turn)]) for turn in turns]
    return np.asarray(KDTree(ways[0]).query(ways[1])[0] < config.sector)


def _bored(hollow: Face, shape: Cylinder, config: PartedEndsConfig) -> tuple[float, float, float] | None:
    """[mm] radius of a bore about a cylinder's axis, and from where to where it goes; None where it is none."""
    fit = hollow.fit
    if not isinstance(fit, Fit) or fit.convex or not isinstance(fit.shape, Cylinder):
        return None
    off = (fit.shape.anchor - shape.anchor) @ shape.frame[:, :2]
    along = abs(float(fit.shape.direction @ shape.direction)) > config.coaxial
    if not along or float(np.linalg.norm(off)) > config.bore or fit.shape.radius >= shape.radius:
        return None
    heights = (hollow.contacts.points - shape.anchor) @ shape.frame[:, 2]
    return float(fit.shape.radius), float(heights.min()), float(heights.max())


def _end(shape: Cylinder, height: float, way: float, unsure: float, config: PartedEndsConfig) -> Contacts:
    turn = 2.0 * np.pi * np.arange(config.ring) / config.ring
    flat = np.concatenate(
        [out * shape.radius * np.column_stack([np.cos(turn), np.sin(turn)]) for out in config.out]
    )
    points = shape.anchor + np.column_stack([flat, np.full(len(flat), height)]) @ shape.frame.T
    normals = np.broadcast_to(way * shape.frame[:, 2], points.shape)
    return Contacts.of(points, normals, unsure / np.sqrt(12.0), config.normal_sigma, touch=NOT_FELT)

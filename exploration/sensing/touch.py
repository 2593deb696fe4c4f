"""What one frame is: nothing, flat, edge, ridge, corner or curved; and the contacts it yields.

The likeliest reading of the frame gets what the others leave: a line that is weak may be a curved rim, a surface
sharper than `SHARP` is a ridge or a corner as far as its curvature is known (our choice of weights).

A touched patch yields a few points whose information is that of the fit and no more (our derivation).  With C the
covariance of (d0, gx, gy) and C^-1 = N [[1, c^t], [c, S + c c^t]], the four points c +- sqrt(2 l) e, (l, e) the
eigenpairs of S, each of variance 4/N, have just this information: sums of 1, of (x - c) and of (x - c)(x - c)^t
over 4/N are N, 0 and N S.  So the plane fitted to their positions has the patch's own covariance.  Their
normals come from that same fit: each is given twice the gradient's sigma, so that the four together say it once
more and no oftener; whoever fits positions and normals of a flat patch at once counts its tilt twice.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, sin, sqrt
from types import MappingProxyType

import numpy as np
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.local_surface import LocalSurface, NoSurface, fit_surface
from exploration.sensing.surfaces.ridge_ends import DOUBTED, cut_at_ends
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import rotate, transform_points

SHARP = 0.3  # [1/mm] curvature from which a contact is a ridge or a corner
PARALLEL = 0.3  # [sine of the angle] between the two edges of a ridge
LEAST = 0.005  # of the probability, left to every kind

KINDS = ("nothing", "flat", "edge", "ridge", "corner", "curved")


@dataclass(frozen=True)
class Touch:
    """One frame, understood."""

    kind: str  # the likeliest of `KINDS`
    kinds: Mapping[str, float]  # probability of each
    lines: tuple[Line, ...]
    surface: LocalSurface | NoSurface
    force: float  # [N]
    time: float  # [s]

    def __bool__(self) -> bool:
        return self.kind != "nothing"


def perceive(image: TactileImage, max_lines: int = 3) -> Touch:
    """Lines, local surface and kind of a frame."""
    lines = find_lines(image, max_lines)
    surface = fit_surface(image, lines)
    if isinstance(surface, NoSurface) and lines:
        lines = ()
        surface = fit_surface(image)
    if isinstance(surface, LocalSurface) and surface.chi2 > DOUBTED * surface.dof:
        smooth = fit_surface(image) if lines else surface
        ended = cut_at_ends(image, smooth) if isinstance(smooth, LocalSurface) else surface
        if ended.chi2 < surface.chi2 and ended is not smooth:
            lines, surface = (), ended
    kinds = _kinds(lines, surface)
    px, py = image.array.pitch
    alive = np.isfinite(image.sigma)
    force = image.stiffness * px * py * float(np.sum(image.depth[alive])) if surface else 0.0
    kind = max(KINDS, key=lambda name: kinds[name])
    return Touch(kind, MappingProxyType(kinds), lines, surface, force, image.time)


def contacts_of(
    touch: Touch,
    image: TactileImage,
    world_from_sensor: Floats,
    touch_id: int = 0,
    stroke_id: int = 0,
    sensor_index: int = 0,
) -> Contacts:
    """Points of the object's surface in the world frame, with outward normals; empty where none is sure."""
    surface = touch.surface
    if isinstance(surface, NoSurface):
        return Contacts.of(np.empty((0, 3)))
    xy, sigma, normal_sigma = _design(surface, image)
    local = np.column_stack([xy, -surface.depth_at(xy)])
    slope = surface.slope_at(xy)
    outward = np.column_stack([-slope, -np.ones(len(xy))])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return Contacts.of(
        transform_points(world_from_sensor, local),
        rotate(world_from_sensor, outward),
        sigma,
        normal_sigma,
        touch_id,
        stroke_id,
        sensor_index,
    )


def _design(surface: LocalSurface, image: TactileImage) -> tuple[Floats, Floats, Floats]:
    """Where to report points, their sigma [mm] and their normals' sigma [rad].

    A curved patch is sure where it is deepest, and only there; a flat one yields four points whose weighted
    plane fit has the covariance of the patch's own.
    """
    if surface.curved:
        xy = surface.point[None, :2]
        slope_of = np.zeros((2, 6))
        slope_of[0, [1, 3, 4]] = 1.0, -xy[0, 0], -xy[0, 1]
        slope_of[1, [2, 4, 5]] = 1.0, -xy[0, 0], -xy[0, 1]
        turn = np.diag(slope_of @ surface.covariance @ slope_of.T)
        return xy, surface.depth_sigma_at(xy), np.full(1, float(np.sqrt(turn.mean())))
    information = np.linalg.inv(surface.covariance[:3, :3])
    count = information[0, 0]
    center = information[0, 1:] / count
    values, vectors = np.linalg.eigh(information[1:, 1:] / count - np.outer(center, center))
    arms = np.sqrt(2 * np.maximum(values, 0.0)) * vectors
    xy = center + np.concatenate([arms.T, -arms.T])
    normal = 2 * float(np.sqrt(np.mean(np.diag(surface.covariance)[1:3])))
    return xy, np.full(4, 2 / np.sqrt(count)), np.full(4, normal)


def _kinds(lines: tuple[Line, ...], surface: LocalSurface | NoSurface) -> dict[str, float]:
    share = dict.fromkeys(KINDS, LEAST)
    if isinstance(surface, NoSurface):
        share["nothing"] = 1.0
    elif not lines:
        sharp, both = _sharpness(surface)
        share["ridge"] += sharp * (1.0 - both)
        share["corner"] += sharp * both
        share["curved" if surface.curved else "flat"] += 1.0 - sharp
    else:
        doubt = 0.5 * exp(-(lines[-1].strength - 5.0) / 5.0)
        parallel = len(lines) > 1 and abs(sin(lines[0].angle - lines[1].angle)) < PARALLEL
        many = "ridge" if parallel else "corner"
        share["edge" if len(lines) == 1 else many] += 1.0 - doubt
        share["curved" if len(lines) == 1 else "edge"] += doubt
    total = sum(share.values())
    return {kind: value / total for kind, value in share.items()}


def _sharpness(surface: LocalSurface) -> tuple[float, float]:
    """Probabilities that the greater, and the lesser, principal curvature is sharp."""
    if not surface.curved:
        return 0.0, 0.0
    sigma = sqrt(float(surface.curvature_covariance[[0, 2], [0, 2]].max())) + 1e-6
    greatest, least = surface.principal[0]
    return float(ndtr((greatest - SHARP) / sigma)), float(ndtr((least - SHARP / 2) / sigma))

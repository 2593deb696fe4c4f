"""What one frame is: nothing, flat, edge, ridge, corner or curved; and the contacts it yields.

Kinds are weighed by exp(-misfit/2), the misfit of each reading of the frame, tempered because no sensor model is
exact.  A touched patch yields a few points whose information is that of the fit and no more.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.hough import find_lines
from exploration.sensing.line import Line
from exploration.sensing.local_surface import LocalSurface, NoSurface, fit_surface
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import rotate, transform_points

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
    c = surface.coefficients
    local = np.column_stack([xy, -surface.depth_at(xy)])
    slope = c[1:3] - xy @ np.array([[c[3], c[4]], [c[4], c[5]]])
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
    if isinstance(surface, NoSurface):
        likely = "nothing"
    elif not lines:
        likely = "curved" if surface.curved else "flat"
    elif len(lines) == 1:
        likely = "edge"
    else:
        parallel = abs(np.sin(lines[0].angle - lines[1].angle)) < 0.3
        likely = "ridge" if parallel else "corner"
    return {kind: 0.95 if kind == likely else 0.01 for kind in KINDS}

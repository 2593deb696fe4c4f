"""The contacts that a touch yields.

A touched patch yields a few points whose information is that of the fit and no more (our derivation).  With C the
covariance of (d0, gx, gy) and C^-1 = N [[1, c^t], [c, S + c c^t]], the four points c +- sqrt(2 l) e, (l, e) the
eigenpairs of S, each of variance 4/N, have just this information: sums of 1, of (x - c) and of (x - c)(x - c)^t
over 4/N are N, 0 and N S.  So the plane fitted to their positions has the patch's own covariance.  Their
normals come from that same fit, and are as unsure as it is about the axis that it knows least, that of a narrow
strip: each is given 2 sqrt(2) of that sigma, so that the four together add half to what their positions say.
"""

from dataclasses import replace

import numpy as np

from exploration.sensing.surfaces.in_world import in_world
from exploration.sensing.surfaces.local_surface import LocalSurface, NoSurface
from exploration.sensing.touch import Touch
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.pose import inverse, transform_points

_FOUR = 2.0 * float(np.sqrt(2.0))  # times a tilt's sigma, for each of four normals that share it


def contacts_of(
    touch: Touch,
    world_from_sensor: Floats,
    touch_id: int = 0,
    stroke_id: int = 0,
    sensor_index: int = 0,
) -> Contacts:
    """Points of the object's surface in the world frame, with outward normals; empty where none is sure."""
    surface = touch.surface
    if isinstance(surface, NoSurface):
        return Contacts.of(np.empty((0, 3)))
    xy, sigma, normal_sigma = _design(surface)
    return in_world(
        xy,
        surface.depth_at(xy),
        surface.slope_at(xy),
        sigma,
        normal_sigma,
        world_from_sensor,
        touch_id,
        stroke_id,
        sensor_index,
    )


def slid(contacts: Contacts, to: Floats, world_from_sensor: Floats) -> Contacts:
    """Contacts with normals, each moved within its own plane to an (n, 2) place [mm] of the pad."""
    local = transform_points(inverse(world_from_sensor), contacts.points)
    normals = contacts.normals @ world_from_sensor[:3, :3]
    height = local[:, 2] - ((to - local[:, :2]) * normals[:, :2]).sum(axis=1) / normals[:, 2]
    moved = transform_points(world_from_sensor, np.column_stack([to, height]))
    return replace(contacts, points=frozen(moved))


def _design(surface: LocalSurface) -> tuple[Floats, Floats, Floats]:
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
    normal = _FOUR * float(np.sqrt(np.linalg.eigvalsh(surface.covariance[1:3, 1:3])[-1]))
    return xy, np.full(4, 2 / np.sqrt(count)), np.full(4, normal)

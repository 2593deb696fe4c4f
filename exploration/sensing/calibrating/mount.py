"""Where the array sits on its flange, from a ball and a plane that were touched in many ways.

With F_i where the flange was at touch i, X = flange_from_sensor and s_i the ball's center as the array saw it,

    F_i X s_i = c            for every touch of one ball, its center c unknown,
    n . F_i X p_ik = d       for three points p_ik of every press on one plane, its n and d unknown.

The depths in s and p are those of the calibration, over one factor k that the stage's own travel tells better
than any step does.  X (six numbers), c, n, d and k are found together by least squares; the covariance is that of
the fit.  A ball alone tells X when it was touched at several attitudes and places of the pad; the plane sharpens
the tilt.  A stage that does not turn can tell the rotation alone: what no touch tells stays at the guess, held by
a wide prior, and its sigma says so (our derivation).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from exploration.sensing.calibrating.ball import BallPress
from primitives import pose as se3
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError

LEAST_BALLS = 4
_PRIOR = np.repeat([20.0, 0.3], 3)  # [mm], [rad] of the guess
_FLOOR = 0.01  # [mm] 1 sigma of any touch, for what no model holds


@dataclass(frozen=True)
class BallTouch:
    """A ball, from one pose of the flange."""

    world_from_flange: Floats  # (4, 4)
    ball: BallPress


@dataclass(frozen=True)
class PlaneTouch:
    """A plane, from one pose of the flange: z = -(depth + slope . (x, y)) in the sensor's frame."""

    world_from_flange: Floats  # (4, 4)
    plane: Floats  # (3,) depth at the pad's center [mm], slopes along x and y
    sigma: float  # [mm] of a point of it


@dataclass(frozen=True)
class Mount:
    """The array's place."""

    flange_from_sensor: Floats  # (4, 4)
    translation_sigma: float  # [mm] of the worst direction
    rotation_sigma: float  # [rad] about the worst axis
    rms: float  # [mm] of what the touches leave
    depth_ratio: float  # k: depth as calibrated, over true depth
    depth_ratio_sigma: float


def mount_of(
    balls: Sequence[BallTouch],
    planes: Sequence[PlaneTouch],
    guess: Floats,
    size: tuple[float, float],
    depth_sigma: float,
) -> Mount:
    """The mount that explains all touches, near a (4, 4) guess; `size` is the pad's [mm].

    `depth_sigma` is the relative 1 sigma to which the calibration knows depths.
    """
    if len(balls) < LEAST_BALLS:
        raise PalpateError(
            f"{len(balls)} touches of the ball are too few; {LEAST_BALLS} or more tell the mount"
        )
    flanges = np.array([touch.world_from_flange for touch in balls])
    radii = np.array([touch.ball.radius for touch in balls])
    places = np.array([touch.ball.place for touch in balls])
    sigmas = np.hypot(np.array([touch.ball.sigma for touch in balls]), _FLOOR)
    center = np.mean(_seen(flanges @ guess, _centers(places, radii, 1.0)), axis=0)
    tables = np.array([touch.world_from_flange for touch in planes]).reshape(-1, 4, 4)
    corners = np.array([_points(touch.plane, size) for touch in planes]).reshape(-1, 3, 3)
    off = np.hypot([touch.sigma for touch in planes], _FLOOR)
    frame, height = _plane_frame(tables, corners, guess)

    def residual(p: Floats) -> Floats:
        mount = guess @ se3.exp(p[:6])
        seen = _seen(flanges @ mount, _centers(places, radii, p[6]))
        turned = (flanges @ mount)[:, :3, :3]
        apart = np.einsum("nji,nj->ni", turned, seen - p[7:10]) / sigmas
        parts = [apart.ravel(), p[:6] / _PRIOR, [(p[6] - 1.0) / depth_sigma]]
        if len(tables):
            normal = frame @ np.array([p[10], p[11], 1.0])
            world = np.einsum("nij,nkj->nki", tables @ mount, _homogeneous(corners / [1.0, 1.0, p[6]]))
            parts.append(((world[..., :3] @ normal - p[12]) / off[:, None]).ravel())
        return np.concatenate(parts)

    start = np.concatenate([np.zeros(6), [1.0], center, [0.0, 0.0, height]])[: 13 if len(tables) else 10]
    fit = least_squares(residual, start, x_scale="jac", loss="linear")
    spare = max(1, len(fit.fun) - len(start))
    jacobian = np.asarray(fit.jac)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * max(1.0, 2.0 * float(fit.cost) / spare)
    mount = guess @ se3.exp(fit.x[:6])
    misses = fit.fun[: 3 * len(balls)].reshape(-1, 3) * sigmas
    return Mount(
        frozen(mount),
        float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1])),
        float(np.sqrt(np.linalg.eigvalsh(covariance[3:6, 3:6])[-1])),
        float(np.sqrt(np.mean(misses**2))),
        float(fit.x[6]),
        float(np.sqrt(covariance[6, 6])),
    )


def _centers(places: Floats, radii: Floats, ratio: float) -> Floats:
    """(n, 3) of balls in the sensor's frame."""
    return np.column_stack([places[:, :2], radii - places[:, 2] / ratio])


def _seen(poses: Floats, points: Floats) -> Floats:
    """(n, 3) each point from its own pose."""
    return np.asarray(np.einsum("nij,nj->ni", poses, _homogeneous(points))[:, :3])


def _points(plane: Floats, size: tuple[float, float]) -> Floats:
    """(3, 3) of a plane within the pad."""
    x, y = 0.4 * np.array(size)
    at = np.array([[-x, -y], [x, -y], [0.0, y]])
    return np.column_stack([at, -(plane[0] + at @ plane[1:])])


def _plane_frame(tables: Floats, points: Floats, guess: Floats) -> tuple[Floats, float]:
    """(3, 3) whose last column is about the plane's normal, and about its distance along it."""
    if not len(tables):
        return np.eye(3), 0.0
    world = np.einsum("nij,nkj->nki", tables @ guess, _homogeneous(points))[..., :3]
    normals = np.cross(world[:, 1] - world[:, 0], world[:, 2] - world[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normal = normals.mean(axis=0) / np.linalg.norm(normals.mean(axis=0))
    side = np.linalg.svd(normal[None])[2][1:].T
    return np.column_stack([side, normal]), float((world @ normal).mean())


def _homogeneous(points: Floats) -> Floats:
    return np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)

"""The rigid motion that lays one object on another as well as touch could tell: least squared distance.

Contacts on A's surface, explained by B at pose T, cost sum d_B(T p)^2 / 2 sigma^2; the pose that a rival takes is
the one of least cost.  Starts lay principal axes on each other (all proper ways, with turns about an
axis where two moments are nearly equal), the distance field ranks them, Gauss-Newton on
exact distances settles the best (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from models.library import Entry
from primitives.arrays import Floats
from primitives.pose import pose, rotation_exp, transform_points


@dataclass(frozen=True)
class OverlayConfig:
    """How thoroughly to search."""

    coarse: int = 150  # samples that rank starts
    fine: int = 300  # samples that settle a pose
    kept: int = 4  # starts that are settled
    alike: float = 0.06  # relative difference of principal radii that are one
    turn: float = 15.0  # [deg] between starts about an axis that the moments do not fix
    rounds: int = 12


@dataclass(frozen=True, eq=False)
class Spread:
    """Where an object's surface is, to first and second order."""

    center: Floats  # (3,) [mm]
    axes: Floats  # (3, 3) columns, of falling radius
    radii: Floats  # (3,) [mm] root mean square along each axis


def spread_of(entry: Entry) -> Spread:
    """Of the surface, by area."""
    points, weight = entry.samples.points, entry.samples.area / entry.samples.area.sum()
    center = weight @ points
    off = points - center
    values, vectors = np.linalg.eigh((off * weight[:, None]).T @ off)
    return Spread(center, vectors[:, ::-1], np.sqrt(np.maximum(values[::-1], 0.0)))


def overlay(a: Entry, b: Entry, config: OverlayConfig | None = None) -> Floats:
    """(4, 4) b_from_a of least mean squared distance of A's surface from B's."""
    config = config or OverlayConfig()
    starts = _starts(spread_of(a), spread_of(b), config)
    few, more = a.samples.points[: config.coarse], a.samples.points[: config.fine]
    cost = [float((b.field.signed_distance(transform_points(t, few)) ** 2).mean()) for t in starts]
    order = np.argsort(cost)[: config.kept]
    settled = [_settled(starts[k], more, b, config.rounds) for k in order]
    return min(settled, key=lambda found: found[1])[0]


def _settled(b_from_a: Floats, points: Floats, b: Entry, rounds: int) -> tuple[Floats, float]:
    best, least = b_from_a, np.inf
    current, damping = b_from_a, 1e-6
    center = points.mean(axis=0)
    for _ in range(rounds):
        moved = transform_points(current, points)
        distance, slope = _exact(b, moved)
        cost = float((distance**2).mean())
        if cost < least:
            gain = least - cost
            best, least = current, cost
            if gain < 1e-4 * cost or cost < 1e-10:
                break
            about = transform_points(best, center[None])[0]
            jacobian = np.hstack([np.cross(moved - about, slope), slope])
            normal, right = jacobian.T @ jacobian, -jacobian.T @ distance
            damping = max(damping / 10, 1e-9)
        else:
            damping = max(damping * 100, 1e-4)
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-9), right)
        turn = rotation_exp(step[:3])
        current = pose(turn, about - turn @ about + step[3:]) @ best
    return best, least


def _exact(b: Entry, points: Floats) -> tuple[Floats, Floats]:
    """(n,) unsigned distance of points from the surface, and (n, 3) its gradient."""
    found = b.solid.body.tree.nearest(points)
    off = points - found.points
    flat = b.solid.body.triangle_normals[found.triangle]
    far = found.distance > 1e-6
    return found.distance, np.where(far[:, None], off / np.maximum(found.distance, 1e-6)[:, None], flat)


def _starts(a: Spread, b: Spread, config: OverlayConfig) -> list[Floats]:
    limit = config.alike * float(b.radii[0])
    turns = _turns(b.radii, limit, np.deg2rad(config.turn))
    out = []
    for order in permutations(range(3)):
        if np.abs(a.radii[list(order)] - b.radii).max() > 2 * limit and order != (0, 1, 2):
            continue
        for signs in product((1.0, -1.0), repeat=3):
            axes = a.axes[:, order] * np.array(signs)
            if np.linalg.det(axes) * np.linalg.det(b.axes) < 0:
                continue
            for turn in turns:
                rotation = b.axes @ turn @ axes.T
                out.append(pose(rotation, b.center - rotation @ a.center))
    return out


def _turns(radii: Floats, limit: float, step: float) -> list[Floats]:
    """Turns in the principal frame that the moments leave open."""
    first, last = radii[0] - radii[1] < limit, radii[1] - radii[2] < limit
    angles = np.arange(0.0, np.pi / 2 - 1e-9, step)
    if first and last:
        return [
            rotation_exp(np.array([x, 0, 0])) @ rotation_exp(np.array([0, 0, z]))
            for x in angles[::2]
            for z in angles[::2]
        ]
    axis = np.array([0.0, 0.0, 1.0]) if first else np.array([1.0, 0.0, 0.0])
    return [rotation_exp(axis * angle) for angle in angles] if first or last else [np.eye(3)]

"""What touch yields: contacts, edge traces and swept free space, in the world frame.

Evidence has a producer (`exploration`) and a consumer (`recognition`), so its types live below both.
All lengths are in mm, all angles in rad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import ArrayLike

from primitives.arrays import Bools, Floats, Ints, frozen

NOT_FELT = -1  # the touch of a place that stopped the housing


@dataclass(frozen=True)
class Contacts:
    """A table of touched surface points; every column has n rows and is read-only."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3) outward unit normals; nan where none was felt
    sigma: Floats  # (n,) [mm] standard deviation of the point along the normal
    normal_sigma: Floats  # (n,) [rad] standard deviation of the normal's direction, per tangent axis
    touch: Ints  # (n,) which touch made it (guarded approach until contact breaks), or `NOT_FELT`
    stroke: Ints  # (n,) which stroke; contacts of one stroke lie on one smooth surface
    sensor: Ints  # (n,) index of the array on the stage
    body: Ints  # (n,) which body; 0 where there is one

    @staticmethod
    def of(
        points: ArrayLike,
        normals: ArrayLike | None = None,
        sigma: ArrayLike = 0.05,
        normal_sigma: ArrayLike = 0.02,
        touch: ArrayLike = 0,
        stroke: ArrayLike = 0,
        sensor: ArrayLike = 0,
        body: ArrayLike = 0,
    ) -> Contacts:
        """A table from points, with scalars spread over the rows."""
        p = np.asarray(points, dtype=float).reshape(-1, 3)
        n = len(p)
        felt = np.full((n, 3), np.nan) if normals is None else np.asarray(normals, dtype=float).reshape(-1, 3)
        return Contacts(
            frozen(p),
            frozen(felt),
            frozen(np.broadcast_to(np.asarray(sigma, dtype=float), (n,))),
            frozen(np.broadcast_to(np.asarray(normal_sigma, dtype=float), (n,))),
            frozen(np.broadcast_to(touch, (n,)), np.int64),
            frozen(np.broadcast_to(stroke, (n,)), np.int64),
            frozen(np.broadcast_to(sensor, (n,)), np.int64),
            frozen(np.broadcast_to(body, (n,)), np.int64),
        )

    @staticmethod
    def concatenate(tables: Sequence[Contacts]) -> Contacts:
        """All rows of all tables, in order."""
        if not tables:
            return Contacts.of(np.empty((0, 3)))
        return Contacts(
            frozen(np.concatenate([t.points for t in tables])),
            frozen(np.concatenate([t.normals for t in tables])),
            frozen(np.concatenate([t.sigma for t in tables])),
            frozen(np.concatenate([t.normal_sigma for t in tables])),
            frozen(np.concatenate([t.touch for t in tables]), np.int64),
            frozen(np.concatenate([t.stroke for t in tables]), np.int64),
            frozen(np.concatenate([t.sensor for t in tables]), np.int64),
            frozen(np.concatenate([t.body for t in tables]), np.int64),
        )

    def select(self, rows: Bools | Ints) -> Contacts:
        """The rows of a mask or an index."""
        return Contacts(
            frozen(self.points[rows]),
            frozen(self.normals[rows]),
            frozen(self.sigma[rows]),
            frozen(self.normal_sigma[rows]),
            frozen(self.touch[rows], np.int64),
            frozen(self.stroke[rows], np.int64),
            frozen(self.sensor[rows], np.int64),
            frozen(self.body[rows], np.int64),
        )

    @property
    def has_normal(self) -> Bools:
        """(n,) whether a normal was felt."""
        return np.asarray(np.isfinite(self.normals).all(axis=1))

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True)
class EdgeTrace:
    """Where a tracked edge ran: points along one smooth edge, with the normals of the face tracked from."""

    points: Floats  # (n, 3) [mm], in the order of travel
    tangents: Floats  # (n, 3) unit directions of travel
    normals: Floats  # (n, 3) outward normals of the face that the edge was tracked from
    sigma: Floats  # (n,) [mm] across the edge, in the face's tangent plane
    closed: bool  # whether the trace returned to its start
    touch: int
    stroke: int


@dataclass(frozen=True)
class FreeSpace:
    """Boxes that pad and housing swept without contact: no material is inside them."""

    poses: Floats  # (n, 4, 4) world_from_box
    half_extents: Floats  # (n, 3) [mm]

    def contains(self, points: Floats, margin: float = 0.0) -> Bools:
        """(m,) whether each of (m, 3) points lies in a box shrunk by `margin` [mm]."""
        inside = np.zeros(len(points), dtype=np.bool_)
        for k in range(len(self.poses)):
            _mark_inside(points, self.poses[k], self.half_extents[k], margin, inside)
        return inside

    def passed(self, points: Floats, margin: float, least: int, most: int) -> int:
        """Number of the boxes, shrunk by `margin` [mm], that hold `least` of (m, 3) points; `most` at most."""
        return int(_boxes_with(points, self.poses, self.half_extents, margin, least, most))


@numba.njit(cache=True, error_model="numpy")
def _in_box(points: Floats, i: int, pose: Floats, half: Floats, margin: float) -> bool:
    """Whether one of (m, 3) points lies in a box."""
    for j in range(3):
        local = 0.0
        for k in range(3):
            local += (points[i, k] - pose[k, 3]) * pose[k, j]
        if abs(local) > half[j] - margin:
            return False
    return True


@numba.njit(cache=True, error_model="numpy")
def _mark_inside(points: Floats, pose: Floats, half: Floats, margin: float, inside: Bools) -> None:
    for i in range(len(points)):
        if not inside[i]:
            inside[i] = _in_box(points, i, pose, half, margin)


@numba.njit(cache=True, error_model="numpy")
def _boxes_with(points: Floats, poses: Floats, halves: Floats, margin: float, least: int, most: int) -> int:
    boxes, middle, reach = 0, np.zeros((1, 3)), 0.0
    for k in range(3):
        middle[0, k] = points[:, k].mean()
    for i in range(len(points)):
        away = 0.0
        for k in range(3):
            away += (points[i, k] - middle[0, k]) ** 2
        reach = max(reach, np.sqrt(away))
    for b in range(len(poses)):
        count = 0
        if not _in_box(middle, 0, poses[b], halves[b], margin - reach):
            continue  # the box is beyond the ball round them
        for i in range(len(points)):
            count += _in_box(points, i, poses[b], halves[b], margin)
            if count == least:
                boxes += 1
                break
        if boxes == most:
            break
    return boxes


@dataclass(frozen=True)
class Imprint:
    """What the skin felt over every taxel while the pad lay pressed: how far the surface stood in it."""

    pose: Floats  # (4, 4) world_from_sensor; +z out of the skin toward the object
    x: Floats  # (columns,) taxel centers [mm]
    y: Floats  # (rows,)
    depth: Floats  # (rows, columns) [mm], averaged over the taxel and spread by the rubber
    sigma: Floats  # (rows, columns) [mm] standard deviation of `depth`; inf where the taxel is dead
    spread: float  # [mm] standard deviation of the rubber's point spread
    margin: float  # [mm] of skin past the outer taxels
    touch: int = 0

"""What each tick of a track saw of its edge, alone and as arrays of all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numba
import numpy as np

from exploration.control.smoothing_spline import travel_along
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.followed import Followed
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class EdgeTick:
    """The edge as one tick saw it."""

    edge: Followed
    image: TactileImage  # as it was fitted
    world_from_sensor: Floats  # (4, 4)
    force: float  # [N]

    @cached_property
    def point(self) -> Floats:
        """(3,) [mm] of the edge beside the pad's center."""
        return self._placed[0]

    @property
    def tangent(self) -> Floats:
        """(3,) unit direction of travel."""
        return self._placed[1]

    def advanced(self, world_from_sensor: Floats) -> float:
        """[mm] along the edge by which the pad at a (4, 4) pose has gone on."""
        return float(_advanced(self.edge.angle, self.world_from_sensor, world_from_sensor))

    @cached_property
    def _placed(self) -> tuple[Floats, Floats]:
        found: tuple[Floats, Floats] = placed(self.edge.parameters, self.world_from_sensor)
        return found


@dataclass(frozen=True)
class Ticks:
    """Many ticks, as arrays."""

    parameters: Floats  # (n, 6) of `Followed`
    covariances: Floats  # (n, 6, 6)
    sides: Floats  # (n,)
    poses: Floats  # (n, 4, 4) world_from_sensor
    images: tuple[TactileImage, ...]

    @staticmethod
    def of(ticks: Sequence[EdgeTick]) -> "Ticks":
        """The arrays."""
        return Ticks(
            np.array([tick.edge.parameters for tick in ticks]).reshape(-1, 6),
            np.array([tick.edge.covariance for tick in ticks]).reshape(-1, 6, 6),
            np.array([tick.edge.side for tick in ticks], dtype=float),
            np.array([tick.world_from_sensor for tick in ticks]).reshape(-1, 4, 4),
            tuple(tick.image for tick in ticks),
        )

    def __len__(self) -> int:
        return len(self.sides)

    def some(self, which: Bools) -> "Ticks":
        """Those that a mask says."""
        images = tuple(image for image, kept in zip(self.images, which, strict=True) if kept)
        return Ticks(
            self.parameters[which], self.covariances[which], self.sides[which], self.poses[which], images
        )

    @cached_property
    def points(self) -> Floats:
        """(n, 3) [mm] of the edge beside the pad's center."""
        angle, offset, plateau = self.parameters[:, :3].T
        local = np.stack([-offset * np.sin(angle), offset * np.cos(angle), -plateau], axis=1)
        return np.asarray(np.einsum("nij,nj->ni", self.poses[:, :3, :3], local) + self.poses[:, :3, 3])

    @cached_property
    def tangents(self) -> Floats:
        """(n, 3) unit directions of travel."""
        angle = self.parameters[:, 0]
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.asarray(np.einsum("nij,nj->ni", self.poses[:, :3, :2], along))

    @cached_property
    def travel(self) -> Floats:
        """(n,) [mm] along the edge: steps along the tangent, which the noise across it does not lengthen."""
        return travel_along(self.points, self.tangents)

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) outward normal of the face."""
        angle, inward, along = self.parameters[:, [0, 3, 4]].T
        ca, sa = np.cos(angle), np.sin(angle)
        gx, gy = along * ca - self.sides * inward * sa, along * sa + self.sides * inward * ca
        tilt = np.stack([-gx, -gy, -np.ones_like(gx)], axis=1)
        out = np.einsum("nij,nj->ni", self.poses[:, :3, :3], tilt)
        return np.asarray(out / np.linalg.norm(out, axis=1, keepdims=True))


@numba.njit(cache=True, error_model="numpy")
def placed(p: Floats, pose: Floats) -> tuple[Floats, Floats]:
    """(3,) point of the edge of (6,) parameters beside the pad's center, and its direction, in the world."""
    point, tangent = np.empty(3), np.empty(3)
    ca, sa = np.cos(p[0]), np.sin(p[0])
    for i in range(3):
        point[i] = pose[i, 3] + p[1] * (pose[i, 1] * ca - pose[i, 0] * sa) - p[2] * pose[i, 2]
        tangent[i] = pose[i, 0] * ca + pose[i, 1] * sa
    return point, tangent


@numba.njit(cache=True, error_model="numpy")
def _advanced(angle: float, before: Floats, after: Floats) -> float:
    """[mm] from one (4, 4) pose to another in the direction of an angle of the first."""
    ca, sa = np.cos(angle), np.sin(angle)
    gone = 0.0
    for i in range(3):
        gone += (after[i, 3] - before[i, 3]) * (before[i, 0] * ca + before[i, 1] * sa)
    return gone

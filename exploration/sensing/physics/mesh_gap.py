"""The indentation of a skin by triangles: a few are drawn, many are met by rays.

Few facets near the pad are drawn onto its cells (see `raster`).  Else one ray is cast at each corner of the
cells, and one pass integrates them (see `cells`).  Where triangles overlap each other in the sensor's view, or are
too many, the cell is supersampled with rays.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from exploration.sensing.physics.cells import OVERLAP, integrate
from exploration.sensing.physics.coverage import FULL, scratch
from exploration.sensing.physics.facets import NearFacets, facets_of
from exploration.sensing.physics.raster import BEHIND, draw, drawing_room
from exploration.sensing.physics.skin import MODES, Skin, legendre, staggered_lattice
from exploration.sensing.physics.slipped_rays import cast_again
from primitives.arrays import Floats, Ints
from primitives.pose import transform_points
from primitives.surface import TriangleSurface

FEW = 600  # facets near the pad, up to which drawing them is cheaper than rays
_LISTED = 20_000  # triangles of a mesh, beyond which listing the near ones costs more than rays
_QUEUE = 512  # triangles in one cell, beyond which rays are cheaper
_LATTICE = staggered_lattice(8)


class MeshGap:
    """The buffers that the indentation by one mesh keeps from frame to frame."""

    def __init__(self, surface: TriangleSurface, skin: Skin, start: float, few: int = FEW) -> None:
        rows, columns = skin.shape
        rays = (rows + 1) * (columns + 1)
        self._surface, self._skin, self._start, self._few = surface, skin, start, few
        self._vertices = np.ascontiguousarray(surface.vertices, dtype=np.float64)
        self._triangles = np.ascontiguousarray(surface.triangles, dtype=np.int32)
        self._neighbors = np.ascontiguousarray(surface.neighbors, dtype=np.int32)
        self._origins = np.zeros((rays, 3), np.float32)
        self._directions = np.zeros((rays, 3), np.float32)
        self._corners = np.zeros((3, rows + 1, columns + 1))
        self._kinds = np.zeros((rows + 1, columns + 1), np.int32)
        self._states = np.zeros(skin.shape, np.int32)
        self._stamps = np.zeros(len(self._triangles) + 1, np.int64)
        self._queue = np.zeros(_QUEUE, np.int32)
        self._clip = scratch()
        self._covered = np.zeros(skin.shape)
        reach = np.linalg.norm([skin.x_edges[-1], skin.y_edges[-1], start + BEHIND])
        self._near: NearFacets | None = None
        if len(self._triangles) <= _LISTED:
            self._near = NearFacets(facets_of(surface), float(reach))
            self._room = drawing_room(skin.shape, len(self._triangles))
        self.modes = np.zeros((len(MODES), rows, columns))  # [mm] of the latest pose
        self.partial = np.zeros(skin.shape, np.bool_)  # where the modes above the mean matter

    def feel(self, poses: Floats) -> float:
        """Fill `modes` and `partial` at (1, 4, 4) poses, or (2 R + 1, 4, 4): corner row, cell row, corner row...

        The greatest depth [mm] that was met.
        """
        pose = poses[0]
        if self._near is not None:
            self._near.around(pose[0, 3], pose[1, 3], pose[2, 3])
            if len(self._near.facets.normals) <= self._few:
                return self._draw(poses, self._near)
        return self._cast(poses)

    def _draw(self, poses: Floats, near: NearFacets) -> float:
        skin = self._skin
        if len(near.facets.normals) == 0:
            self.modes[:] = 0.0
            self.partial[:] = False
            return 0.0
        deepest, fullest = draw(
            poses,
            skin.x_edges,
            skin.y_edges,
            -self._start - BEHIND,
            near.facets.normals,
            near.facets.start,
            near.facets.loop,
            *self._room,
            self._covered,
            self.modes,
            self.partial,
        )
        if fullest > FULL:
            self._supersample(poses, *np.nonzero(self._covered > FULL))
        return float(deepest)

    def _cast(self, poses: Floats) -> float:
        skin = self._skin
        _aim(poses, skin.x_edges, skin.y_edges, self._start, self._origins, self._directions)
        _, hits = self._surface.first_hits(self._origins, self._directions)
        rays = self._origins, self._directions
        cast_again(self._surface, poses[0], *rays, self._vertices, self._triangles, hits)
        deepest, overlaps = integrate(
            hits,
            poses,
            skin.x_edges,
            skin.y_edges,
            self._start,
            self._vertices,
            self._triangles,
            self._neighbors,
            self._stamps,
            self._queue,
            self._clip[0],
            self._clip[1],
            self._corners,
            self._kinds,
            self._states,
            self.modes,
            self.partial,
        )
        if overlaps:
            self._supersample(poses, *np.nonzero(self._states == OVERLAP))
        return float(deepest)

    def _supersample(self, poses: Floats, rows: Ints, columns: Ints) -> None:
        """Rays over the cells that coverage gave up: a lattice staggered so that no edge runs along it."""
        skin = self._skin
        u, v = _LATTICE
        half_x, half_y = np.diff(skin.x_edges)[columns, None] / 2, np.diff(skin.y_edges)[rows, None] / 2
        local = np.empty((len(rows), len(u), 3))
        local[..., 0] = skin.x_edges[columns, None] + half_x * (1 + u)
        local[..., 1] = skin.y_edges[rows, None] + half_y * (1 + v)
        local[..., 2] = -self._start
        at = poses[2 * rows + 1] if len(poses) > 1 else np.broadcast_to(poses[0], (len(rows), 4, 4))
        origins = transform_points(at, local).astype(np.float32)
        directions = np.broadcast_to(at[:, None, :3, 2], origins.shape).astype(np.float32)
        distance, _ = self._surface.first_hits(origins.reshape(-1, 3), directions.reshape(-1, 3))
        depth = np.maximum(0.0, self._start - distance.astype(np.float64)).reshape(len(rows), -1)
        self.modes[:, rows, columns] = legendre(u, v) @ depth.T / len(u)
        self.partial[rows, columns] = True


@njit(cache=True, error_model="numpy")
def _aim(
    poses: Floats,
    x_edges: Floats,
    y_edges: Floats,
    start: float,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
) -> None:
    columns = len(x_edges)
    for r in range(len(y_edges)):
        p = poses[0] if len(poses) == 1 else poses[2 * r]
        for i in range(3):
            base = p[i, 3] + p[i, 1] * y_edges[r] - p[i, 2] * start
            for c in range(columns):
                origins[r * columns + c, i] = base + p[i, 0] * x_edges[c]
                directions[r * columns + c, i] = p[i, 2]

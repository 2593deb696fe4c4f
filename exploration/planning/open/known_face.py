"""One face as it was felt, place by place: where it is, where it is not, and where it may go on.

From one moment to the next most faces stay as they were; such a face is the same object, and what was found on it
is not looked for again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.dents import dented
from primitives.arrays import Bools, Floats
from primitives.fit import Fit
from primitives.patch_graph import Face

_AROUND = np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False)


@dataclass(frozen=True)
class KnownFaceConfig:
    """Distances about a face."""

    depth: tuple[float, float] = (
        -1.5,
        -0.12,
    )  # [mm] of a free place from the surface, to say it is not there
    beside: float = 2.2  # [mm] a place this near a free one is past the rim
    rim: float = 3.4  # [mm] from a free place, within which a touched one lies at a rim
    within: float = 0.75  # of the way further, nearer than which a place counts as touched
    least_out: float = 0.2  # [mm] in the face's plane to the free place, that tells the way out


@dataclass(frozen=True, eq=False)
class KnownFace:
    """A fitted face and what was felt of it."""

    face: Face
    fit: Fit
    side: float  # of the shape's normals, outward
    cells: Floats  # (n, 3) touched places on it
    free: Floats  # (n, 3) free places that say where it is not
    reach: float = 5.0  # [mm] further than a touched place, where the face is asked for
    config: KnownFaceConfig = KnownFaceConfig()

    @staticmethod
    def of(face: Face, fit: Fit, felt: SurfaceMap, free: Floats, reach: float) -> KnownFace:
        """A face among all that was felt, and (n, 3) places that were found free."""
        side, none = (1.0 if fit.convex else -1.0), np.empty((0, 3))
        return KnownFace(face, fit, side, none, none, reach).grown(felt, free)

    def grown(self, felt: SurfaceMap, free: Floats, since: tuple[int, int] = (0, 0)) -> KnownFace:
        """With what was felt and found free `since` so many places were known; itself, if that is nothing."""
        cells = felt.points[since[0] :][felt.on(self.fit.shape, self.side, since[0])]
        above = self.side * self.fit.shape.signed_distance(free[since[1] :])
        low, high = self.config.depth
        away = free[since[1] :][(above > low) & (above < high)]
        if not len(cells) and not len(away):
            return self
        return replace(
            self, cells=np.concatenate([self.cells, cells]), free=np.concatenate([self.free, away])
        )

    @cached_property
    def near(self) -> KDTree:
        """Of its cells."""
        return KDTree(self.cells)

    @cached_property
    def near_free(self) -> KDTree:
        """Of its free places."""
        return KDTree(self.free)

    def touched(self, at: Floats, within: float) -> Bools:
        """(n,) whether it was touched nearer than `within` [mm] to (n, 3) places."""
        return np.asarray(self.near.query(at, distance_upper_bound=within)[0] < within)

    @cached_property
    def dented(self) -> bool:
        """Whether it is flat, and not there among places where it is: no convex object has such a face."""
        return self.fit.kind == "plane" and dented(self.cells, self.free, self.fit.shape.direction)

    @cached_property
    def further(self) -> tuple[Floats, Floats]:
        """(m, 3) places a little further than touched ones, neither touched nor past a rim; whence each is."""
        normals = self.fit.shape.normals(self.cells)
        u = np.cross(normals, np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(normals, u)
        steps = [self.reach * (np.cos(a) * u + np.sin(a) * v) for a in _AROUND]
        at = self.fit.shape.project(np.concatenate([self.cells + step for step in steps]))
        came = np.tile(self.cells, (len(steps), 1))
        fresh = ~self.touched(at, self.config.within * self.reach)
        at, came = at[fresh], came[fresh]
        on = ~self._past_rim(at, came)
        return at[on], came[on]

    def _past_rim(self, at: Floats, came: Floats) -> Bools:
        """(m,) whether (m, 3) places, or the way to them, lie beside a free place."""
        out, beside = np.zeros(len(at), dtype=bool), self.config.beside
        if len(self.free) and len(at):
            for share in (0.6, 0.8, 1.0):
                between = came + share * (at - came)
                out |= self.near_free.query(between, distance_upper_bound=beside)[0] < beside
        return out

    @cached_property
    def rim(self) -> tuple[Floats, Floats]:
        """(n, 3) touched cells beside free ones, and the ways out of the face there."""
        if not len(self.free) or not len(self.cells):
            return np.empty((0, 3)), np.empty((0, 3))
        distance, found = self.near_free.query(self.cells, distance_upper_bound=self.config.rim)
        beside = np.asarray(distance < self.config.rim)
        at = self.cells[beside]
        out = self.free[np.asarray(found)[beside]] - at
        normals = self.fit.shape.normals(at)
        out = out - (out * normals).sum(axis=1, keepdims=True) * normals
        length = np.linalg.norm(out, axis=1)
        far = length > self.config.least_out
        return at[far], out[far] / length[far, None]

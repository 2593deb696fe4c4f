"""Touched places of a flat face that hang together, seen from their middle: where one goes on from there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Floats

_UPRIGHT = 0.999  # least cosine between a round wall's axis and the normal of its floor
_STEPS, _AGAINST = 40, 0.3  # places on a way that are looked at; least cosine of what one goes into
_OVER = 1.0  # [mm] of a floor past the round wall about it


@dataclass(frozen=True)
class Patch:
    """Touched places of a face that hang together."""

    own: KnownFace
    cells: Floats  # (n, 3)
    normal: Floats  # (3,) outward

    @property
    def middle(self) -> Floats:
        """(3,) [mm]."""
        return np.asarray(self.cells.mean(axis=0))

    def edge(self, way: Floats) -> float:
        """[mm] along `way` of its farthest place."""
        return float((self.cells @ way).max())

    def ahead(self, points: Floats, way: Floats, side: float) -> Floats:
        """(m,) [mm] along `way` of those of (n, 3) points that lie straight ahead of its middle.

        Beside that a share `side` of its own places lies on either hand.
        """
        if not len(points):
            return np.empty(0)
        along = np.cross(self.normal, way)
        low, high = np.quantile(self.cells @ along, [side, 1.0 - side])
        where, far = points @ along, points @ way
        return np.asarray(far[(where > low) & (where < high) & (far > float(self.middle @ way))])

    def beside(self, points: Floats, near: float) -> float:
        """Share of its places with none of (n, 3) points straight over or under them, within `near` [mm]."""
        axes = np.linalg.svd(self.normal[None])[2][1:]
        away = np.asarray(KDTree(points @ axes.T).query(self.cells @ axes.T)[0])
        return float(np.mean(away > near))

    def enters(
        self,
        known: Sequence[KnownFace],
        way: Floats,
        span: tuple[float, float],
        height: float,
        into: float = 1.0,
    ) -> bool:
        """Whether one goes into a known face, or out of one where `into` is -1, along `way` past its middle.

        From `span[0]` to `span[1]` [mm] along it, `height` [mm] over its places.
        """
        start = self.middle + height * self.normal - float(self.middle @ way) * way
        steps = start + np.linspace(*span, _STEPS)[:, None] * way
        for own in known:
            outside = into * own.side * own.fit.shape.signed_distance(steps)
            crossed = np.flatnonzero((outside[:-1] > 0.0) & (outside[1:] <= 0.0))
            if len(crossed):
                normal = own.side * own.fit.shape.normals(steps[crossed[:1]])[0]
                if into * float(normal @ way) < -_AGAINST:
                    return True
        return False

    def in_round_hole(self, known: Sequence[KnownFace]) -> bool:
        """Whether it is the floor of a hole whose upright round wall is one of the `known` faces."""
        return any(self._within(own) for own in known)

    def _within(self, own: KnownFace) -> bool:
        shape = own.fit.shape
        upright = own.fit.kind == "cylinder" and abs(float(shape.direction @ self.normal)) > _UPRIGHT
        return upright and own.side < 0.0 and float(shape.signed_distance(self.cells).max()) < _OVER

"""Flat regions bounded by polygons, and what they have in common: sections of bodies, outlines of plates."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from models.meshing.manifold import CrossSection, FillRule, JoinType, OpType
from primitives.arrays import Floats
from primitives.outlines import depth_inside

_CORNERS = 3  # of a polygon, at least
_CUTS = 400  # through holes, after which what is left is too fine to matter
_FINEST = 1e-3  # [mm] from a straight line, up to which a corner is none


class Region:
    """Any number of polygons in one plane, with holes [mm]; nothing changes it."""

    def __init__(self, section: Any = None) -> None:
        self._section = CrossSection() if section is None else section

    @staticmethod
    def of(rims: Iterable[Floats]) -> Region:
        """What lies inside an odd number of closed rims of (n, 2) corners."""
        loops = [np.ascontiguousarray(rim, dtype=np.float64) for rim in rims if len(rim) >= _CORNERS]
        return Region(CrossSection(loops, FillRule.EvenOdd)) if loops else Region()

    @staticmethod
    def disks(centers: Floats, radius: float, corners: int = 16) -> Region:
        """Round (n, 2) centers, of so many corners each."""
        disk = CrossSection.circle(radius, corners)
        round_each = [disk.translate(tuple(center)) for center in np.asarray(centers, dtype=float)]
        if not round_each:
            return Region()
        return Region(CrossSection.batch_boolean(round_each, OpType.Add))

    def __or__(self, other: Region) -> Region:
        return Region(self._section + other._section)

    def __and__(self, other: Region) -> Region:
        return Region(self._section ^ other._section)

    def __sub__(self, other: Region) -> Region:
        return Region(self._section - other._section)

    def __bool__(self) -> bool:
        return not self._section.is_empty()

    @property
    def area(self) -> float:
        """[mm^2]."""
        return float(self._section.area())

    def grown(self, by: float) -> Region:
        """By so many mm all round, its corners as they are; a negative number takes away.

        What is outside shrinks: the library goes by the outline that reaches farthest, and takes a hole that
        touches the outer one there for that.
        """
        if not self:
            return Region()
        margin = 2.0 * abs(by) + 1.0
        near, far = (_frame(self._section, many * margin) for many in (1.0, 2.0))
        return Region(near - (far - self._section).offset(-by, JoinType.Miter))

    def opened(self, by: float) -> Region:
        """Without what is narrower than 2 `by` mm."""
        return self.grown(-by).grown(by) & self

    def depth(self, places: Floats) -> Floats:
        """(n,) [mm] that (n, 2) places lie inside it; outside it is negative."""
        return depth_inside(self._section.to_polygons(), places)

    @property
    def pieces(self) -> list[Region]:
        """What of it hangs together, each by itself."""
        return [Region(part) for part in self._section.decompose()]

    @property
    def rims(self) -> list[Floats]:
        """Closed rims of (n, 2) corners, those of holes clockwise."""
        return [np.asarray(loop, dtype=np.float64) for loop in self._section.simplify(_FINEST).to_polygons()]

    @property
    def polygons(self) -> list[Floats]:
        """(n, 2) corners of polygons without holes, counterclockwise, that are the region together."""
        whole: list[Floats] = []
        left = [self._section.simplify(_FINEST)]
        for _ in range(_CUTS):
            if not left:
                break
            for part in left.pop().decompose():
                loops = part.to_polygons()
                if len(loops) == 1:
                    whole.append(np.asarray(loops[0], dtype=np.float64))
                elif loops:
                    hole = min(loops, key=lambda loop: float(np.prod(np.ptp(loop, axis=0))))
                    left += _halves(part, 0.5 * float(hole[:, 0].min() + hole[:, 0].max()))
        return whole


def section(mesh: Any, world_from_plane: Floats) -> Region:
    """Of a manifold, in the plane z = 0 of a (4, 4) pose."""
    turn = world_from_plane[:3, :3].T
    back = np.column_stack([turn, -turn @ world_from_plane[:3, 3]])
    return Region(mesh.transform(back).slice(0.0))


def _frame(part: Any, margin: float) -> Any:
    """A box round a part, with so many mm on each side."""
    x0, y0, x1, y1 = part.bounds()
    wide, high = x1 - x0 + 2.0 * margin, y1 - y0 + 2.0 * margin
    return CrossSection.square((wide, high)).translate((x0 - margin, y0 - margin))


def _halves(part: Any, x: float) -> list[Any]:
    """What lies to either side of a line across x [mm]."""
    x0, y0, x1, y1 = part.bounds()
    tall = (y1 - y0) + 2.0
    sides = ((x0 - 1.0, x - x0 + 1.0), (x, x1 - x + 1.0))
    return [part ^ CrossSection.square((wide, tall)).translate((low, y0 - 1.0)) for low, wide in sides]

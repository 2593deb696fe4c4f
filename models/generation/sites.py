"""Rectangles on a part's flat faces where a feature may go without meeting another."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from primitives.arrays import Floats
from primitives.pose import pose


@dataclass(frozen=True, eq=False)
class Site:
    """A free rectangle; z points out of the face, the origin is in the middle, material lies below."""

    part_from_site: Floats  # (4, 4)
    width: float  # [mm] along x
    length: float  # [mm] along y
    thickness: float  # [mm] of material below that is this site's own
    through: bool  # whether what goes through all of it comes out in the open
    raised: bool = True  # whether what stands out of it meets nothing

    @property
    def room(self) -> float:
        """The diameter of the largest circle in it [mm]."""
        return min(self.width, self.length)

    def part(self, x: float, y: float, width: float, length: float) -> Site:
        """The rectangle of another size about (x, y)."""
        moved = self.part_from_site @ pose(None, (x, y, 0.0))
        return replace(self, part_from_site=moved, width=width, length=length)

    def halves(self, share: float) -> tuple[Site, Site]:
        """The two sides of a cut across the longer direction, in whole mm."""
        whole = max(self.width, self.length)
        first = float(round(share * whole))
        second = whole - first
        if self.width >= self.length:
            return (
                self.part((first - whole) / 2, 0, first, self.length),
                self.part((whole - second) / 2, 0, second, self.length),
            )
        return (
            self.part(0, (first - whole) / 2, self.width, first),
            self.part(0, (whole - second) / 2, self.width, second),
        )

    def cells(self, columns: int, rows: int) -> tuple[Site, ...]:
        """Equal rectangles, in whole mm, that fill it as far as they go."""
        width, length = float(self.width // columns), float(self.length // rows)
        return tuple(
            self.part(width * (i - (columns - 1) / 2), length * (j - (rows - 1) / 2), width, length)
            for i in range(columns)
            for j in range(rows)
        )


def facing(x: float, y: float, z: float, out: str = "z") -> Floats:
    """(4, 4) part_from_site at a point of a face whose outside is towards z, x or -y."""
    axes = {
        "z": np.eye(3),
        "x": np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        "-y": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    }
    return pose(axes[out], (x, y, z))

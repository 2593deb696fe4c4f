"""Strokes that were stopped, and how what stopped them may stand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from exploration.planning.touching.study import Wall
from primitives.arrays import Floats


class Stop(NamedTuple):
    """A stroke that was stopped, and how the wall stands that may have done it."""

    wall: Wall
    normal: Floats  # (3,) out of the wall
    offset: float  # [mm] of the wall along it

    @property
    def along(self) -> Floats:
        """(3,) the way along the wall, on the face that it stands on."""
        along = np.cross(self.wall.normal, self.normal)
        return np.asarray(along / np.linalg.norm(along))

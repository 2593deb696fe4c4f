"""A straight prism over any simple polygon; its distance combines the polygon's and the height's exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.leaves.distances import box_distance, positive_length
from models.leaves.expression import Primitive
from models.leaves.polygons import cleaned, crosses_itself, polygon_distance
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.outlines import signed_area


@dataclass(frozen=True, repr=False)
class Prism(Primitive):
    """A polygon in x and y, from z = -height / 2 to z = height / 2; it need not be convex.

    Corners are kept counterclockwise and without those on a straight side.
    """

    outline: tuple[tuple[float, float], ...]  # (x, y) [mm]
    height: float  # [mm]
    name: str = ""

    def __post_init__(self) -> None:
        try:
            corners = np.array(self.outline, dtype=float).reshape(len(self.outline), 2)
        except (TypeError, ValueError):
            raise PalpateError("a prism's outline is a sequence of (x, y) corners in mm") from None
        if not np.isfinite(corners).all():
            raise PalpateError("a prism's outline must be finite")
        corners = cleaned(corners)
        if len(corners) < 3 or not signed_area(corners) > 0:
            raise PalpateError("a prism's outline needs three corners or more that are not on one line")
        if crosses_itself(corners):
            raise PalpateError("a prism's outline crosses or touches itself; cut it into simple polygons")
        object.__setattr__(self, "outline", tuple((float(x), float(y)) for x, y in corners + 0.0))
        object.__setattr__(self, "height", positive_length(self.height, "a prism's height"))

    def support(self, directions: Floats) -> Floats:
        """Of the farthest corner."""
        across = (directions[:, :2] @ np.array(self.outline).T).max(axis=1)
        reach: Floats = across + self.height / 2 * np.abs(directions[:, 2])
        return reach

    def signed_distance(self, points: Floats) -> Floats:
        """Of the polygon and of the height, as a box combines its sides."""
        across = polygon_distance(points[:, :2], np.array(self.outline))
        return box_distance(np.stack([across, np.abs(points[:, 2]) - self.height / 2], axis=1))

    def __repr__(self) -> str:
        return f"Prism({self.outline!r}, {self.height!r}" + self._label()

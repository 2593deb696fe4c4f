"""A body made of pieces, and what is known round it: for what is added to it and taken from it once it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError
from primitives.pose import frame_along
from primitives.shapes import Cylinder, Plane, Shape
from recognition.assembly.piece import Piece

FLUSH = 0.995  # least cosine of directions that are one
_MOST = 16  # directions, and frames, that are tried: a gear has as many as it has teeth
CRUMB = 0.1  # [mm^3]
_ACROSS = 1e-2  # most cosine of directions across each other


@dataclass(frozen=True)
class Body:
    """A body of pieces, made again with others."""

    pieces: tuple[Piece, ...]
    solid: Solid
    facet: float  # [mm]

    def less(self, piece: Piece, torn: bool = False) -> Body | None:
        """Without what one piece takes away; None where that leaves nothing, or tears it apart and may not."""
        assert self.solid.csg is not None
        try:
            solid = Solid.from_csg(self.solid.csg - piece.placed, self.facet)
        except PalpateError:
            return None
        made = Body((*self.pieces, piece), solid, self.facet)
        return made if torn or made.shells <= self.shells else None

    def more(self, piece: Piece) -> Body | None:
        """With one piece more; None where that does not hang together with it."""
        assert self.solid.csg is not None
        solid = Solid.from_csg(self.solid.csg | piece.placed, self.facet)
        made = Body((*self.pieces, piece), solid, self.facet)
        return made if made.shells <= self.shells else None

    @property
    def shells(self) -> int:
        """Closed surfaces that bound it, less crumbs that rounding leaves."""
        return sum(abs(part.volume()) > CRUMB for part in self.solid.body.mesh.decompose())


@dataclass(frozen=True)
class Known:
    """All surfaces with places of theirs, whether felt or not, and what was felt on none of them."""

    shapes: Sequence[Shape]
    places: Sequence[Floats]  # of each surface (n, 3) [mm]
    inferred: Sequence[bool]  # whether nobody felt it
    stray: Floats  # (n, 3) [mm]

    @property
    def felt(self) -> Floats:
        """(n, 3) [mm] on surfaces."""
        lots = [at for at, told in zip(self.places, self.inferred, strict=True) if not told]
        return np.concatenate([np.empty((0, 3)), *lots])

    @property
    def directions(self) -> list[Floats]:
        """Directions of the object, each once: flat faces' first, of these those with the most places."""
        kept: list[Floats] = []
        order = sorted(range(len(self.shapes)), key=lambda k: -len(self.places[k]))
        for kind in ("plane", "cylinder", "cone"):
            for shape in (self.shapes[k] for k in order):
                if shape.kind == kind and all(abs(float(shape.direction @ k)) < FLUSH for k in kept):
                    kept.append(shape.direction)
        return kept[:_MOST]

    @property
    def frames(self) -> list[Floats]:
        """(3, 3) right-handed frames along pairs of perpendicular directions, or along single ones."""
        ways = self.directions
        square = [frame_along(a, b) for a, b in combinations(ways, 2) if abs(float(a @ b)) < _ACROSS]
        return (square or [frame_along(a) for a in ways])[:_MOST]


def thinned(places: Floats, cell: float) -> Floats:
    """Of (n, 3) places the first in each cell [mm]; none that is not a number."""
    whole = places[np.isfinite(places).all(axis=1)]
    if not len(whole):
        return whole
    first = np.unique(np.round(whole / cell), axis=0, return_index=True)[1]
    return whole[np.sort(first)]


def level_of(plane: Plane, way: Floats, middle: Floats) -> float:
    """[mm] along a (3,) way, at which a line along it through a (3,) middle crosses a plane."""
    to_plane = float((plane.origin - middle) @ plane.normal) / float(way @ plane.normal)
    return float(middle @ way) + to_plane


def axis_beside(shape: Cylinder, middle: Floats) -> Floats:
    """(3,) the place on a cylinder's axis that is level with a (3,) middle."""
    return np.asarray(shape.anchor + float((middle - shape.anchor) @ shape.direction) * shape.direction)


def among(places: Floats, others: Floats, near: float) -> Bools:
    """(n,) which of (n, 3) places lie `near` [mm] one of (m, 3) others."""
    if not len(others):
        return np.zeros(len(places), dtype=bool)
    return np.asarray(KDTree(others).query(places)[0] < near)


def drawn(low: Floats, high: Floats, count: int) -> Floats:
    """(n, 3) places anywhere between two (3,) corners, the same in every run."""
    return np.asarray(low + (high - low) * np.random.default_rng(0).random((count, 3)))

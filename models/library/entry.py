"""One object of a library: its solid and everything that is known of it before it is touched.

Each part is made, or read from the store, when it is first asked for, and kept.  All is in the object's own frame.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from models.boundary import labeled_boundary
from models.brep import Brep
from models.freeform_symmetry import symmetry_of_solid
from models.library.field import DistanceField, distance_field
from models.library.pair_table import pair_scores
from models.library.samples import SurfaceSamples, surface_samples
from models.solid import Solid
from models.symmetry import SymmetryGroup


class Source(Protocol):
    """Where an entry's parts come from."""

    def solid(self) -> Solid:
        """In its own frame."""
        ...

    def brep(self) -> Brep:
        """Its boundary."""
        ...

    def symmetry(self) -> SymmetryGroup:
        """The rotations that change nothing."""
        ...

    def samples(self) -> SurfaceSamples:
        """Points that stand for its surface."""
        ...

    def field(self) -> DistanceField:
        """Its distance on a grid."""
        ...

    def pairs(self) -> NDArray[np.uint8]:
        """How probable the distance and angles of two of its places are."""
        ...


class Computed:
    """Everything from the solid, when asked for."""

    def __init__(self, solid: Solid) -> None:
        self._solid = solid.placed(np.eye(4))

    def solid(self) -> Solid:
        """See `Source`."""
        return self._solid

    def brep(self) -> Brep:
        """See `Source`."""
        return labeled_boundary(self._solid)[0]

    def symmetry(self) -> SymmetryGroup:
        """See `Source`."""
        return symmetry_of_solid(self._solid, self.brep())

    def samples(self) -> SurfaceSamples:
        """See `Source`."""
        return self._samples

    @cached_property
    def _samples(self) -> SurfaceSamples:
        return surface_samples(self._solid)

    def field(self) -> DistanceField:
        """See `Source`."""
        return distance_field(self._solid)

    def pairs(self) -> NDArray[np.uint8]:
        """See `Source`."""
        return pair_scores(self._samples)


class Entry:
    """One object of a library."""

    def __init__(self, name: str, source: Source, file: Path | None = None, material: str = "") -> None:
        self.name = name
        self.file = file  # that it was read from; None for one that is in memory only
        self.material = material  # as `library.toml` says it: a word, or a file
        self._source = source

    @cached_property
    def solid(self) -> Solid:
        """In its own frame."""
        return self._source.solid()

    @cached_property
    def brep(self) -> Brep:
        """Its boundary."""
        return self._source.brep()

    @cached_property
    def symmetry(self) -> SymmetryGroup:
        """The rotations that change nothing."""
        return self._source.symmetry()

    @cached_property
    def samples(self) -> SurfaceSamples:
        """Points that stand for its surface, with normals and curvatures."""
        return self._source.samples()

    @cached_property
    def field(self) -> DistanceField:
        """Its signed distance on a grid: fast, and good to half a cell at edges; `solid` has it exactly."""
        return self._source.field()

    @cached_property
    def pairs(self) -> NDArray[np.uint8]:
        """How probable the distance and angles of two of its places are: a column of `pair_table.PairTable`."""
        return self._source.pairs()

    def __repr__(self) -> str:
        return f"Entry({self.name!r})"

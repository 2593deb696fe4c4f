"""An entry's parts out of the store, mapped when first asked for; out of its file where the store lost them."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.brep import Brep
from models.library import record
from models.library.build import read_part
from models.library.field import DistanceField
from models.library.folder import ModelFile
from models.library.packed import map_arrays
from models.library.samples import SurfaceSamples
from models.solid import Solid
from models.symmetry import SymmetryGroup


class Stored:
    """Implements `models.library.entry.Source`."""

    def __init__(self, path: Path, file: ModelFile) -> None:
        self._path = path
        self._file = file

    @cached_property
    def arrays(self) -> dict[str, Any]:
        """Mapped, or made again."""
        found = map_arrays(self._path)
        return record.record(read_part(self._file)) if found is None else found

    def solid(self) -> Solid:
        """The stored mesh, within the tolerance of its thinning."""
        return record.solid_of(self.arrays, self.brep())

    def brep(self) -> Brep:
        """See `Source`."""
        return record.brep_of(self.arrays)

    def symmetry(self) -> SymmetryGroup:
        """See `Source`."""
        return record.symmetry_of(self.arrays)

    def samples(self) -> SurfaceSamples:
        """See `Source`."""
        return record.samples_of(self.arrays)

    def field(self) -> DistanceField:
        """See `Source`."""
        return record.field_of(self.arrays)

    def pairs(self) -> NDArray[np.uint8]:
        """See `Source`."""
        return record.pairs_of(self.arrays)

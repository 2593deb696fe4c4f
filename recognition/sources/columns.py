"""The columns of a contact table, whatever file they came from."""

from __future__ import annotations

from dataclasses import dataclass

from primitives.arrays import Floats


@dataclass(frozen=True)
class Columns:
    """Rows as they stand in the file; nothing is checked yet."""

    points: Floats  # (n, 3) [mm]
    normals: Floats | None = None  # (n, 3); nan where none was felt
    sigma: Floats | None = None  # (n,) [mm]; nan where nobody said

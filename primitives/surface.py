"""What a simulated sensor or a clearance check may ask of an object: distance, normals, ray hits.

`models` implements these protocols and `exploration` uses them, so neither imports the other.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class RayHits:
    """Where rays first meet a surface."""

    distance: Floats  # (n,) [mm] along the unit direction; inf where nothing is hit
    normals: Floats  # (n, 3) outward unit normal at the hit; zero where nothing is hit
    element: Ints  # (n,) index of the triangle or face that is hit; -1 where nothing is hit


class Surface(Protocol):
    """The boundary of a solid."""

    def signed_distance(self, points: Floats) -> Floats:
        """Distance of (n, 3) points [mm] to the surface, negative inside: (n,) [mm]."""
        ...

    def normals(self, points: Floats) -> Floats:
        """Outward unit normals at the surface points nearest to (n, 3) points: (n, 3)."""
        ...

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits of (n, 3) origins [mm] along (n, 3) unit directions."""
        ...


@runtime_checkable
class TriangleSurface(Surface, Protocol):
    """A surface made of triangles, wound so that normals point out; lets a caster integrate exactly."""

    @property
    def vertices(self) -> Floats:
        """(v, 3) [mm]."""
        ...

    @property
    def triangles(self) -> Ints:
        """(t, 3) vertex indices."""
        ...

    @property
    def neighbors(self) -> Ints:
        """(t, 3) triangle across the edge from corner i to corner i + 1; -1 at an open rim."""
        ...

    def first_hits(
        self, origins: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """The fast path: distance (n,) and triangle (n,), or inf and -1, of (n, 3) contiguous rays."""
        ...


@runtime_checkable
class MaterialSurface(Surface, Protocol):
    """A surface that yields under pressure, or is rough; one that is neither costs a simulator nothing."""

    @property
    def uniform(self) -> tuple[float, float] | None:
        """Stiffness [N/mm^3] and roughness [mm] where they are the same all over."""
        ...

    def materials_at(self, points: Floats) -> tuple[Floats, Floats]:
        """Of the faces nearest to (n, 3) points: stiffness (n,) [N/mm^3], inf where rigid; roughness (n,) [mm]."""
        ...

    def grain_at(self, points: Floats) -> Floats:
        """(n,) heights of unit root mean square at (n, 3) points, the same whenever they are asked for."""
        ...


@runtime_checkable
class WarmSurface(Surface, Protocol):
    """A surface that is not as warm as the air."""

    @property
    def temperature(self) -> float:
        """[deg C]."""
        ...

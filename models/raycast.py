"""First hits of rays on triangles: embree where it is installed, our own tree where it is not.

`caster` returns a `RayCaster` over one set of triangles; a posed solid moves its rays, never its triangles.
Both cast in single precision, so keep coordinates small: the part's own frame is best.
"""

import logging
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from models.rays.triangle_tree import TriangleTree
from primitives.arrays import Floats, Ints

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except ImportError:
    EmbreeScene = None

_log = logging.getLogger(__name__)

Singles = NDArray[np.float32]
Indices = NDArray[np.int32]


class RayCaster(Protocol):
    """Something that finds the first triangle along a ray."""

    def first_hits(self, origins: Singles, directions: Singles) -> tuple[Singles, Indices]:
        """Distance (n,) [directions' length] and triangle (n,), or inf and -1, of (n, 3) contiguous rays."""
        ...


class EmbreeCaster:
    """Embree through embreex; releases the interpreter while it casts."""

    def __init__(self, vertices: Floats, triangles: Ints) -> None:
        self._scene: Any = EmbreeScene(robust=True)
        TriangleMesh(self._scene, vertices.astype(np.float32), triangles.astype(np.int32))

    def first_hits(self, origins: Singles, directions: Singles) -> tuple[Singles, Indices]:
        """See `RayCaster`."""
        hits = self._scene.run(origins, directions, output=1)
        distance, triangle = hits["tfar"], hits["primID"]
        distance[triangle < 0] = np.inf
        return distance, triangle


class PortableCaster:
    """Our own tree, compiled by numba: for machines without embree."""

    def __init__(self, tree: TriangleTree) -> None:
        self._tree = tree

    def first_hits(self, origins: Singles, directions: Singles) -> tuple[Singles, Indices]:
        """See `RayCaster`."""
        return self._tree.first_hits(origins, directions)


def has_embree() -> bool:
    """Whether rays are cast by embree."""
    return EmbreeScene is not None


def caster(vertices: Floats, triangles: Ints) -> RayCaster:
    """The fastest caster that this machine has over (v, 3) vertices [mm] and (t, 3) triangles."""
    if has_embree():
        return EmbreeCaster(vertices, triangles)
    _log.info("embreex is not installed: casting rays with the portable tree")
    return PortableCaster(TriangleTree(vertices, triangles))

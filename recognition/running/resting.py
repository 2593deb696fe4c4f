"""Where a part may lie on a table: on a facet of its convex hull over which its middle of mass stands."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial import ConvexHull, QhullError

from models.solid import Solid
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError

_SAME = 1e-4  # of a normal, and of the size of an offset, within which two triangles are one facet


def resting_attitude(solid: Solid, rng: np.random.Generator) -> Floats:
    """A (3, 3) rotation that lays a part on a facet, drawn by area, and turns it about the vertical at random."""
    try:
        hull = ConvexHull(solid.vertices)
    except QhullError as error:
        raise PalpateError("the part is flat, so it cannot lie on a table; give another part") from error
    middle = trimesh.Trimesh(solid.vertices, solid.triangles, process=False).center_mass
    size = float(np.ptp(solid.vertices, axis=0).max())
    key = np.round(hull.equations / [_SAME, _SAME, _SAME, _SAME * size]).astype(np.int64)
    _, facet = np.unique(key, axis=0, return_inverse=True)
    corners = hull.points[hull.simplices]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    for chosen in rng.choice(len(areas), len(areas), replace=False, p=areas / areas.sum()):
        normal = hull.equations[chosen, :3]
        if _stands(hull.points[np.unique(hull.simplices[facet == facet[chosen]])], normal, middle):
            spin = se3.rotation_exp([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
            return np.asarray(spin @ se3.frame_along(-normal, None).T)
    raise PalpateError("the part lies on none of its sides; give its --pose")


def _stands(corners: Floats, normal: Floats, middle: Floats) -> bool:
    """Whether the middle of mass is over a facet of (n, 3) corners."""
    axes = se3.frame_along(normal, None)[:, :2]
    try:
        outline = ConvexHull(corners @ axes)
    except QhullError:
        return False
    return bool((outline.equations[:, :2] @ (middle @ axes) + outline.equations[:, 2] < 0.0).all())

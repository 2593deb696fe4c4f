"""From a surface to the skin's indentation: depth(x, y) = max(0, -z of the object's surface), over each cell.

Rays leave a bounded distance behind the skin along +z, so that a deep press is felt and what lies far behind
the pad is not.  For a surface without triangles each cell is supersampled.
"""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.skin import MODES, Skin, skin_of
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.surface import Surface

_SAMPLES = 8  # rays along each side of a cell


@dataclass(frozen=True)
class Indentation:
    """How deep an object indents each cell of the skin."""

    modes: Floats  # (..., 6, R, C) [mm] Legendre coefficients, in the order of `skin.MODES`
    deepest: Floats  # (...) [mm] greatest depth that a ray met; 0 out of contact

    @property
    def depth(self) -> Floats:
        """(..., R, C) [mm] mean over each cell, margin included."""
        mean: Floats = self.modes[..., 0, :, :]
        return mean


def indentation(surface: Surface, world_from_sensor: Floats, spec: SensorSpec) -> Indentation:
    """The skin's indentation at one (4, 4) pose or at (n, 4, 4)."""
    skin = skin_of(spec)
    poses = world_from_sensor.reshape(-1, 4, 4)
    found = [_supersampled(surface, p, skin, spec.elastomer.thickness) for p in poses]
    modes = np.stack([m for m, _ in found]).reshape(*world_from_sensor.shape[:-2], len(MODES), *skin.shape)
    return Indentation(modes, np.array([d for _, d in found]).reshape(world_from_sensor.shape[:-2]))


def _supersampled(surface: Surface, pose: Floats, skin: Skin, thickness: float) -> tuple[Floats, float]:
    n = _SAMPLES
    u = (np.arange(n) * 2 + 1) / n - 1
    x = (skin.x_edges[:-1] + skin.x_edges[1:])[:, None] / 2 + np.diff(skin.x_edges)[:, None] / 2 * u
    y = (skin.y_edges[:-1] + skin.y_edges[1:])[:, None] / 2 + np.diff(skin.y_edges)[:, None] / 2 * u
    grid = np.stack(np.broadcast_arrays(x[None, :, None, :], y[:, None, :, None], -thickness), axis=-1)
    origins = grid.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    hits = surface.cast_rays(origins, np.broadcast_to(pose[:3, 2], origins.shape))
    depth = np.maximum(0.0, thickness - hits.distance).reshape(*skin.shape, n, n)
    p = np.stack([np.ones_like(u), u, (3 * u**2 - 1) / 2])
    norm = np.array([1.0, 3.0, 5.0])
    modes = [np.einsum("rcyx,x,y->rc", depth, p[i], p[j]) * norm[i] * norm[j] / n**2 for i, j in MODES]
    return np.stack(modes), float(depth.max())

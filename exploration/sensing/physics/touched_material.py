"""What the object's material does to the skin's indentation: its grain adds to it, its giving way takes from it.

Skin and object are two Winkler foundations in series.  Where their surfaces would overlap by d, the pressure is
p = d k_s k_o / (k_s + k_o), and so the skin gives way by d k_o / (k_s + k_o) and the object by the rest (our
derivation).  Heights h of the grain add to d before that, where the two touch: depth = max(0, d + h).
"""

import numpy as np

from exploration.sensing.physics.skin import Skin, legendre, shapes, staggered_lattice
from primitives.arrays import Bools, Floats
from primitives.surface import MaterialSurface

_LATTICE = staggered_lattice(4)  # places in a cell at which the grain is read


class TouchedMaterial:
    """Turns the overlap of skin and object into the skin's indentation, in place."""

    def __init__(self, surface: MaterialSurface, skin: Skin, stiffness: float) -> None:
        """`stiffness` [N/mm^3] of the skin."""
        self._surface, self._stiffness = surface, stiffness
        u, v = _LATTICE
        x = (skin.x_edges[:-1] + skin.x_edges[1:]) / 2
        y = (skin.y_edges[:-1] + skin.y_edges[1:]) / 2
        half_x, half_y = np.diff(skin.x_edges) / 2, np.diff(skin.y_edges) / 2
        self._middle = np.stack(np.broadcast_arrays(x[None], y[:, None]), axis=-1)  # (R, C, 2)
        self._offset = np.stack(
            np.broadcast_arrays((half_x[:, None] * u)[None], (half_y[:, None] * v)[:, None]), axis=-1
        )  # (R, C, s, 2)
        self._analysis = legendre(u, v) / len(u)  # (10, s)
        self._synthesis = shapes(u, v)

    def give_way(self, poses: Floats, modes: Floats, partial: Bools, deepest: float) -> float:
        """Change (10, R, C) modes at poses as `Gap.feel` takes them; the greatest depth [mm] afterwards."""
        if self._surface.uniform is not None and self._surface.uniform[1] == 0.0:
            share = 1.0 / (1.0 + self._stiffness / self._surface.uniform[0])
            modes *= share
            return deepest * share
        rows, columns = np.nonzero(modes[0] > 0.0)
        if not len(rows):
            return deepest
        at = poses[2 * rows + 1] if len(poses) > 1 else np.broadcast_to(poses[0], (len(rows), 4, 4))
        overlap: Floats = modes[:, rows, columns]
        middle = np.column_stack([self._middle[rows, columns], -overlap[0]])
        stiffness, roughness = self._surface.materials_at(_placed(at, middle))
        if roughness.any():
            overlap = self._roughened(at, rows, columns, overlap, partial[rows, columns], roughness)
            deepest += 3.0 * float(roughness.max())
        shares = 1.0 / (1.0 + self._stiffness / stiffness)
        modes[:, rows, columns] = overlap * shares
        return deepest * float(shares.max())

    def _roughened(
        self,
        at: Floats,
        rows: np.ndarray,
        columns: np.ndarray,
        overlap: Floats,
        cut: Bools,
        roughness: Floats,
    ) -> Floats:
        """(10, n) modes of the overlap with the grain on it."""
        told = np.where(cut, overlap, np.concatenate([overlap[:3], np.zeros_like(overlap[3:])]))
        depth = told.T @ self._synthesis  # (n, s)
        places = np.empty((*depth.shape, 3))
        places[..., :2] = self._middle[rows, columns][:, None] + self._offset[rows, columns]
        places[..., 2] = -depth
        world = np.einsum("nij,nsj->nsi", at[:, :3, :3], places) + at[:, None, :3, 3]
        heights = self._surface.grain_at(world.reshape(-1, 3)).reshape(depth.shape) * roughness[:, None]
        touching = depth > 0.0
        added = np.where(touching, np.maximum(depth + heights, 0.0) - depth, 0.0)
        return np.asarray(overlap + self._analysis @ added.T)


def _placed(at: Floats, points: Floats) -> Floats:
    """(n, 3) points in the world, each at its own pose."""
    return np.asarray(np.einsum("nij,nj->ni", at[:, :3, :3], points) + at[:, :3, 3])

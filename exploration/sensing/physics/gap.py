"""From a surface to the skin's indentation: depth(x, y) = max(0, -z of the object's surface), over each cell.

Rays leave a bounded distance behind the skin along +z, so that a deep press is felt and what lies far behind
the pad is not.  Triangles are integrated exactly where it matters (`mesh_gap`); any other surface is supersampled.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from exploration.sensing.physics.mesh_gap import MeshGap
from exploration.sensing.physics.skin import MODES, Skin, legendre, skin_of, staggered_lattice
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, frozen
from primitives.surface import Surface, TriangleSurface

_LATTICE = staggered_lattice(12)  # rays in a cell of a surface without triangles


@dataclass(frozen=True)
class Indentation:
    """How deep an object indents each cell of the skin."""

    modes: Floats  # (..., 10, R, C) [mm] Legendre coefficients, in the order of `skin.MODES`
    partial: Bools  # (..., R, C) where the modes above the mean matter: partly out of contact, or not flat
    deepest: Floats  # (...) [mm] greatest depth that a ray met; 0 out of contact

    @property
    def depth(self) -> Floats:
        """(..., R, C) [mm] mean over each cell, margin included."""
        mean: Floats = self.modes[..., 0, :, :]
        return mean


class Gap(Protocol):
    """What feels a surface through one skin, pose after pose, in its own buffers."""

    modes: Floats  # (10, R, C) [mm] of the latest pose
    partial: Bools  # (R, C)

    def feel(self, poses: Floats) -> float:
        """Fill them at (1, 4, 4) poses, or (2 R + 1, 4, 4): corner row, cell row, corner row...; the depth."""
        ...


def gap(surface: Surface, spec: SensorSpec) -> Gap:
    """The way to feel this surface."""
    skin, start = skin_of(spec), spec.elastomer.thickness
    if isinstance(surface, TriangleSurface):
        return MeshGap(surface, skin, start)
    return SampledGap(surface, skin, start)


def indentation(surface: Surface, world_from_sensor: Floats, spec: SensorSpec) -> Indentation:
    """The skin's indentation at one (4, 4) pose or at (..., 4, 4)."""
    sensed = gap(surface, spec)
    shape = world_from_sensor.shape[:-2]
    cells = skin_of(spec).shape
    poses = np.ascontiguousarray(world_from_sensor, dtype=np.float64).reshape(-1, 1, 4, 4)
    modes = np.empty((len(poses), len(MODES), *cells))
    partial = np.empty((len(poses), *cells), dtype=bool)
    deepest = np.empty(len(poses))
    for i, one in enumerate(poses):
        deepest[i] = sensed.feel(one)
        modes[i], partial[i] = sensed.modes, sensed.partial
    return Indentation(
        frozen(modes.reshape(*shape, len(MODES), *cells)),
        frozen(partial.reshape(*shape, *cells), np.bool_),
        frozen(deepest.reshape(shape)),
    )


class SampledGap:
    """The indentation by a surface that only answers rays."""

    def __init__(self, surface: Surface, skin: Skin, start: float) -> None:
        self._surface, self._skin, self._start = surface, skin, start
        self.modes = np.zeros((len(MODES), *skin.shape))
        self.partial = np.ones(skin.shape, dtype=bool)
        u, v = _LATTICE
        x = (skin.x_edges[:-1] + skin.x_edges[1:])[:, None] / 2 + np.diff(skin.x_edges)[:, None] / 2 * u
        y = (skin.y_edges[:-1] + skin.y_edges[1:])[:, None] / 2 + np.diff(skin.y_edges)[:, None] / 2 * v
        self._local = np.stack(np.broadcast_arrays(x[None], y[:, None], -start), axis=-1)
        self._analysis = legendre(u, v) / len(u)

    def feel(self, poses: Floats) -> float:
        """See `Gap`."""
        at = poses[1::2] if len(poses) > 1 else np.broadcast_to(poses[0], (len(self._local), 4, 4))
        turned = np.einsum("rij,rcsj->rcsi", at[:, :3, :3], self._local)
        origins = (turned + at[:, None, None, :3, 3]).reshape(-1, 3)
        directions = np.broadcast_to(at[:, None, None, :3, 2], turned.shape).reshape(-1, 3)
        distance = self._surface.cast_rays(origins, directions).distance
        depth = np.maximum(0.0, self._start - distance).reshape(turned.shape[:3])
        self.modes[:] = np.einsum("ms,rcs->mrc", self._analysis, depth)
        return float(depth.max())

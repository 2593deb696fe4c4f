"""The symmetry of a body some of whose faces are freeform: no corner, edge or axis tells it, its surface does.

A body that a rotation leaves as it is keeps its center of mass and its inertia.  So an axis of symmetry is a
principal axis: where the moments about the other two differ, of two folds at most, and where they are equal, of
any number, with half turns about axes across it anywhere.  A rotation is one of the group if it carries points
all over the surface onto the surface, but for the play and for what facets are off the surface that they stand
for (our derivation).  Groups of more than one axis of three folds or more, whose moments are all equal, are not
looked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.optimize import minimize_scalar

from models.brep import Brep
from models.solid import Solid
from models.symmetry import SymmetryGroup, grouped, symmetry
from primitives.arrays import Floats
from primitives.pose import frame_along, rotation_exp

_IRRATIONAL = np.array([0.37, 1.0, 2.399, 4.1])  # [rad] turns that no small number of folds has


@dataclass(frozen=True)
class FreeformConfig:
    """What is asked, and how exactly."""

    play: float = 0.1  # [mm] by which points may be off, at most,
    share: float = 0.002  # and of the body's diagonal
    points: int = 3000
    first: int = 150  # that are asked before all of them are
    equal: float = 0.02  # of the moments, by which two that are one may differ
    folds: int = 12  # at most
    smooth: float = np.deg2rad(32.0)  # [rad] between facets of one surface
    coarse: float = 0.004  # of the body's diagonal, that facets may add to it
    across: int = 180  # directions of axes across, that are tried


def symmetry_of_solid(solid: Solid, brep: Brep, config: FreeformConfig = FreeformConfig()) -> SymmetryGroup:
    """The group of a solid in its own frame, by its boundary, and by its surface where faces are freeform."""
    told = symmetry(brep)
    if told.continuous or (solid.neighbors < 0).any() or all(face.kind != "freeform" for face in brep.faces):
        return told
    surface = _Surface(solid, config)
    if surface.facets > config.coarse * surface.diagonal:
        return told  # so coarse facets would hide what the symmetry lacks
    felt = surface.group()
    return felt if felt.order > told.order else told


class _Surface:
    """Points all over a surface, about the center of mass, and whether rotations carry them onto it."""

    def __init__(self, solid: Solid, config: FreeformConfig) -> None:
        mesh = trimesh.Trimesh(solid.vertices, solid.triangles, process=False)
        self.config, self.solid, self.center = config, solid, np.asarray(mesh.center_mass)
        drawn = trimesh.sample.sample_surface(mesh, config.points, seed=0)[0]
        self.points = np.asarray(drawn) - self.center
        self.diagonal = float(np.linalg.norm(solid.extent))
        self.facets = 2.0 * _sagitta(mesh, config.smooth)
        self.limit = min(config.play, config.share * self.diagonal) + self.facets
        self.moments, axes = np.linalg.eigh(np.asarray(mesh.moment_inertia))
        self.axes = axes.T

    def off(self, turn: Floats, count: int | None = None) -> float:
        """[mm] the most by which a (3, 3) rotation carries points away from the surface."""
        moved = self.points[:count] @ turn.T + self.center
        return float(np.abs(self.solid.signed_distance(moved)).max())

    def has(self, turn: Floats) -> bool:
        """Whether a (3, 3) rotation is of the group."""
        return self.off(turn, self.config.first) <= self.limit and self.off(turn) <= self.limit

    def group(self) -> SymmetryGroup:
        """Of the principal axes, the one with the most folds, and half turns across it."""
        alike = [self._alike(k) for k in range(3)]
        if all(alike) and all(self.has(rotation_exp(a * axis)) for a in _IRRATIONAL for axis in self.axes):
            return grouped(np.eye(3)[None], self.center, None, np.inf)
        for axis in self.axes[np.argsort([not a for a in alike])]:
            if all(self.has(rotation_exp(a * axis)) for a in _IRRATIONAL):
                flip = self._across(axis, 0.0)
                turns = [np.eye(3)] if flip is None else [np.eye(3), flip]
                return grouped(np.stack(turns), self.center, axis, np.inf)
        each = [
            self._folds(k, self.config.folds if same else 2) for k, same in zip(self.axes, alike, strict=True)
        ]
        axis, folds = self.axes[int(np.argmax(each))], max(each)
        turns = [rotation_exp(2 * np.pi * k / folds * axis) for k in range(folds)]
        flip = self._across(axis, np.pi / folds) if folds > 1 else None
        turns += [] if flip is None else [turn @ flip for turn in turns]
        return grouped(np.stack(turns), self.center, None, float(len(turns)))

    def _alike(self, k: int) -> bool:
        low, high = np.delete(self.moments, k)
        return bool(high - low < self.config.equal * high)

    def _folds(self, axis: Floats, most: int) -> int:
        return next((n for n in range(most, 1, -1) if self.has(rotation_exp(2 * np.pi / n * axis))), 1)

    def _across(self, axis: Floats, period: float) -> Floats | None:
        """A half turn about an axis across; these come again after a `period` [rad], 0 where any would do."""
        u, v = frame_along(axis)[:, :2].T

        def flip(angle: float) -> Floats:
            return rotation_exp(np.pi * (np.cos(angle) * u + np.sin(angle) * v))

        if period == 0.0:
            return flip(0.0) if self.has(flip(0.0)) else None
        tried = np.linspace(0.0, period, self.config.across, endpoint=False)
        off = [self.off(flip(angle), self.config.first) for angle in tried]
        best, step = float(tried[int(np.argmin(off))]), period / self.config.across
        near = minimize_scalar(
            lambda angle: self.off(flip(float(angle)), self.config.first),
            bounds=(best - step, best + step),
            method="bounded",
        )
        return flip(float(near.x)) if self.has(flip(float(near.x))) else None


def _sagitta(mesh: trimesh.Trimesh, smooth: float) -> float:
    """[mm] by which facets are off the surface that they stand for: a chord w of an arc a rises by w a / 8."""
    turn = np.asarray(mesh.face_adjacency_angles)
    bent = turn < smooth
    if not bent.any():
        return 0.0
    edges, pairs = np.asarray(mesh.face_adjacency_edges)[bent], np.asarray(mesh.face_adjacency)[bent]
    length = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    wide = np.asarray(mesh.area_faces)[pairs].sum(axis=1) / np.maximum(length, 1e-12)
    return float(np.quantile(wide * turn[bent] / 8.0, 0.98))

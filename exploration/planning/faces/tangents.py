"""What flats are tangents of: a ball, or a cone or cylinder.

Planes with normals n_i and offsets d_i are tangents of one ball about c where

    d_i = c . n_i + rho,

and rho is negative where they look at c.  They are those of a cone or cylinder about an axis a through c where

    n_i . a = s

as well, with s = 0 for the cylinder; all of it is linear.  Five flats of a ring and more, or eight of a ball, each
turned a little from the next, tell of one (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components

from exploration.planning.faces.spanned import fit_of
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along


@dataclass(frozen=True)
class TangentsConfig:
    """When flats are tangents of one round face."""

    turns: tuple[float, float] = (0.05, 0.45)  # [rad] from a facet to the next: of 14 sides and more
    least: int = 5  # facets of one ring,
    least_ball: int = 8  # and of a ball,
    bends: float = 0.03  # whose normals spread so much at least across the two ways that they spread most
    tried: int = 8  # flats round one, of which a few with it tell a face
    contacts: int = 6  # of a flat, that tell how it stands
    same: float = 0.012  # of the cosine with the axis, between facets of one ring
    near: float = 1.0  # [mm] from tangents of what a few of them tell,
    off: float = 0.1  # and from those of what all do,
    off_ball: float = 0.3  # or a ball's: its facets are not of one size
    radii: tuple[float, float] = (4.0, 250.0)  # [mm] of the face
    upright: float = 0.02  # cosine of its facets with its axis, up to which it is a cylinder
    steepest: float = 0.96  # the same, from which flats are no facets of a cone


@dataclass(frozen=True)
class Flats:
    """Flat faces by what they are tangents of."""

    faces: tuple[Face, ...]
    normals: Floats  # (n, 3) outward
    middles: Floats  # (n, 3) [mm] where each was felt

    def part(self, rows: Bools | list[int]) -> Flats:
        """Some of them."""
        numbers = np.arange(len(self.faces))[rows].tolist()
        return Flats(tuple(self.faces[k] for k in numbers), self.normals[rows], self.middles[rows])


@dataclass(frozen=True)
class Round:
    """What flats are tangents of."""

    center: Floats  # (3,) [mm] of the ball, or on the axis beside the flats
    rho: float  # [mm] of a tangent from there
    axis: Floats | None = None  # (3,) unit; None of a ball
    along: float = 0.0  # cosine of a facet's normal with the axis

    @staticmethod
    def ring(flats: Flats) -> Round:
        """Nearest to three flats and more."""
        normals, middle = flats.normals, flats.middles.mean(axis=0)
        offsets = (normals * (flats.middles - middle)).sum(axis=1)
        axis = np.linalg.svd(normals - normals.mean(axis=0))[2][2]
        across = frame_along(axis)[:, :2]
        rows = np.column_stack([normals @ across, np.ones(len(normals))])
        solved = np.linalg.lstsq(rows, offsets)[0]
        return Round(middle + across @ solved[:2], float(solved[2]), axis, float((normals @ axis).mean()))

    @staticmethod
    def ball(flats: Flats) -> Round:
        """Nearest to four flats and more."""
        normals, middle = flats.normals, flats.middles.mean(axis=0)
        offsets = (normals * (flats.middles - middle)).sum(axis=1)
        solved = np.linalg.lstsq(np.column_stack([normals, np.ones(len(normals))]), offsets)[0]
        return Round(middle + solved[:3], float(solved[3]))

    def holds(self, flats: Flats, off: float, same: float) -> Bools:
        """(n,) which flats are tangents of it."""
        away = ((flats.middles - self.center) * flats.normals).sum(axis=1) - self.rho
        near: Bools = np.abs(away) < off
        return near if self.axis is None else near & (np.abs(flats.normals @ self.axis - self.along) < same)

    def kind(self, normals: Floats, config: TangentsConfig) -> str | None:
        """Of the face of (n, 3) facets' normals; None where it is too flat, or too small, for one."""
        slope = float(np.sqrt(max(1.0 - self.along**2, 1e-9)))
        if abs(self.along) > config.steepest or not config.radii[0] < abs(self.rho) / slope < config.radii[1]:
            return None
        if self.axis is not None:
            return "cylinder" if abs(self.along) < config.upright else "cone"
        spread = np.linalg.svd(normals - normals.mean(axis=0), compute_uv=False)
        return "sphere" if spread[2] > config.bends * np.sqrt(len(normals)) else None  # else a ring's


def flats_of(faces: Sequence[Face], refused: set[int], config: TangentsConfig) -> Flats:
    """The flat faces that were felt well enough to tell how they stand, but those `refused`."""
    flat = tuple(
        face
        for face in faces
        if isinstance(face.fit, Fit)
        and face.fit.kind == "plane"
        and face.id not in refused
        and int((face.contacts.touch != NOT_FELT).sum()) >= config.contacts
    )
    fits = [fit_of(face) for face in flat]
    normals = np.array([own.shape.direction * (1.0 if own.convex else -1.0) for own in fits]).reshape(-1, 3)
    middles = np.array(
        [own.shape.project(f.contacts.points).mean(axis=0) for own, f in zip(fits, flat, strict=True)]
    )
    return Flats(flat, normals, middles.reshape(-1, 3))


def largest(flats: Flats, config: TangentsConfig) -> tuple[Flats, Round] | None:
    """What most flats are tangents of, and those; a ball is one where it has more of them than any ring."""
    turn = np.arccos(np.clip(flats.normals @ flats.normals.T, -1.0, 1.0))
    beside = (turn > config.turns[0]) & (turn < config.turns[1])
    best: tuple[Flats, Round] | None = None
    most = 0
    kinds = (Round.ring, 2, config.least, config.off), (Round.ball, 3, config.least_ball, config.off_ball)
    for of, few, least, off in kinds:
        for rows in _together(turn, few, config) if beside.any(axis=1).sum() >= least else ():
            held = of(flats.part(rows)).holds(flats, config.near, 2.0 * config.same)
            if held.sum() < max(least, most + 1):
                continue
            whole = of(flats.part(held))
            held = _hanging_together(held & whole.holds(flats, off, config.same), beside)
            if held.sum() >= max(least, most + 1) and whole.kind(flats.normals[held], config) is not None:
                best, most = (flats.part(held), whole), int(held.sum())
    return best


def _hanging_together(held: Bools, beside: Bools) -> Bools:
    """(n,) the most of some flats that come one after the other; (n, n) which are `beside` each other."""
    _, piece = connected_components(beside & held & held[:, None], directed=False)
    return np.asarray(held & (piece == np.argmax(np.bincount(piece, held))))


def _together(turn: Floats, few: int, config: TangentsConfig) -> Iterator[list[int]]:
    """A flat and so few of those round it; `turn` [rad] is from each to each."""
    for middle, away in enumerate(turn):
        order = np.argsort(away)
        near = order[(away[order] > config.turns[0]) & (away[order] < 2.0 * config.turns[1])]
        some = near[
            np.unique(np.linspace(0, max(len(near) - 1, 0), config.tried).astype(np.int64))[: len(near)]
        ]
        for others in combinations(some.tolist(), few):
            yield [middle, *others]


def step_of(normals: Floats, config: TangentsConfig) -> float:
    """[rad] from a facet to the next, for the most part."""
    turn = np.arccos(np.clip(normals @ normals.T, -1.0, 1.0))
    return float(np.median(np.where(turn > config.turns[0], turn, np.inf).min(axis=1)))

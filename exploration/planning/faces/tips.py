"""Round tips of turned parts: faces of few contacts, taken for pieces of spheres on the axis of a known face.

A dome over the end of a cone or a bar was touched once or twice, and bends little from one side to the other: a
cylinder that lies across the axis fits it as well as the sphere on that, and closes the body, too.  What is turned
has no such cylinder.  A sphere on a given axis has two parameters, where a cylinder has five: Schwarz's criterion
says what the contacts pay for, as for faces that stand upright (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit, squares
from primitives.patch_graph import Face, PatchGraph
from primitives.pose import rotate, transform_points, turn_about
from primitives.shapes import Cone, Cylinder

_PARAMETERS = 2  # of a sphere on a given axis
_RESIDUALS = 3  # of a point with its normal


@dataclass(frozen=True)
class TipsConfig:
    """Which faces may be tips, and when they are."""

    few: int = 30  # contacts, from which a face tells its own shape
    axis: int = 30  # contacts of the face whose axis it is
    leans: float = 0.7  # least cosine between the axis and the contacts' normals: a tip looks along it
    about: float = 1.0  # of how far the axis is from the middle of its contacts, that they reach round it
    bulge: float = 0.07  # [mm] rms from the sphere, at most
    slack: float = 3.0  # times chi2, by which contacts of one touch err together beyond their frames' noise
    turns: int = 6  # copies of the contacts round the axis, which put the sphere on it


def tipped(graph: PatchGraph, config: TipsConfig = TipsConfig()) -> PatchGraph:
    """The graph with spheres for its tips, where their contacts allow it."""
    axes = list(_axes(graph, config))
    return replace(graph, faces=tuple(_tip(face, axes, config) for face in graph.faces))


def _axes(graph: PatchGraph, config: TipsConfig) -> Iterator[tuple[int, Floats, Floats]]:
    """Number, place (3,) [mm] and direction (3,) of the cylinders and cones that tell theirs."""
    for face in graph.faces:
        shape = face.fit.shape if isinstance(face.fit, Fit) else None
        if isinstance(shape, Cylinder | Cone) and len(face.contacts) >= config.axis:
            yield face.id, shape.anchor, shape.direction


def _tip(face: Face, axes: list[tuple[int, Floats, Floats]], config: TipsConfig) -> Face:
    own = face.fit
    if not isinstance(own, Fit) or own.kind not in ("cylinder", "cone", "torus"):
        return face
    felt = face.weighed.select(own.inliers)
    few = 0 < len(felt) < config.few and not (felt.touch == NOT_FELT).any()
    if not few or not np.isfinite(felt.normals).all():
        return face
    best, most = face, 0.0
    for number, anchor, way in axes:
        if number == face.id or not _about(felt, anchor, way, config):
            continue
        made = fit("sphere", _turned(felt, anchor, way, config))
        if not isinstance(made, Fit) or made.convex != own.convex or made.rms > config.bulge:
            continue
        paid = np.log(_RESIDUALS * len(felt))
        own_chi2, chi2 = squares(own, felt).sum(), float(squares(made, felt).sum())
        gain = float(own_chi2 - chi2) / config.slack + (len(own.sigma) - _PARAMETERS) * paid
        if gain > most:
            dof = max(_RESIDUALS * len(felt) - _PARAMETERS, 1)
            fitted = replace(made, inliers=own.inliers, chi2=chi2, dof=dof)
            best, most = replace(face, fit=fitted, ranked=()), gain
    return best


def _about(felt: Contacts, anchor: Floats, way: Floats, config: TipsConfig) -> bool:
    """Whether contacts lie about an axis, not beside it, and look along it."""
    away = felt.points - anchor
    aside = away - np.outer(away @ way, way)
    middle = float(np.linalg.norm(aside.mean(axis=0)))
    reach = float(np.linalg.norm(aside - aside.mean(axis=0), axis=1).max())
    return middle < config.about * reach and bool((np.abs(felt.normals @ way) > config.leans).all())


def _turned(felt: Contacts, anchor: Floats, way: Floats, config: TipsConfig) -> Contacts:
    """The contacts and their copies turned about an axis: what fits them lies on it."""
    lots = []
    for angle in 2.0 * np.pi * np.arange(config.turns) / config.turns:
        turn = turn_about(anchor, way, angle)
        lots.append(
            replace(felt, points=transform_points(turn, felt.points), normals=rotate(turn, felt.normals))
        )
    return Contacts.concatenate(lots)

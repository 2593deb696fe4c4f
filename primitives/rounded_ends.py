"""Rounded ends of bars, from contacts that lie neither on the flat end nor on the wall.

As between two flat faces (`between_flats`) each contact tells the radius, with its depths behind the end and
behind the wall; the face is a ring about the bar's axis.  What its contacts were taken for, a cylinder across the
axis or a piece of a ball, is none.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Bools
from primitives.between_flats import BetweenFlatsConfig, is_broad, regrouped, told_radius
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, refit
from primitives.flat_edges import Flat, flats
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder, Torus


@dataclass(frozen=True)
class RoundedEndsConfig:
    """Which contacts are of a rounding."""

    flats: BetweenFlatsConfig = field(default_factory=lambda: BetweenFlatsConfig(few=10))
    sure: int = 20  # contacts of the end and of the wall, at least
    upright: float = 0.999  # least cosine between the axis and the end's normal
    wide: float = 0.8  # of the wall's radius, that a rounding has at most
    turns: float = 0.3  # [rad] over which contacts tell it, so that it is no cone
    known: float = 0.8  # share of them that are of one ring already
    round: int = 24  # places round the end, where inferred contacts are laid


def rounded_ends(graph: PatchGraph, config: RoundedEndsConfig = RoundedEndsConfig()) -> PatchGraph:
    """The graph with a ring for each rounded end of a bar, and without what its contacts were taken for."""
    for end in [flat for flat in flats(graph.faces) if len(flat.felt) >= config.sure and is_broad(flat)]:
        for number in [face.id for face in graph.faces]:
            bar = next((face for face in graph.faces if face.id == number), None)
            if bar is not None and _ends_at(bar, end, config):
                graph = _with_ring(graph, bar, end, config)
    return graph


def _ends_at(face: Face, end: Flat, config: RoundedEndsConfig) -> bool:
    """Whether a bar was felt up to near a flat face upright to it, and that within the bar."""
    shape = face.fit.shape if isinstance(face.fit, Fit) else None
    if not isinstance(shape, Cylinder) or not face.fit.convex or len(face.contacts) < config.sure:  # type: ignore[union-attr]
        return False
    deep = end.offset - face.contacts.points @ end.normal
    low, past = config.flats.deep[0], config.flats.past
    within = np.mean(shape.signed_distance(end.felt) > -low) < past
    upright = abs(float(shape.direction @ end.normal)) > config.upright
    return bool(upright and within and np.mean(deep < low) < past and deep.min() < config.flats.near)


def _with_ring(graph: PatchGraph, bar: Face, end: Flat, config: RoundedEndsConfig) -> PatchGraph:
    assert isinstance(bar.fit, Fit)
    assert isinstance(bar.fit.shape, Cylinder)
    wall, others = bar.fit.shape, [f for f in graph.faces if f.id != bar.id and len(f.contacts)]
    lots = [face.contacts for face in others]
    whose = np.repeat([face.id for face in others], [len(lot) for lot in lots])
    rest = Contacts.concatenate(lots)
    told = _told(rest, wall, end, config)
    if told is None:
        return graph
    radius, used = told
    ids, counts = np.unique(whose[used], return_counts=True)
    most = graph.face(int(ids[counts.argmax()]))
    if isinstance(most.fit, Fit) and most.fit.kind == "torus" and counts.max() > config.known * used.sum():
        return graph
    lot = rest.select(used)
    foot = wall.anchor + float(end.offset - wall.anchor @ end.normal) * end.normal
    ring = Torus(foot - radius * end.normal, end.normal, wall.radius - radius, radius)
    if config.flats.laid:
        lot = Contacts.concatenate([lot, _laid(ring, config)])
    made = refit(ring, True, lot)
    if not isinstance(made, Fit):
        return graph
    return regrouped(graph, [Face(-1, made, lot)], used, whose, config.flats)


def _told(rest: Contacts, wall: Cylinder, end: Flat, config: RoundedEndsConfig) -> tuple[float, Bools] | None:
    """Radius [mm] of the rounding, and which (n,) contacts are of it."""
    own, away = config.flats, rest.points - wall.anchor
    away = away - np.outer(away @ wall.direction, wall.direction)
    off = np.linalg.norm(away, axis=1)
    out = away / np.maximum(off, 1e-9)[:, None]
    deep = end.offset - rest.points @ end.normal, wall.radius - off
    normals = np.nan_to_num(rest.normals)
    beside = np.abs((normals * np.cross(end.normal, out)).sum(axis=1)) < own.along
    there = (rest.touch != NOT_FELT) & beside & (np.minimum(*deep) > own.deep[0])
    there &= np.maximum(*deep) < min(own.deep[1], config.wide * wall.radius)
    there &= (normals @ end.normal > own.between) & ((normals * out).sum(axis=1) > own.between)
    if there.sum() < own.few:
        return None
    told = told_radius(deep, (end.normal, out), there, rest, own)
    if told is None or told[2] < config.turns or told[0] > config.wide * wall.radius:
        return None
    return told[:2]


def _laid(ring: Torus, config: RoundedEndsConfig) -> Contacts:
    """Contacts that nobody felt, all round the end."""
    turns = 2.0 * np.pi * np.arange(config.round) / config.round
    ways = np.column_stack([np.cos(turns), np.sin(turns)]) @ ring.frame[:, :2].T
    lean = 0.5 * np.pi * np.array(config.flats.across)[:, None, None]
    normals = (np.cos(lean) * ring.axis + np.sin(lean) * ways).reshape(-1, 3)
    middles = np.tile(ring.center + ring.radius * ways, (len(lean), 1))
    points = middles + ring.minor_radius * normals
    return Contacts.of(points, normals, config.flats.sigma, config.flats.normal_sigma, touch=NOT_FELT)

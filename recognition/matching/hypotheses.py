"""Poses that pairs of contacts allow: an interpretation tree of depth two, then all contacts at once.

Contacts a and b can only lie on surface points i and j whose distance is theirs, and whose normals stand to each
other and to the line between as theirs do (Grimson and Lozano-Perez 1984).  Where both normals are felt such a
pair fixes the pose; without them the object may still turn about the line, and every turn is tried.  Each pose is
scored by some contacts on the object's coarse field; the best that differ descend on the fine one, and are scored
there by all.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from recognition.matching.contact_pairs import of_one_face, spread, telling_pairs
from recognition.matching.flats import Flat, laid_on
from recognition.matching.lone_face import LoneFace, lone_face
from recognition.matching.search_kernels import distinct, searched, settled, weighed
from recognition.matching.target import Target, field_error, gap


@dataclass(frozen=True)
class SearchConfig:
    """How far the search goes."""

    pairs: int = 4  # of contacts, with normals
    turned_pairs: int = 6  # of contacts without
    kept: int = 24  # poses of an object that descend, with normals
    kept_blind: int = 160  # without: distances alone rank poses badly
    turns: int = 30  # tried about a line
    starts: int = 400  # turns all round, where no normals were felt
    seed: int = 0  # of these turns
    most: int = 300  # pairs of samples tried for a pair of contacts without normals
    scored: int = 16  # contacts that score a pose first; more are thinned
    judged: int = 64  # contacts that score it at last
    rounds: int = 4  # of descent at each width
    angle: float = 0.20  # [rad] by which a normal beside a sample may differ, besides noise
    cap: float = 6.0  # cost beyond which a contact says no more than that it is off
    last_cap: float = 12.0  # the same of the last score
    apart: float = 0.25  # [rad] between poses that descend; and, times half the size, in mm
    differ: float = 0.06  # the same after the descent
    crowd: int = 3  # poses that are kept of each face that it may be


class Found(NamedTuple):
    """Poses of one object, best first after those that were given."""

    poses: Floats  # (k, 3, 4) object_from_world
    costs: Floats  # (k,) about -2 log likelihood of all contacts, but for a constant
    given: int = 0  # the first of them, whatever they cost


class Begun(NamedTuple):
    """The contacts as the search of every object reads them."""

    points: Floats  # (n, 3)
    normals: Floats  # (n, 3)
    felt: Bools  # (n,)
    few: tuple[Floats, Floats, Bools]  # the same of those that score first
    pairs: Ints  # (m, 2) rows of `few`
    sigma: float  # [mm]
    normal_sigma: float  # [rad]
    whole: int  # how many contacts there are
    told: bool  # whether sigma is theirs, or has to be estimated
    crowd: int  # poses that are kept of those that turn the face, or the first normal, the same way
    lone: LoneFace | None  # where nothing but one flat face was felt

    def distinct(self, poses: Floats, costs: Floats, most: int, differ: float, size: float) -> Found:
        """The best poses, each only once; `differ` [rad], and times half the size [mm], apart."""
        crowd = self.crowd if self.crowd < most else most
        facing = self.normals[0] if self.lone is None else self.lone.facing
        args = poses, costs, most, differ, 0.5 * differ * size, self.points[0], facing, crowd
        return Found(*distinct(*args))


def begin(contacts: Contacts, config: SearchConfig, sigma: float, told: bool = True) -> Begun:
    """What does not depend on the object."""
    felt = contacts.has_normal
    whole = np.ascontiguousarray(np.where(felt[:, None], contacts.normals, 0.0))
    order, chosen = spread(contacts, config.judged), spread(contacts, config.scored)
    points, normals, shown = np.ascontiguousarray(contacts.points[chosen]), whole[chosen], felt[chosen]
    many = config.pairs if shown.sum() >= 3 else config.turned_pairs
    pairs = telling_pairs(points, normals, shown, many)
    normal_sigma = float(np.median(contacts.normal_sigma[felt])) if felt.any() else 0.1
    judged = np.ascontiguousarray(contacts.points[order]), whole[order], felt[order]
    lone, few = lone_face(contacts.points, whole, felt, sigma if told else 0.0), (points, normals, shown)
    crowd = config.crowd if lone is not None or of_one_face(normals, shown) else config.kept_blind
    return Begun(*judged, few, pairs, sigma, normal_sigma, len(contacts), told, crowd, lone)


def search(begun: Begun, target: Target, config: SearchConfig, flats: tuple[Flat, ...] = ()) -> Found:
    """Poses of one object; `flats` are its flat faces, where nothing but one such face was felt."""
    near = gap(target)
    reach = 3.0 * begun.sigma + 0.8 * near
    wide = float(np.hypot(0.7 * near, begun.sigma))
    slope = float(np.hypot(config.angle, 2.0 * begun.normal_sigma))
    field = (target.values, target.origin, target.spacing, target.step)
    radius = 0.5 * target.size
    kept = config.kept if np.count_nonzero(begun.felt) >= 3 else config.kept_blind
    poses, _ = searched(
        *begun.few, begun.pairs, target.points, target.normals, target.pairs, target.angles, target.starts,
        target.bin, target.coarse, target.origin, target.spacing, target.unit, reach, slope, wide, config.cap,
        kept, config.turns, config.most, config.apart, radius, near, begun.crowd,
    )  # fmt: skip
    if begun.lone is not None:
        poses = np.concatenate([poses, laid_on(begun.points, begun.lone, flats)])
    if not len(poses) and kept == config.kept:
        return Found(poses, np.empty(0))
    settled(poses, *begun.few, wide, slope, config.cap, config.rounds, field)
    if kept == config.kept_blind:
        poses = np.concatenate([poses, _all_round(begun, target, config, wide, slope)])
    costs = scored(begun, target, poses, config)
    return begun.distinct(poses, costs, kept, config.differ, target.size)


def _all_round(begun: Begun, target: Target, config: SearchConfig, wide: float, slope: float) -> Floats:
    """(k, 3, 4) poses that even turns lead to, the contacts' middle on the object's: for want of normals."""
    if len(begun.points) < 4:
        return np.empty((0, 3, 4))
    turns = Rotation.random(config.starts, random_state=config.seed).as_matrix()
    shift = target.center - turns @ begun.points.mean(axis=0)
    poses = np.ascontiguousarray(np.concatenate([turns, shift[:, :, None]], axis=2))
    field = (target.values, target.origin, target.spacing, target.step)
    contacts = begun.points, begun.normals, begun.felt
    settled(poses, *contacts, max(4.0 * wide, 0.1 * target.size), slope, config.cap, config.rounds, field)
    settled(poses, *contacts, wide, slope, config.cap, config.rounds, field)
    return poses


def scored(begun: Begun, target: Target, poses: Floats, config: SearchConfig) -> Floats:
    """(k,) about -2 log likelihood of all contacts, but for a constant, at (k, 3, 4) poses."""
    fine = float(np.hypot(field_error(target) if begun.told else 0.5 * gap(target), begun.sigma))
    steep = float(np.hypot(0.05, begun.normal_sigma))
    field = (target.values, target.origin, target.spacing, target.step)
    costs = weighed(poses, begun.points, begun.normals, begun.felt, fine, steep, config.last_cap, field)
    return np.asarray(costs * begun.whole)

"""Scaling Series (Petrovskaya and Khatib 2011): particles cover what is likely, finer and finer, while it cools.

    d <- 2^(-1/6) d,  t = (d / d_last)^2                   half the volume a neighborhood each time
    cover the kept neighborhoods evenly, M particles each  (a particle in one covered before is dropped)
    weigh by exp(-u / t),  u = sum of 1/2 (distance^2 / s^2 + angle^2 / a^2)
    keep those within a share of the heaviest

Neighborhoods are balls of d [mm] for places and d over the object's radius [rad] for turns.  Distances come from
the object's distance field; the last particles are refined and ranked as those of the other rivals.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from recognizing.residual import by_residual
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from models.library import Entry
from primitives.arrays import Floats
from primitives.evidence import Contacts
from recognition.matching.search_kernels import weighed
from recognition.matching.target import Target, target_of

PARTICLES = 12000  # at first, and at most
EACH = 6  # M, of a neighborhood
ZOOM = 2.0 ** (-1.0 / 6.0)
FINEST = 1.0  # [mm]
KEPT = 0.6  # u above the heaviest, over the count of contacts, that is kept
FINAL = 8  # particles that are refined
CAP = 1e6  # of one contact's u: none


class ScalingSeries:
    """Nothing is trained."""

    def __init__(self, library: Mapping[str, Entry]) -> None:
        self._library = library

    def __call__(self, contacts: Contacts) -> tuple[str, Floats]:
        """The name with the least residual, and its pose."""
        best: tuple[float, str, Floats] = (np.inf, "", np.eye(4))
        for name, entry in self._library.items():
            starts = _series(contacts, target_of(entry), np.random.default_rng(0))
            residual, at = by_residual(entry, contacts, starts)
            best = min(best, (residual, name, at), key=lambda b: b[0])
        return best[1], best[2]


def _series(contacts: Contacts, target: Target, rng: np.random.Generator) -> Floats:
    """(k, 3, 4) likeliest particles."""
    radius, middle = 0.5 * target.size, contacts.points.mean(axis=0)
    width = radius
    turns = Rotation.random(PARTICLES, random_state=0)
    places = target.center + _ball(rng, PARTICLES) * width  # of the contacts' middle, in the object's frame
    field = (target.values, target.origin, target.spacing, target.step)
    felt = contacts.has_normal
    normals = np.ascontiguousarray(np.where(felt[:, None], contacts.normals, 0.0))
    sigma, angle = float(np.median(contacts.sigma)), float(np.median(contacts.normal_sigma))
    while True:
        poses = np.concatenate([turns.as_matrix(), np.zeros((len(places), 3, 1))], axis=2)
        poses[:, :, 3] = places - poses[:, :, :3] @ middle
        poses = np.ascontiguousarray(poses)
        warm = max(width / FINEST, 1.0)
        u = weighed(poses, contacts.points, normals, felt, sigma * warm, angle * warm, CAP, field)
        order = np.argsort(u)
        if width <= FINEST:
            return poses[order[:FINAL]]
        kept = order[u[order] <= u[order[0]] + KEPT][: PARTICLES // EACH]
        width *= ZOOM
        turns, places = _covered(turns[kept], places[kept], width, radius, rng)


def _covered(
    turns: Rotation, places: Floats, width: float, radius: float, rng: np.random.Generator
) -> tuple[Rotation, Floats]:
    """Particles in the neighborhoods of those kept, each place only in the first that holds it."""
    at = np.repeat(np.arange(len(places)), EACH)
    moved = places[at] + _ball(rng, len(at)) * width
    turned = Rotation.from_rotvec(_ball(rng, len(at)) * width / radius) * turns[at]
    of = np.hstack([radius * turns.as_matrix().reshape(-1, 9) / np.sqrt(2.0), places])
    mine = np.hstack([radius * turned.as_matrix().reshape(-1, 9) / np.sqrt(2.0), moved])
    nearest = cKDTree(of).query(mine)[1]
    fresh = nearest == at
    return (turned[fresh], moved[fresh]) if fresh.any() else (turned, moved)


def _ball(rng: np.random.Generator, count: int) -> Floats:
    """(n, 3) even in the unit ball."""
    way = rng.standard_normal((count, 3))
    length = rng.random((count, 1)) ** (1.0 / 3.0)
    return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True) * length)

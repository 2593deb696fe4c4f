"""One object's poses, refined on its exact surface and weighed: the modes of its posterior.

Each mode is taken as a normal density (Laplace)::

    p(z, M) = p(M) k  sum over modes  L (2 pi)^3 |H + P|^(-1/2) / (V_prior 8 pi^2)

with H the curvature of -log L, P what bounds a direction that nothing was felt in, and k how many poses of the
object's symmetry are this one, so that symmetric poses are one mode and none is lost (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from models.library import Entry
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import Contacts
from primitives.pose import inverse, pose
from primitives.shapes import Shape
from recognition.console.interrupts import checkpoint
from recognition.matching.align import Aligned, refine
from recognition.matching.belief import Hypothesis
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.facets import facets_of
from recognition.matching.let_in import SWEPT, let_in
from recognition.matching.likelihood import (
    NoiseConfig,
    log_astray,
    log_known,
    log_likelihoods,
)
from recognition.matching.lone_face import LoneFace, lone_face
from recognition.matching.one_face import Room, divided, rooms_of
from recognition.matching.one_side import log_one_side
from recognition.matching.places import Places, places_of
from recognition.matching.readings import read_both, readings, weighed
from recognition.matching.room import Lone, log_room
from recognition.matching.round_room import rooms_round
from recognition.matching.span import log_copies, same, spread_of
from recognition.matching.target import Target, field_error, gap, target_of

_ROTATIONS = np.log(8 * np.pi**2)
_ON = 6.0  # half the squared sigmas that a contact is off a surface which it is as likely to lie on as not
_EXACT = 0.005, 0.002  # [mm], [rad]: no contact is surer, for no mesh is


@dataclass(frozen=True)
class Mode:
    """One pose of one object, and how probable the evidence is near it."""

    hypothesis: Hypothesis
    log_known: float
    log_unknown: float  # of an object that is like this one, and is not
    log_share: float = 0.0  # logarithm of its share in the room of all modes on the same flat face


class _Found(NamedTuple):
    """A pose that is no other's, before it is known how much of the room is its own."""

    row: int  # of the poses
    made: Hypothesis
    bound: float  # logarithm of what empty space leaves of it
    log_volume: float


@dataclass(frozen=True)
class Felt:
    """The contacts as the kernels read them."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3), 0 where none was felt
    felt: Bools  # (n,)
    sigma: Floats  # (n,) [mm]
    tau: Floats  # (n,) [rad]
    shares: Floats  # (n,) what each counts for
    places: Places
    lone: LoneFace | None  # where nothing but one flat face was felt
    round_one: Shape | None  # or one round one

    @staticmethod
    def of(evidence: Evidence) -> Felt:
        """Of all evidence."""
        c = evidence.contacts
        felt = c.has_normal
        normals = np.ascontiguousarray(np.where(felt[:, None], c.normals, 0.0))
        sigma, tau = _at_best(c)
        lone = lone_face(c.points, normals, felt, float(np.median(sigma)) if evidence.scale_known else 0.0)
        round_one = None if lone is not None else evidence.round_face
        places = places_of(c.points, lone is None and round_one is None)
        return Felt(
            np.ascontiguousarray(c.points),
            normals,
            felt,
            sigma,
            tau,
            evidence.shares,
            places,
            lone,
            round_one,
        )

    def erring(self, contacts: Contacts) -> Felt:
        """The same, with the sigmas that these very contacts have now."""
        sigma, tau = _at_best(contacts)
        return replace(self, sigma=sigma, tau=tau)


def _at_best(c: Contacts) -> tuple[Floats, Floats]:
    return np.maximum(c.sigma, _EXACT[0]), np.maximum(c.normal_sigma, _EXACT[1])


def modes_of(entry: Entry, poses: Floats, seen: Felt, evidence: Evidence, prior: Prior, noise: NoiseConfig,
             polished: int) -> list[Mode]:  # fmt: skip
    """The modes that (k, 3, 4) poses lead to, each symmetric pose once, likeliest first."""
    done = _refined(entry, target_of(entry), poses, seen, not evidence.scale_known, polished)
    return modes_at(entry, done, seen, evidence, prior, noise)


def modes_at(entry: Entry, done: Aligned, seen: Felt, evidence: Evidence, prior: Prior, noise: NoiseConfig,
             more: Floats | None = None, log_share: float = 0.0) -> list[Mode]:  # fmt: skip
    """The modes of poses as they are; `more` (6, 6) is what else is known of them, besides by contacts.

    `log_share` is theirs of the room on one face, where other modes have the rest.
    """
    target, absolute = target_of(entry), not evidence.scale_known
    scale, turn = _scales(done, seen, evidence, target, noise)
    if scale != 1.0 or turn != 1.0:
        noise_so = seen.sigma * scale, seen.tau * turn, seen.shares
        contacts = seen.points, seen.normals, seen.felt, *noise_so
        again = refine(done.poses, *contacts, facets_of(entry.solid.body), 1.0, 0, absolute=absolute)
        done = done._replace(information=again.information)
    there, behind = _places(entry, done, seen, scale), _behind(entry, target, done.poses, seen, scale)
    both = read_both(
        [
            weighed(done.distances, angles, seen.felt, seen.sigma * scale, seen.tau * turn, seen.shares,
                    behind, target.size, noise, absolute)
            for angles in readings(done, entry.solid.body)
        ]
    )  # fmt: skip
    like, total, unlike = both.each, there + both.known, there + both.unlike
    middle = _in_the_middle(seen, scale, turn)
    found: list[_Found] = []
    for k in np.argsort(-total, kind="stable"):
        checkpoint()
        world = inverse(pose(done.poses[k][:, :3], done.poses[k][:, 3]))
        if float(np.linalg.norm(world[:3, :3] @ target.center + world[:3, 3] - prior.center)) > prior.radius:
            continue
        covariance, log_volume = spread_of(done.information[k], done.poses[k], seen.points, entry, target)
        if more is not None:
            covariance, _ = spread_of(done.information[k] + more, done.poses[k], seen.points, entry, target)
        if same(entry, [f.made for f in found], world, target).any():
            continue
        log_volume += log_room(done.poses[k], covariance, middle, target) + log_copies(
            entry, covariance, target
        )
        made = Hypothesis(entry.name, frozen(world), 0.0, frozen(covariance), float("nan"), frozen(like[k]))
        found.append(_Found(int(k), *let_in(made, entry, target, evidence), log_volume))
    rooms = _rooms(entry, found, done, seen, middle)
    volumes, shares = divided([f.log_volume for f in found], rooms, log_share)
    modes: list[Mode] = []
    for f, log_volume, share in zip(found, volumes, shares, strict=True):
        at = log_volume - np.log(prior.volume) - _ROTATIONS
        other = log_astray(-f.bound / -SWEPT, float(seen.shares.sum()), f.bound)
        known_so, unlike_so = float(total[f.row] + at + f.bound), float(unlike[f.row] + at + other)
        modes.append(Mode(f.made, known_so, unlike_so, share))
    return modes


def _places(entry: Entry, done: Aligned, seen: Felt, scale: float) -> Floats:
    """(k,) logarithms of p(places | object, pose): anywhere, near each other, or all on one side."""
    anyhow = np.full(len(done.poses), seen.places.log_density(target_of(entry).area, seen.shares))
    if not (seen.felt.all() and seen.places.anywhere):
        return anyhow
    on = expit(_ON - 0.5 * (done.distances / (scale * seen.sigma)) ** 2)
    side = log_one_side(entry, done.poses[:, :, :3], seen.normals, on, seen.shares)
    return np.asarray(np.logaddexp(anyhow, side) - np.log(2.0))


def _rooms(entry: Entry, found: list[_Found], done: Aligned, seen: Felt, middle: Lone) -> list[Room | None]:
    """The room that modes share, where nothing but one face was felt."""
    target, rows = target_of(entry), [f.row for f in found]
    poses, known = done.poses[rows], done.information[rows]
    if seen.lone is not None:
        return rooms_of(seen.lone, entry, target, poses, known)
    if seen.round_one is None:
        return [None] * len(found)
    made = [f.made for f in found]
    return rooms_round(seen.round_one, made, entry, target, poses, known, seen.points, middle)


def residual(entry: Entry, world: Floats, points: Floats) -> float:
    """[mm] mean distance of (n, 3) contacts from the surface of an object at a pose."""
    return float(np.abs(entry.solid.signed_distance((points - world[:3, 3]) @ world[:3, :3])).mean())


def _refined(
    entry: Entry, target: Target, poses: Floats, seen: Felt, absolute: bool, polished: int
) -> Aligned:
    mesh = facets_of(entry.solid.body)
    wider = max(1.0, 0.35 * gap(target) / float(np.median(seen.sigma)))
    contacts = seen.points, seen.normals, seen.felt, seen.sigma, seen.tau, seen.shares
    done = refine(np.ascontiguousarray(poses), *contacts, mesh, wider, absolute=absolute)
    if not absolute:
        return done
    best = np.argsort(np.minimum(done.distances, 5 * seen.sigma).mean(axis=1), kind="stable")[:polished]
    return refine(np.ascontiguousarray(done.poses[best]), *contacts, mesh, 1.0, 30, absolute=True)


def _behind(entry: Entry, target: Target, poses: Floats, seen: Felt, scale: float) -> Bools:
    """(k, n) whether a contact lies within the object by more than noise and the field's error."""
    points = np.einsum("kij,nj->kni", poses[:, :, :3], seen.points) + poses[:, None, :, 3]
    distance = entry.field.signed_distance(points.reshape(-1, 3)).reshape(len(poses), -1)
    return np.asarray(distance < -(3.0 * scale * seen.sigma + field_error(target)))


def _in_the_middle(seen: Felt, scale: float, turn: float) -> Lone:
    """The contact whose face tells how far a loose pose may go."""
    row = int(np.argmin(np.linalg.norm(seen.points - np.median(seen.points, axis=0), axis=1)))
    told = bool(seen.felt[row])
    return Lone(seen.points[row], seen.normals[row], told, scale * seen.sigma[row], turn * seen.tau[row])


def _scales(
    done: Aligned, seen: Felt, evidence: Evidence, target: Target, noise: NoiseConfig
) -> tuple[float, float]:
    """Factors on sigma and tau that suit the likeliest pose, where nobody told the noise."""
    grid = np.geomspace(1 / noise.loosest, noise.loosest, 13)
    best = (-np.inf, 1.0, 1.0)
    for s in grid if not evidence.scale_known else (1.0,):
        for t in grid if not evidence.normal_scale_known and seen.felt.any() else (1.0,):
            both = log_likelihoods(done.distances, done.angles, seen.felt, seen.sigma * s, seen.tau * t,
                                   target.size, noise, not evidence.scale_known)  # fmt: skip
            best = max(best, (float(log_known(*both, seen.shares, noise).max()), float(s), float(t)))
    return best[1], best[2]

"""Evidence and a library -> `Belief`: search, refine, weigh.

The weight of an object is its prior times the integral over poses of likelihood times prior; each mode of it is
taken as a normal density (Laplace)::

    p(z, M) = p(M) k  sum over modes  L (2 pi)^3 |H + P|^(-1/2) / (V_prior 8 pi^2)

with H the curvature of -log L, P what bounds a direction that nothing was felt in, and k how many poses of the
object's symmetry are this one, so that symmetric poses are one mode and none is lost (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import logsumexp

from models.library import Entry
from models.symmetry import nearest_pose
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError
from primitives.pose import hat, inverse, pose
from recognition.matching.align import refine
from recognition.matching.belief import UNKNOWN, Belief, Hypothesis
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.facets import facets_of
from recognition.matching.hypotheses import SearchConfig, search, spread
from recognition.matching.likelihood import NoiseConfig, log_likelihoods
from recognition.matching.target import Target, target_of

_ROTATIONS = np.log(8 * np.pi**2)
_FREE_TURN = 1.71  # [rad] sigma of a direction of turning that nothing bounds: its cube gives all of SO(3)


@dataclass(frozen=True)
class MatchConfig:
    """What is searched, weighed and kept."""

    search: SearchConfig = field(default_factory=SearchConfig)
    noise: NoiseConfig = field(default_factory=NoiseConfig)
    refined: int = 8  # poses of an object that are refined on its exact surface
    refined_blind: int = 96  # the same where no normals were felt
    polished: int = 24  # of these, refined again to the least mean distance
    most: int = 400  # contacts that are weighed; more are thinned evenly
    told: int = 64  # hypotheses in the belief


@dataclass(frozen=True)
class _Mode:
    hypothesis: Hypothesis
    log_known: float
    log_unknown: float


def match(evidence: Evidence, library: Mapping[str, Entry], prior: Prior | None = None, unknown: float = 0.1,
          starts: Iterable[tuple[str, Floats]] = (), config: MatchConfig | None = None) -> Belief:  # fmt: skip
    """What the evidence says of which object it is, and where; `starts` are poses to try as well."""
    config = config or MatchConfig()
    if len(library) == 0:
        raise PalpateError(
            "the library holds no object; add CAD files to its folder (palpate library build DIR)"
        )
    if not 0.0 <= unknown < 1.0:
        raise PalpateError(f"the prior of an unknown object must be from 0 to 1, not {unknown}")
    evidence = evidence.checked()
    if len(evidence.contacts) > config.most:
        rows = spread(evidence.contacts, config.most)
        evidence = replace(evidence, contacts=evidence.contacts.select(rows))
    prior = prior or Prior.around(evidence.contacts)
    known = {name: [p for n, p in starts if n == name] for name in library}
    modes = [m for name in library for m in _modes(library[name], evidence, prior, known[name], config)]
    each = np.log((1.0 - unknown) / len(library))
    log_names = dict.fromkeys(library, -np.inf)
    for m in modes:
        name = m.hypothesis.name
        log_names[name] = float(np.logaddexp(log_names[name], each + m.log_known))
    if unknown > 0:
        like = [np.log(unknown / 2 / len(library)) + m.log_unknown for m in modes]
        log_names[UNKNOWN] = float(logsumexp([*like, np.log(unknown / 2) + _scattered(evidence, prior)]))
    total = float(logsumexp(list(log_names.values())))
    if not np.isfinite(total):
        raise PalpateError(_nowhere(evidence, prior))
    told = sorted(modes, key=lambda m: -m.log_known)[: config.told]
    weighed = tuple(_weighed(m.hypothesis, each + m.log_known - total) for m in told)
    return Belief(weighed, {name: float(np.exp(x - total)) for name, x in log_names.items()})


def _weighed(h: Hypothesis, log_weight: float) -> Hypothesis:
    return Hypothesis(h.name, h.pose, float(log_weight), h.covariance, h.residual, h.log_likelihoods)


def _modes(entry: Entry, evidence: Evidence, prior: Prior, starts: Sequence[Floats],
           config: MatchConfig) -> list[_Mode]:  # fmt: skip
    """The modes of one object's posterior, each symmetric pose once."""
    contacts = evidence.contacts
    target = target_of(entry)
    felt = contacts.has_normal
    points = np.ascontiguousarray(contacts.points)
    normals = np.ascontiguousarray(np.where(felt[:, None], contacts.normals, 0.0))
    sigma, tau = np.array(contacts.sigma), np.maximum(contacts.normal_sigma, 1e-4)
    mesh, absolute = facets_of(entry.solid.body), not evidence.scale_known
    found, _ = search(contacts, target, config.search, float(np.median(sigma)))
    refined = config.refined if felt.sum() >= 3 else config.refined_blind
    poses = np.concatenate([found[:refined], *(inverse(p)[None, :3] for p in starts)])
    if len(poses) == 0:
        poses = _laid(points[0], normals[0] if felt[0] else None, target)
    wider = max(1.0, 0.35 * np.sqrt(target.area / len(target.points)) / float(np.median(sigma)))
    done = refine(
        np.ascontiguousarray(poses), points, normals, felt, sigma, tau, mesh, wider, absolute=absolute
    )
    if absolute:
        best = np.argsort(np.minimum(done.distances, 5 * sigma).mean(axis=1), kind="stable")[
            : config.polished
        ]
        near = np.ascontiguousarray(done.poses[best])
        done = refine(near, points, normals, felt, sigma, tau, mesh, 1.0, 30, absolute=True)
    volume = 4.0 / 3.0 * np.pi * (0.5 * target.size) ** 3
    scale, turn = _scales(
        done.distances, done.angles, felt, sigma, tau, evidence, target, volume, config.noise
    )
    like, off = log_likelihoods(done.distances, done.angles, felt, sigma * scale, tau * turn, target.area,
                                target.size, volume, config.noise, absolute)  # fmt: skip
    copies = np.log(max(entry.symmetry.order, 1.0)) if np.isfinite(entry.symmetry.order) else 0.0
    if entry.symmetry.name == "D_inf":
        copies = np.log(2.0)
    modes: list[_Mode] = []
    for k in np.argsort(-like.sum(axis=1), kind="stable"):
        world = inverse(pose(done.poses[k][:, :3], done.poses[k][:, 3]))
        if float(np.linalg.norm(world[:3, :3] @ target.center + world[:3, 3] - prior.center)) > prior.radius:
            continue
        covariance, log_volume = _spread_of(
            done.information[k] / max(scale**2, 1e-12), done.poses[k], points, target
        )
        if any(_same(entry, m.hypothesis, world, target, covariance) for m in modes):
            continue
        at = log_volume + copies - np.log(prior.volume) - _ROTATIONS
        away = np.abs(entry.solid.signed_distance(points @ world[:3, :3] - world[:3, 3] @ world[:3, :3]))
        made = Hypothesis(
            entry.name, frozen(world), 0.0, frozen(covariance), float(away.mean()), frozen(like[k])
        )
        bound = _free(evidence, target, world, float(np.median(sigma)))
        modes.append(_Mode(made, float(like[k].sum() + at + bound), float(off[k].sum() + at)))
    return modes


def _scales(distances: Floats, angles: Floats, felt: Bools, sigma: Floats, tau: Floats, evidence: Evidence,
            target: Target, volume: float, noise: NoiseConfig) -> tuple[float, float]:  # fmt: skip
    """Factors on sigma and tau that suit the likeliest pose, where nobody told the noise."""
    grid = np.geomspace(1 / noise.loosest, noise.loosest, 13)
    best = (-np.inf, 1.0, 1.0)
    for s in grid if not evidence.scale_known else (1.0,):
        for t in grid if not evidence.normal_scale_known and felt.any() else (1.0,):
            like, _ = log_likelihoods(distances, angles, felt, sigma * s, tau * t, target.area, target.size,
                                      volume, noise, not evidence.scale_known)  # fmt: skip
            best = max(best, (float(like.sum(axis=1).max()), float(s), float(t)))
    return best[1], best[2]


def _spread_of(information: Floats, found: Floats, points: Floats, target: Target) -> tuple[Floats, float]:
    """Covariance about the object's center, and the logarithm of the volume of pose space that it stands for."""
    middle = found[:, :3] @ points.mean(axis=0) + found[:, 3]
    shift = np.eye(6)
    shift[:3, 3:] = hat(middle - target.center).T
    about = shift.T @ information @ shift
    bound = np.diag([(3.0 / target.size) ** 2] * 3 + [1 / _FREE_TURN**2] * 3)
    whole = about + bound
    return np.asarray(np.linalg.inv(whole)), float(3 * np.log(2 * np.pi) - 0.5 * np.linalg.slogdet(whole)[1])


def _same(entry: Entry, h: Hypothesis, world: Floats, target: Target, covariance: Floats) -> bool:
    """Whether a pose is one that is there already, up to symmetry and to what the covariance spans."""
    near = nearest_pose(entry.symmetry, world, h.pose)
    turn = h.pose[:3, :3].T @ near[:3, :3]
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    shift = (near - h.pose)[:3, :3] @ target.center + (near - h.pose)[:3, 3]
    far = np.sqrt(max(np.trace(h.covariance[:3, :3]), 1e-6))
    wide = np.sqrt(max(np.trace(h.covariance[3:, 3:]), 1e-8))
    return bool(angle <= max(2 * wide, 0.01) and np.linalg.norm(shift) <= max(2 * far, 0.005 * target.size))


def _laid(point: Floats, normal: Floats | None, target: Target) -> Floats:
    """(k, 3, 4) poses that lay samples on a single contact."""
    from primitives.pose import frame_along

    poses = []
    for p, n in zip(target.points[:16], target.normals[:16], strict=True):
        turn = frame_along(n) @ frame_along(n if normal is None else normal).T
        poses.append(np.column_stack([turn, p - turn @ point]))
    return np.stack(poses)


def _free(evidence: Evidence, target: Target, world: Floats, sigma: float) -> float:
    """Logarithm of how well the object keeps out of the space that was swept: one outlier a box it enters."""
    if evidence.free is None or len(evidence.free.poses) == 0:
        return 0.0
    inside = evidence.free.contains(target.points @ world[:3, :3].T + world[:3, 3], margin=3 * sigma + 1.0)
    return float(-4.6 * min(int(inside.sum()), 10))


def _scattered(evidence: Evidence, prior: Prior) -> float:
    """Logarithm of p(contacts) if they were scattered round a point of the prior, width unknown."""
    points = evidence.contacts.points
    n = len(points)
    square = float(((points - points.mean(axis=0)) ** 2).sum())
    widths = np.geomspace(5.0, 200.0, 8)
    each = -0.5 * square / widths**2 - 1.5 * (n - 1) * np.log(2 * np.pi * widths**2) - 1.5 * np.log(n)
    return float(logsumexp(each) - np.log(len(widths)) - np.log(prior.volume)
                 - np.log(4 * np.pi) * int(evidence.contacts.has_normal.sum()))  # fmt: skip


def _nowhere(evidence: Evidence, prior: Prior) -> str:
    away = float(np.linalg.norm(evidence.contacts.points - prior.center, axis=1).min())
    return (f"no pose within {prior.radius:g} mm of the prior's center meets the contacts, the nearest "
            f"{away:.0f} mm away; move --prior-center or widen --prior-radius")  # fmt: skip

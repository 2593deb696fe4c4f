"""The likeliest poses, refined by what the whole skin felt: a contact slides along its face, an edge does not.

An imprint moves with the pad by the six images B of `imprints.foreseen`.  With r what is left of it, both over the
sigma of a taxel, and t taxels that the rubber spreads into one another, the pad's move d is known by::

    G = B B' / t,   g = B r / t,   less what the touch's own error N(0, S) blurs:   (G - G K G),  (g - G K g)
    K = (G + S^-1)^-1

and the object's pose by all of them and by its contacts, whose curvature stands for them (Gauss-Newton).  How
likely a mode is stays what contacts say: what imprints cost it is weighed later (our derivation).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from models.library import Entry
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Imprint
from primitives.pose import hat, inverse, log, pose
from recognition.console.interrupts import checkpoint
from recognition.matching.align import Aligned, refine
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.facets import facets_of
from recognition.matching.imprints import ImprintConfig, fitted, foreseen
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.loose import LooseConfig, sigma_points
from recognition.matching.modes import Felt, Mode, modes_at
from recognition.matching.span import same
from recognition.matching.steps import turn
from recognition.matching.target import target_of


@dataclass(frozen=True)
class SharpenConfig:
    """Which modes are looked at, and how exact the pad's own pose is."""

    behind: float = 8.0  # of log likelihood, by which a mode may be behind the best
    most: int = 6  # modes
    rounds: int = 6
    enough: float = 1e-3  # [mm] of a step, and as many parts of the object's size
    aside: float = 0.12  # [mm] of a touch's place along the skin, 1 sigma, with what an object may differ
    spin: float = 0.02  # [rad]
    bare: tuple[float, float] = (0.15, 0.03)  # [mm], [rad] of its depth and tilt
    told: tuple[float, float] = (1.0, 0.2)  # the same where contacts with normals tell these already
    longest: float = 1.0  # [mm] of a step
    bound: float = 20.0  # of half the squared sigmas that one imprint is off: it counts no more
    fits: float = 4.0  # of these, beyond which it says that the pose is another one, and not which
    loose: float = 2.0  # [mm] error of its place, from which it is asked whether imprints fit elsewhere,
    loose_turn: float = 0.15  # [rad] likewise
    worse: float = 2.0  # of half the squared sigmas, that they are off more where they do not
    beside: LooseConfig = LooseConfig(moved=0.01, sigmas=(0.6, 1.2))  # noqa: RUF009
    skin: ImprintConfig = ImprintConfig()  # noqa: RUF009


class _Fit(NamedTuple):
    """Of all imprints at one pose."""

    off: float  # half the squared sigmas
    worst: float  # of one of them
    information: Floats  # (6, 6) of (v, w) about the contacts' middle, in the object's frame
    pull: Floats  # (6,)


def sharpened(modes: Sequence[Mode], library: Mapping[str, Entry], seen: Felt, evidence: Evidence, prior: Prior,
              noise: NoiseConfig, config: SharpenConfig = SharpenConfig()) -> list[Mode]:  # fmt: skip
    """The modes, the likeliest of them where imprints and contacts together put them."""
    if not evidence.imprints or not evidence.scale_known or not modes:
        return list(modes)
    ranked = sorted(modes, key=lambda m: -m.log_known)
    kept: list[Mode] = []
    for k, mode in enumerate(ranked):
        entry = library[mode.hypothesis.name]
        if k < config.most and mode.log_known > ranked[0].log_known - config.behind:
            better = _sharper(mode, entry, seen, evidence, prior, noise, config)
            if not among(kept, better, entry):
                kept.append(better)
        elif not among(kept, mode, entry):
            kept.append(mode)
    return kept


def known_by(
    imprint: Imprint, solid: Solid, center: Floats, config: SharpenConfig = SharpenConfig()
) -> Floats:
    """(6, 6) what an imprint would tell of a posed solid's (v, w) about a (3,) `center`, in the solid's frame.

    Only where the imprint lies counts, and what the sensor is like: it is felt as the solid would dent it.
    """
    foretold = foreseen(imprint, solid, config.skin)
    felt = replace(imprint, depth=foretold[0])
    own = np.array([config.aside, config.aside, *config.told, config.told[1], config.spin])
    known = fitted(felt, foretold, own, config.skin).information
    move = _moving(inverse(solid.pose) @ imprint.pose, center)
    return np.asarray(move.T @ known @ move)


def among(kept: Sequence[Mode], mode: Mode, entry: Entry) -> bool:
    """Whether a mode is one that is there already."""
    target = target_of(entry)
    own = [m.hypothesis for m in kept if m.hypothesis.name == entry.name]
    return bool(same(entry, own, mode.hypothesis.pose, target).any())


def _sharper(mode: Mode, entry: Entry, seen: Felt, evidence: Evidence, prior: Prior, noise: NoiseConfig,
             config: SharpenConfig) -> Mode:  # fmt: skip
    at = np.ascontiguousarray(inverse(mode.hypothesis.pose)[:3])
    middle, size = seen.points.mean(axis=0), target_of(entry).size
    contacts = _there(at, entry, seen).information[0]
    bound = np.diag([(3.0 / size) ** 2] * 3 + [1.0] * 3)
    moved = np.zeros(6)
    fit = _fit(at, entry, seen, evidence, config)
    least = fit.off
    share = 1.0
    for _ in range(config.rounds):
        step = np.linalg.solve(contacts + bound + fit.information, fit.pull - contacts @ moved)
        longest = float(np.abs(step * [1, 1, 1, size, size, size]).max())
        step *= min(share, config.longest / max(longest, 1e-12))
        tried = at.copy()
        turn(tried, step, at[:, :3] @ middle + at[:, 3])
        after = _fit(tried, entry, seen, evidence, config)
        total = after.off + 0.5 * float((moved + step) @ contacts @ (moved + step))
        if total >= least:
            share *= 0.4
            continue
        at, moved, fit, least, share = tried, moved + step, after, total, 1.0
        if longest < config.enough:
            break
    if fit.worst > config.fits:
        return mode
    done = _there(at, entry, seen)
    told = _told_everywhere(mode, at, fit, entry, seen, evidence, config)
    found = modes_at(entry, done, seen, evidence, prior, noise, told, mode.log_share)
    return found[0] if found else mode


def _told_everywhere(mode: Mode, at: Floats, fit: _Fit, entry: Entry, seen: Felt, evidence: Evidence,
                     config: SharpenConfig) -> Floats:  # fmt: skip
    """(6, 6) what imprints tell of a mode, less of ways on which it is loose and they fit beside it as well.

    Beside a hole that nobody felt they tell how near to it the skin was not, and nothing of where it is.
    """
    h, known = mode.hypothesis, fit.information
    if h.rotation_sigma < config.loose_turn and h.translation_sigma < config.loose:
        return known
    beside = sigma_points(h.pose, h.covariance, entry, config.beside)[1:]
    center, each = at[:, :3] @ seen.points.mean(axis=0) + at[:, 3], 2 * len(config.beside.sigmas)
    for poses in (beside[k : k + each] for k in range(0, len(beside), each)):
        fits = (_fit(np.ascontiguousarray(inverse(p)[:3]), entry, seen, evidence, config).off for p in poses)
        if any(off < fit.off + config.worse for off in fits):
            v, w = np.split(log(inverse(h.pose) @ poses[0]), 2)
            way = np.concatenate([v + np.cross(w, center), w])
            held = known @ way
            known = known - np.outer(held, held) / max(float(way @ held), 1e-12)
    return known


def _there(at: Floats, entry: Entry, seen: Felt) -> Aligned:
    """Distances, angles and curvature at one pose."""
    contacts = seen.points, seen.normals, seen.felt, seen.sigma, seen.tau, seen.shares
    return refine(np.ascontiguousarray(at[None]), *contacts, facets_of(entry.solid.body), 1.0, rounds=0)


def _fit(at: Floats, entry: Entry, seen: Felt, evidence: Evidence, config: SharpenConfig) -> _Fit:
    """All imprints at a (3, 4) pose object_from_world."""
    whole = pose(at[:, :3], at[:, 3])
    solid = entry.solid.placed(inverse(whole))
    center = at[:, :3] @ seen.points.mean(axis=0) + at[:, 3]
    told = set(evidence.contacts.touch[evidence.contacts.has_normal].tolist())
    off, worst, information, pull = 0.0, 0.0, np.zeros((6, 6)), np.zeros(6)
    for imprint in evidence.imprints:
        checkpoint()
        depth, tilt = config.told if imprint.touch in told else config.bare
        own = np.array([config.aside, config.aside, depth, tilt, tilt, config.spin])
        lost, known, g = fitted(imprint, foreseen(imprint, solid, config.skin), own, config.skin)
        move = _moving(whole @ imprint.pose, center)
        share = min(1.0, config.bound / max(lost, 1e-9))
        off, worst = off + min(lost, config.bound), max(worst, lost)
        information += share * move.T @ known @ move
        pull += share * move.T @ g
    return _Fit(off, worst, information, pull)


def _moving(pad: Floats, center: Floats) -> Floats:
    """(6, 6) how a pad at (4, 4) object_from_sensor moves in its own frame, by (v, w) about a (3,) center."""
    back = pad[:3, :3].T
    return np.block([[back, -back @ hat(pad[:3, 3] - center)], [np.zeros((3, 3)), back]])

"""Poses drawn from a mode that is loose: a next touch must tell apart all that may be, not the middles of modes.

After a touch or two an object may lie along a face anyhow, and a mode is one place of many.  Metropolis and
Hastings, begun at the mode, with steps of its covariance: each step is put back onto the contacts by a few rounds
of refining, and weighed by whether the contacts lie on the surface there, whether it stands where the skin felt it
and not where the skin felt nothing, and whether it keeps out of what was swept (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from models.library import Entry
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.evidence import FreeSpace, Imprint
from recognition.matching.align import refine
from recognition.matching.contact_pairs import spread
from recognition.matching.evidence import Evidence
from recognition.matching.facets import facets_of
from recognition.matching.modes import Felt
from recognition.matching.next_touch.held import Posed
from recognition.matching.target import field_error, target_of


@dataclass(frozen=True)
class DrawConfig:
    """How poses are drawn and weighed."""

    steps: int = 6
    scales: tuple[float, ...] = (1.0, 0.5, 0.25)  # of a step, times the mode's own spread
    turned: float = 1.2  # [rad] of a step about each axis, at most
    contacts: int = 12  # that steps are put back onto
    rounds: int = 3
    bound: float = 9.0  # squared sigmas that a contact counts, at most
    cells: int = 10  # places of the skin of each touch that are asked
    pressed: float = 0.6  # of the deepest dent, from which there is surface in the skin
    slack: float = 0.5  # [mm] by which such a place may be off, besides the field's error
    wrong: float = 1.0  # log likelihood that one costs,
    swept: float = 0.5  # and a sample of the object in space that was swept
    most: float = 8.0  # the same of all that say so, at most
    shrunk: float = 2.0  # [mm] by which what was swept is narrower


class Few(NamedTuple):
    """Some contacts, as the kernels read them."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3)
    felt: Bools  # (n,)
    sigma: Floats  # (n,) [mm]
    tau: Floats  # (n,) [rad]
    shares: Floats  # (n,)


@dataclass(frozen=True)
class Seen:
    """The evidence as draws are weighed by it."""

    few: Few
    pressed: Floats  # (m, 3) [mm] places of the surface in the skin
    bare: Floats  # (m, 3) [mm] places of the skin without surface
    swept: tuple[FreeSpace, ...]

    @staticmethod
    def of(evidence: Evidence, config: DrawConfig) -> Seen:
        """Once for all objects."""
        felt, rows = Felt.of(evidence), spread(evidence.contacts, config.contacts)
        few = Few(felt.points[rows], felt.normals[rows], felt.felt[rows], felt.sigma[rows], felt.tau[rows],
                  felt.shares[rows])  # fmt: skip
        pressed = [_pressed(imprint, config) for imprint in evidence.imprints]
        apart = max(1, len(evidence.untouched) // (config.cells * max(len(pressed), 1)))
        swept = tuple(s for s in (evidence.free, evidence.missed) if s is not None and len(s.poses))
        return Seen(
            few,
            np.concatenate([np.empty((0, 3)), *pressed]),
            evidence.untouched[::apart],
            swept,
        )


def drawn(h: Posed, entry: Entry, many: int, seen: Seen, rng: np.random.Generator,
          config: DrawConfig) -> tuple[Floats, Floats]:  # fmt: skip
    """(n, 4, 4) poses world_from_object of one mode, and (n,) logarithms of what the evidence says of each."""
    values, axes = np.linalg.eigh(h.covariance)
    root = axes * np.sqrt(np.maximum(values, 0.0))
    middle = se3.pose(np.eye(3), target_of(entry).center)
    poses, like = _put_back(np.repeat(h.pose[None], many, axis=0), entry, seen, config)
    for _ in range(config.steps):
        scales = rng.choice(config.scales, size=(many, 1))
        steps = scales * rng.standard_normal((many, 6)) @ root.T
        steps[:, 3:] = np.clip(steps[:, 3:], -config.turned, config.turned)
        tried, then = _put_back(poses @ middle @ se3.exp(steps) @ se3.inverse(middle), entry, seen, config)
        taken = np.log(rng.random(many)) < then - like
        poses[taken], like[taken] = tried[taken], then[taken]
    return poses, like


def _put_back(at: Floats, entry: Entry, seen: Seen, config: DrawConfig) -> tuple[Floats, Floats]:
    """(n, 4, 4) poses moved onto the contacts, and (n,) what the evidence says of them."""
    mesh = facets_of(entry.solid.body)
    few = seen.few
    done = refine(np.ascontiguousarray(_turned_round(at)), *few, mesh, 1.0, config.rounds)
    off = np.minimum((done.distances / few.sigma) ** 2, config.bound)
    off += np.where(few.felt, np.minimum((done.angles / few.tau) ** 2, config.bound), 0.0)
    poses = np.tile(np.eye(4), (len(at), 1, 1))
    poses[:, :3] = _turned_round(done.poses)
    return poses, np.asarray(-0.5 * off @ few.shares - _contradicted(entry, poses, seen, config))


def _turned_round(at: Floats) -> Floats:
    """(n, 3, 4) inverses."""
    turn = np.swapaxes(at[:, :3, :3], 1, 2)
    return np.concatenate([turn, -turn @ at[:, :3, 3:]], axis=2)


def _contradicted(entry: Entry, worlds: Floats, seen: Seen, config: DrawConfig) -> Floats:
    """(n,) log likelihood that poses (n, 4, 4) lose by what is no contact."""
    target, back = target_of(entry), se3.inverse(worlds)
    slack, lost = config.slack + field_error(target), np.zeros(len(worlds))

    def bounded(wrong: Bools, each: float) -> Floats:
        return np.asarray(np.minimum(each * wrong.reshape(len(worlds), -1).sum(axis=1), config.most))

    def depth(points: Floats) -> Floats:
        return np.asarray(entry.field.signed_distance(se3.transform_points(back, points).reshape(-1, 3)))

    if len(seen.pressed):
        lost += bounded(np.abs(depth(seen.pressed)) > slack, config.wrong)
    if len(seen.bare):
        lost += bounded(depth(seen.bare) < -slack, config.wrong)
    if seen.swept:
        there = se3.transform_points(worlds, target.points).reshape(-1, 3)
    for space in seen.swept:
        lost += bounded(space.contains(there, margin=config.shrunk), config.swept)
    return lost


def _pressed(imprint: Imprint, config: DrawConfig) -> Floats:
    """(m, 3) [mm] places where the surface stands deep in the skin."""
    live = np.isfinite(imprint.sigma)
    deepest = float(imprint.depth[live].max(initial=0.0))
    rows, columns = np.nonzero(live & (imprint.depth > config.pressed * deepest))
    kept = np.linspace(0, len(rows) - 1, min(config.cells, len(rows))).astype(np.int64)
    rows, columns = rows[kept], columns[kept]
    local = np.column_stack([imprint.x[columns], imprint.y[rows], -imprint.depth[rows, columns]])
    return se3.transform_points(imprint.pose, local)

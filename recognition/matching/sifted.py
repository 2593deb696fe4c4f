"""Which poses of which objects are worth the whole refinement: what the field cannot say, the exact surface can.

Beside edges and in narrow places a distance field errs by more than contacts do, so that the true pose of the true
object may look far worse on it than a false one.  The best poses of each object are refined for a few rounds by a
few contacts on the exact surface, and those whose likelihood there is far behind are given up.  But the field errs
by no more than so much: in 500 queries one pose that came out best lay more than 8 a contact behind the best of
all there.  So farther ones are looked at where the others settle nothing, more of each object, for more rounds.
These rounds begin with no more noise than the field's error, since the poses have descended on it: wider looks at
many more facets.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from models.library import Entry
from primitives.arrays import Floats, Ints
from recognition.console.interrupts import checkpoint
from recognition.matching.align import refine
from recognition.matching.contact_pairs import of_one_face, spread
from recognition.matching.evidence import Evidence
from recognition.matching.facets import facets_of
from recognition.matching.hypotheses import Found
from recognition.matching.likelihood import NoiseConfig, log_each, log_likelihoods
from recognition.matching.modes import Felt
from recognition.matching.readings import readings
from recognition.matching.target import field_error, target_of


@dataclass(frozen=True)
class SiftConfig:
    """How many poses are looked at, and which of them stay."""

    each: int = 12  # poses of an object that are looked at
    each_blind: int = 96  # the same where no normals were felt
    each_flat: int = 24  # the same where nothing but one face was, which many faces of many objects fit
    far: float = 8.0  # of cost on the field, a contact, behind the best: none beyond is looked at
    contacts: int = 16  # that judge them
    rounds: int = 3
    behind: float = 14.0  # of log likelihood on the exact surface, by which a pose may be behind
    on_field: float = 12.0  # the same on the field, where the noise is not known; and, a contact,
    on_field_each: float = 1.0
    in_all: int = 40  # poses of all objects that stay, at most, however many contacts there are
    in_all_flat: int = 400  # the same where nothing but one face was felt
    turn: float = 0.02  # of log likelihood, by which each pose of an object stands back behind the one before
    steps: int = 4000  # contacts times poses that stay, at most, while contacts are few


@dataclass
class Sieve:
    """Sifts more and more objects; what was looked at once is kept."""

    library: Mapping[str, Entry]
    seen: Felt
    evidence: Evidence
    noise: NoiseConfig
    config: SiftConfig
    _poses: dict[str, Floats] = field(default_factory=dict)
    _scores: dict[str, Floats] = field(default_factory=dict)  # logarithms of what contacts say of each pose

    def through(self, found: Mapping[str, Found]) -> dict[str, Floats]:
        """(k, 3, 4) poses of each object that has any that may be the best of all, best first."""
        blind, n = self.seen.felt.sum() < 3, len(self.seen.points)
        flat = of_one_face(self.seen.normals, self.seen.felt)
        each = self.config.each_blind if blind else self.config.each_flat if flat else self.config.each
        exact = self.evidence.scale_known and not blind
        few = spread(self.evidence.contacts, self.config.contacts) if exact else np.arange(n)
        least = min((float(f.costs.min()) for f in found.values() if len(f.costs)), default=0.0)
        for name, f in found.items():
            if name not in self._poses:
                poses, costs = f.poses[:each], f.costs[:each]
                near = (
                    (costs <= least + self.config.far * n) | (np.arange(len(costs)) < f.given) | (not exact)
                )
                if near.any():
                    self._look(name, poses[near], costs[near], few, exact)
        if not self._poses:
            return {}
        behind = self.config.behind * n / len(few)
        if not exact:
            behind = self.config.on_field + self.config.on_field_each * n
        in_all = self.config.in_all_flat if flat else self.config.in_all
        limit = max(in_all, self.config.steps // n, each)
        return _best(self._poses, self._scores, behind, limit, self.config.turn)

    def _look(self, name: str, poses: Floats, costs: Floats, few: Ints, exact: bool) -> None:
        entry, seen = self.library[name], self.seen
        there = seen.places.log_density(target_of(entry).area, seen.shares)
        scores = -0.5 * costs
        if exact:
            poses, like = _looked_at(entry, poses, seen, few, self.noise, self.config)
            scores = like * len(seen.points) / len(few)
        self._poses[name], self._scores[name] = poses, there + scores


def _looked_at(entry: Entry, poses: Floats, seen: Felt, few: Ints, noise: NoiseConfig,
               config: SiftConfig) -> tuple[Floats, Floats]:  # fmt: skip
    """The poses after a few rounds, and (k,) the logarithm of what some contacts say of each."""
    checkpoint()
    target = target_of(entry)
    wider = max(1.0, field_error(target) / float(np.median(seen.sigma)))
    felt, sigma, tau, shares = seen.felt[few], seen.sigma[few], seen.tau[few], seen.shares[few]
    contacts = np.ascontiguousarray(seen.points[few]), np.ascontiguousarray(seen.normals[few]), felt
    mesh = facets_of(entry.solid.body)
    done = refine(np.ascontiguousarray(poses), *contacts, sigma, tau, shares, mesh, wider, config.rounds)
    told = [
        log_each(*log_likelihoods(done.distances, angles, felt, sigma, tau, target.size, noise), noise)
        @ shares
        for angles in readings(done, entry.solid.body)
    ]
    return done.poses, np.max(told, axis=0)


def _best(
    poses: Mapping[str, Floats], scores: Mapping[str, Floats], behind: float, limit: int, turn: float
) -> dict[str, Floats]:
    """Those that are not far behind, at most so many of all objects, which take turns by `turn` where they tie.

    Where contacts tell little, poses of one object that all fit would leave no place to the others.
    """
    names = [name for name in poses for _ in range(len(poses[name]))]
    rows = np.concatenate([np.arange(len(p)) for p in poses.values()])
    all_scores = np.concatenate([scores[name] for name in poses])
    places = np.concatenate([np.argsort(np.argsort(-scores[name], kind="stable")) for name in poses])
    order = np.argsort(turn * places - all_scores, kind="stable")[:limit]
    taken: dict[str, list[int]] = {}
    for k in order[all_scores[order] >= all_scores.max() - behind]:
        taken.setdefault(names[k], []).append(int(rows[k]))
    return {name: poses[name][which] for name, which in taken.items()}

"""Evidence and a library -> `Belief`: shortlist, search, refine, weigh.

    shortlist   objects by the distances and angles of pairs of contacts (`models.library.pair_table`)
    search      poses of each, scored on its distance field (`hypotheses`)
    sift        those poses of all objects that may still be the best (`sifted`)
    refine      these on the exact surface, each once (`refining`); some by what the skin felt (`sharpened`)
    weigh       names, poses and "unknown" against each other

Where the belief is not settled by the first objects of the shortlist, or what is decided does not fit, the next
ones are searched too, and at last a few hundred.  Where that settles nothing either, more poses of each are looked
at more closely, and the likeliest are slid and turned (`sliding`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy.special import logsumexp

from models.library import Entry
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.facing import may_face_in
from primitives.pose import frame_along, inverse
from recognition.console.interrupts import checkpoint
from recognition.matching.belief import UNKNOWN, Belief
from recognition.matching.contact_pairs import spread
from recognition.matching.evidence import Evidence, Prior
from recognition.matching.facing import either, turned
from recognition.matching.flats import flats_of
from recognition.matching.hypotheses import Begun, Found, SearchConfig, begin, scored, search
from recognition.matching.likelihood import NoiseConfig, log_each, log_likelihoods, log_scattered
from recognition.matching.modes import Felt, Mode, modes_of, residual
from recognition.matching.refining import Refining
from recognition.matching.shortlist import shortlist
from recognition.matching.sifted import SiftConfig
from recognition.matching.target import Target, target_of

_ALIKE = 0.9  # share of unknown objects that are somewhat like one of the library


@dataclass(frozen=True)
class MatchConfig:
    """What is searched, weighed and kept."""

    search: SearchConfig = field(default_factory=SearchConfig)
    noise: NoiseConfig = field(default_factory=NoiseConfig)
    sift: SiftConfig = field(default_factory=SiftConfig)
    # where the first look settles nothing
    closer: SiftConfig = field(default_factory=lambda: SiftConfig(each=24, far=12.0, rounds=5))
    shown: int = 3  # normals, from which on the exact surface sifts, and closer may be another
    first: int = 16  # objects of the shortlist that are searched at once
    then: int = 48  # that are searched where these settle nothing
    at_last: int = 160  # that are searched where these settle nothing, either
    telling: int = 4  # contacts from which on their pairs rank objects
    most_untold: int = 500  # objects that are searched where they do not
    settled: float = 0.98  # probability of a name from which on the first are enough
    pinned: float = 5.0  # [mm] error of its place, below which they are
    unusual: float = 2.5  # standard deviations of a fit, beyond which more objects are searched
    believed: int = 4  # poses of an object that were believed, and are looked at before new ones
    polished: int = 24  # of these, refined again to the least mean distance
    slid: int = 2  # poses that are slid and turned, where nothing is settled
    most: int = 400  # contacts that are searched with; of more, those that lie farthest apart
    weighed: int = 1500  # contacts that weigh what was found; of more, every so many-th
    again: int = 16  # hypotheses that these weigh
    told: int = 64  # hypotheses in the belief
    inward: float = 0.01  # how often the normals of contacts point into the object; 0 where they never do


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
    whole = evidence.checked()
    matched = partial(
        _matched, library=library, prior=prior, unknown=unknown, starts=tuple(starts), config=config
    )
    if not (config.inward and may_face_in(whole.contacts, whole.scale_known)):
        return matched(whole)
    try:
        as_given = matched(whole)
    except _NowhereError:
        return replace(matched(turned(whole)), inward=1.0)
    try:
        return either(as_given, matched(turned(whole)), config.inward)
    except _NowhereError:
        return as_given


class _NowhereError(PalpateError):
    """No pose within the prior meets the contacts."""


def _matched(whole: Evidence, library: Mapping[str, Entry], prior: Prior | None, unknown: float,
             starts: Iterable[tuple[str, Floats]], config: MatchConfig) -> Belief:  # fmt: skip
    """The same, with the normals as they are given."""
    evidence = _of(whole, np.sort(spread(whole.contacts, config.most)))  # places are weighed in their order
    told_where, prior = prior, prior or Prior.around(evidence.contacts)
    known: dict[str, list[Floats]] = {}
    for name, at in starts:
        known.setdefault(name, []).append(inverse(at)[:3])
    begun = begin(
        evidence.contacts, config.search, float(np.median(evidence.contacts.sigma)), evidence.scale_known
    )
    told = len(evidence.contacts) >= config.telling
    most = config.at_last if told else config.most_untold
    likely = [name for name in known if name in library][: config.first // 2]
    ranked = shortlist(evidence.contacts, library, most, tuple(known))
    names = [*likely, *(name for name in ranked if name not in likely)]
    found: dict[str, Found] = {}
    refining = Refining(library, evidence, prior, config.noise, config.sift, config.polished, config.slid)
    belief = Belief((), {})
    for count in sorted({min(k, len(names)) for k in (config.first, config.then, len(names))}):
        for name in names[len(found) : count]:
            found[name] = _searched(library[name], begun, known.get(name, []), config)
        modes = refining.modes(found)
        belief = _weighed(modes, library, evidence, prior, unknown, config)
        if _settled(belief, config) and _fits(belief, evidence, config):
            break
    else:
        if told and evidence.scale_known and np.count_nonzero(evidence.contacts.has_normal) >= config.shown:
            modes = refining.closer(found, config.closer)
            belief = _weighed(modes, library, evidence, prior, unknown, config)
    if modes and not (_settled(belief, config) and _fits(belief, evidence, config)):
        modes = refining.beside(modes, begun, config.search)
        belief = _weighed(modes, library, evidence, prior, unknown, config)
    if told_where and not belief.hypotheses:
        _require_near(told_where, evidence, max(target_of(library[name]).size for name in found))
    if len(evidence.contacts) == len(whole.contacts) or not belief.hypotheses:
        return belief
    return _weighed_again(belief, library, whole, prior, unknown, config)


def _of(evidence: Evidence, rows: Ints) -> Evidence:
    if len(rows) == len(evidence.contacts):
        return evidence
    return replace(evidence, contacts=evidence.contacts.select(rows))


def _weighed_again(belief: Belief, library: Mapping[str, Entry], whole: Evidence, prior: Prior, unknown: float,
                   config: MatchConfig) -> Belief:  # fmt: skip
    """The likeliest hypotheses by contacts as they came: those farthest apart hold all that are astray."""
    n = len(whole.contacts)
    rows = np.unique(np.linspace(0, n - 1, min(n, config.weighed)).astype(np.int64))
    evidence = _of(whole, rows)
    poses: dict[str, list[Floats]] = {}
    for h in belief.hypotheses[: config.again]:
        poses.setdefault(h.name, []).append(inverse(h.pose)[:3])
    seen = Felt.of(evidence)
    modes = [
        mode
        for name, p in poses.items()
        for mode in modes_of(library[name], np.stack(p), seen, evidence, prior, config.noise, config.polished)
    ]
    belief = _weighed(modes, library, evidence, prior, unknown, config)
    told = []
    for h in belief.hypotheses:
        each = np.full(n, np.nan)
        each[rows] = h.log_likelihoods
        told.append(replace(h, log_likelihoods=frozen(each)))
    return replace(belief, hypotheses=tuple(told))


def _settled(belief: Belief, config: MatchConfig) -> bool:
    """Whether no other object need be searched: where the pose may slide, many a face fits what was felt."""
    best = belief.best(belief.decision)
    return belief.confidence > config.settled and best is not None and best.translation_sigma < config.pinned


def _fits(belief: Belief, evidence: Evidence, config: MatchConfig) -> bool:
    """Whether the contacts lie on what is decided for no worse than their noise lets them.

    A contact's distance and normal cost half a nat for each of their dimensions, as chi-squared does.
    """
    best = belief.best(belief.decision)
    if best is None or not evidence.scale_known:
        return best is not None
    seen, nothing = Felt.of(evidence), np.zeros((1, len(evidence.contacts)))
    size = 2.0 * float(np.linalg.norm(np.ptp(seen.points, axis=0))) + 1.0
    both = log_likelihoods(nothing, nothing, seen.felt, seen.sigma, seen.tau, size, config.noise)
    lost = float(seen.shares @ (log_each(*both, config.noise)[0] - best.log_likelihoods))
    dimensions = np.where(seen.felt, 3.0, 1.0)
    usual, spread_of = seen.shares @ dimensions / 2.0, np.sqrt(seen.shares**2 @ dimensions / 2.0)
    return bool(lost <= usual + config.unusual * spread_of)


def _searched(entry: Entry, begun: Begun, starts: list[Floats], config: MatchConfig) -> Found:
    checkpoint()
    target = target_of(entry)
    found = search(begun, target, config.search, () if begun.lone is None else flats_of(entry))
    poses = np.stack(starts) if starts else np.empty((0, 3, 4))
    if not len(found.poses) and not starts:
        poses = _laid(begun, target)
    if not len(poses):
        return found
    costs = np.concatenate([found.costs, scored(begun, target, poses, config.search)])
    poses = np.concatenate([found.poses, poses])
    found = begun.distinct(poses, costs, len(poses), config.search.differ, target.size)
    if not starts:
        return found
    first = np.stack(starts[: config.believed])
    there = scored(begun, target, first, config.search)
    return Found(np.concatenate([first, found.poses]), np.concatenate([there, found.costs]), len(first))


def _weighed(modes: list[Mode], library: Mapping[str, Entry], evidence: Evidence, prior: Prior, unknown: float,
             config: MatchConfig) -> Belief:  # fmt: skip
    """Names, poses and "unknown" against each other."""
    each = np.log((1.0 - unknown) / len(library))
    log_names = dict.fromkeys(library, -np.inf)
    for m in modes:
        name = m.hypothesis.name
        log_names[name] = float(np.logaddexp(log_names[name], each + m.log_known))
    if unknown > 0:
        alike = np.log(unknown * _ALIKE / len(library))
        points, felt = evidence.contacts.points, evidence.contacts.has_normal
        anywhere = log_scattered(points, felt, evidence.shares, prior.volume)
        scattered = np.log(unknown * (1.0 - _ALIKE)) + anywhere
        log_names[UNKNOWN] = float(logsumexp([*(alike + m.log_unknown for m in modes), scattered]))
    total = float(logsumexp(list(log_names.values())))
    if not np.isfinite(total):
        raise _NowhereError(_nowhere(evidence, prior))
    told = sorted(modes, key=lambda m: -m.log_known)[: config.told]
    points = evidence.contacts.points
    hypotheses = tuple(
        replace(
            m.hypothesis,
            log_weight=float(each + m.log_known - total),
            residual=residual(library[m.hypothesis.name], m.hypothesis.pose, points),
        )
        for m in told
    )
    return Belief(hypotheses, {name: float(np.exp(x - total)) for name, x in log_names.items()}, total)


def _laid(begun: Begun, target: Target) -> Floats:
    """(k, 3, 4) poses that lay samples on a single contact."""
    point, normal = begun.points[0], begun.normals[0]
    frame = frame_along(normal).T if normal.any() else None
    poses = []
    for p, n in zip(target.points[:16], target.normals[:16], strict=True):
        turn = frame_along(n) @ (frame_along(n).T if frame is None else frame)
        poses.append(np.column_stack([turn, p - turn @ point]))
    return np.stack(poses)


def _require_near(prior: Prior, evidence: Evidence, widest: float) -> None:
    """An object at a place that was told, of which no contact can be, is an error: it is not unknown."""
    away = np.linalg.norm(evidence.contacts.points - prior.center, axis=1)
    if away.min() > prior.radius + widest:
        raise _NowhereError(_nowhere(evidence, prior))


def _nowhere(evidence: Evidence, prior: Prior) -> str:
    away = float(np.linalg.norm(evidence.contacts.points - prior.center, axis=1).min())
    return (f"no pose within {prior.radius:g} mm of the prior's center meets the contacts, the nearest "
            f"{away:.0f} mm away; move --prior-center or widen --prior-radius")  # fmt: skip

"""Where an object is, as exactly as touches tell it: how far stage and object err is estimated along with it.

Names are told with a wide guess of how far a touch is off, for nobody knows a stage's errors, nor how an object
differs from its model.  Once the object is known, its touches tell that too.  With m [mm] the error of a touch's
place, a [rad] that of its attitude, and log-normal priors about the guess::

    p(m, a | Z) ~ p(m) p(a) integral over poses of p(Z | pose, m, a)

the integral by Laplace, as a mode's own (`matching.modes`): errors are estimated after as many of the contacts'
freedoms are taken off as the pose has (restricted likelihood: Patterson and Thompson 1971).  The pose is refined
with the mean of their squares.  What errs so is common to all that one touch felt: the contacts of a flat patch
are taken for one, their middle with its normal.  Normals of round faces keep the guess, for that flat ones agree
says nothing of them; and a pose that the pictures of the skin speak against is not taken (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from exploration.planning.touching.lone_touch import LoneTouch
from models.library import Entry
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.pose import inverse
from recognition.identifying.learned import LearnConfig, evidence_of
from recognition.matching import Evidence, Hypothesis, Prior
from recognition.matching.imprints import log_imprints
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.modes import Felt, Mode, modes_of, residual
from recognition.matching.sharpened import SharpenConfig, sharpened

_FLAT = 4  # contacts that a touch of a flat face leaves, at least


@dataclass(frozen=True)
class ExactConfig:
    """What is known of a touch's errors before."""

    factors: tuple[float, ...] = (0.0625, 0.125, 0.25, 0.5, 1.0, 2.0)  # on the guess, that are tried
    unsure: float = 1.0  # 1 sigma of their logarithm
    flat: float = 0.05  # [rad] between normals of a patch that counts as flat
    worse: float = 1.0  # of log likelihood, by which pictures speak against a pose that contacts were led to


class Exact(NamedTuple):
    """A pose, and how far touches were estimated to be off."""

    hypothesis: Hypothesis
    place: float  # [mm]
    turn: float  # [rad]

    def within(self, place: float, turn: float) -> bool:
        """Whether the pose errs by no more than that [mm], [rad], 1 sigma."""
        return self.hypothesis.translation_sigma <= place and self.hypothesis.rotation_sigma <= turn


def exact(
    h: Hypothesis,
    entry: Entry,
    touches: Sequence[LoneTouch],
    prior: Prior,
    guess: LearnConfig | None = None,
    config: ExactConfig | None = None,
) -> Exact | None:
    """The hypothesis refined, with the covariance that its touches let it have; None where no pose fits."""
    guess, config = guess or LearnConfig(), config or ExactConfig()
    patches = [replace(t, contacts=_patch(t.contacts, guess, config)) for t in touches if t.met]
    factors = np.array(list(product(config.factors, repeat=2)))
    seen = Felt.of(Evidence(evidence_of(patches, guess).contacts))
    fits = [_refined(h, entry, patches, seen, prior, _erring(guess, *f)) for f in factors]
    told = np.array([-np.inf if fit is None else fit.log_known for fit in fits])
    if not np.isfinite(told).any():
        return None
    told -= 0.5 * (np.log(factors) ** 2).sum(axis=1) / config.unsure**2
    share = np.exp(told - told.max())
    mean = np.sqrt(share @ factors**2 / share.sum())
    erring = _erring(guess, *mean)
    fit = _refined(h, entry, patches, seen, prior, erring, pictured=True)
    if fit is None:
        return None
    whole = evidence_of(touches, guess)
    at = fit.hypothesis.pose
    made = replace(
        h, pose=at, covariance=fit.hypothesis.covariance, residual=residual(entry, at, whole.contacts.points)
    )
    astray = log_imprints(made, entry, whole) < log_imprints(h, entry, whole) - config.worse
    return Exact(h if astray else made, erring.made, erring.made_angle)


def _erring(guess: LearnConfig, place: float, turn: float) -> LearnConfig:
    return replace(guess, made=guess.made * float(place), made_angle=guess.made_angle * float(turn))


def _refined(
    h: Hypothesis,
    entry: Entry,
    patches: Sequence[LoneTouch],
    seen: Felt,
    prior: Prior,
    erring: LearnConfig,
    pictured: bool = False,
) -> Mode | None:
    """The mode that the hypothesis leads to with such errors; `pictured`: by what the whole skin felt, too."""
    felt = evidence_of(patches, erring)
    alone, noise, seen = Evidence(felt.contacts), NoiseConfig(), seen.erring(felt.contacts)
    start: Floats = np.ascontiguousarray(inverse(h.pose)[None, :3])
    found = modes_of(entry, start, seen, alone, prior, noise, 1)
    if found and pictured:
        skin = SharpenConfig(aside=erring.made, spin=erring.made_angle)
        whole = Evidence(felt.contacts, imprints=felt.imprints)
        found = sharpened(found, {h.name: entry}, seen, whole, prior, noise, skin)
    return found[0] if found else None


def _patch(c: Contacts, guess: LearnConfig, config: ExactConfig) -> Contacts:
    """The contacts of a flat patch as one; those of a round one with normals as far off as is guessed."""
    if not len(c) or not c.has_normal.all():
        return c
    normal = c.normals.mean(axis=0)
    length = float(np.linalg.norm(normal))
    if len(c) < _FLAT or length < np.cos(config.flat):
        return replace(c, normal_sigma=frozen(np.hypot(c.normal_sigma, guess.made_angle)))
    return replace(
        c.select(np.array([0])),
        points=frozen(c.points.mean(axis=0)[None]),
        normals=frozen(normal[None] / length),
        sigma=frozen(np.median(c.sigma, keepdims=True)),
        normal_sigma=frozen(np.median(c.normal_sigma, keepdims=True)),
    )

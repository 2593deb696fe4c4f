"""`locate` and `recognize`: a source, a model or a library, and the answer as `--json` prints it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from exploration.planning.touching.pace import Pace
from exploration.sensing.spec import load_sensor
from models.formats.units import Units
from models.library import Entry, Library
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.pose import pose
from recognition.builtin import part_library
from recognition.config import ExploreOptions, parse_numbers
from recognition.identifying.bounds import believed_ball
from recognition.matching import Belief, Evidence, Prior
from recognition.matching.evidence import WIDE
from recognition.matching.facing import turned
from recognition.matching.hypotheses import SearchConfig
from recognition.matching.match import MatchConfig
from recognition.matching.next_touch import Choice, separating
from recognition.matching.next_touch.sampled import sampled
from recognition.recognizing.answer import (
    modes,
    objects,
    of_contacts,
    other_object,
    other_unit,
    warnings_of,
    why,
)
from recognition.recognizing.kept_model import kept_model
from recognition.recognizing.settled import MADE, settled
from recognition.recognizing.truth import truth_of
from recognition.reconstructing.options import require_sigma
from recognition.reconstructing.scatter import scatter
from recognition.sources import read_source
from recognition.sources.noise import estimated_sigma
from recognition.sources.source import Source

_UNKNOWN = 0.1  # prior probability that an object is none of the library
_SURE = 0.95  # confidence from which on nothing is left to tell
_NORMAL_SIGMA = 0.037  # [rad] where nobody told: 3 degrees in total; its scale is then estimated


@dataclass(frozen=True)
class Asked:
    """What both commands are told."""

    source: str
    sigma: float | None = None  # [mm] of contacts; None: as the file says, else estimated
    center: Sequence[float] | None = None  # (3,) [mm] of the prior
    radius: float = WIDE  # [mm]
    seed: int = 0  # of the turns that the search begins with where no normals were felt

    def __post_init__(self) -> None:
        require_sigma(self.sigma)
        if not (math.isfinite(self.radius) and self.radius > 0):
            raise PalpateError(f"--prior-radius must be a positive length in mm, not {self.radius:g}")
        if self.seed < 0:
            raise PalpateError(f"--seed must be 0 or more, not {self.seed}")

    @property
    def matching(self) -> MatchConfig:
        """How it is searched."""
        return MatchConfig(search=SearchConfig(seed=self.seed))


def parse_center(text: str | None) -> tuple[float, ...] | None:
    """`--prior-center`, where it is given."""
    return None if text is None else parse_numbers(text, 3, "--prior-center", "X,Y,Z in mm")


def evidence_of(
    asked: Asked, source: Source, guess: Callable[[Contacts], float] = estimated_sigma
) -> Evidence:
    """The contacts of a source and what it swept, their noise as told or to be estimated.

    The estimate begins with a `guess`, near which the search looks.  Of one model that is known to be there a wide
    one misses nothing; of many objects it would let most of them fit.
    """
    told = source.measured_sigma or asked.sigma is not None
    guessed = asked.sigma if told else guess(source.contacts)
    contacts = source.with_sigma(guessed).contacts
    sigma = np.hypot(contacts.sigma, MADE)
    contacts = replace(contacts, sigma=sigma, normal_sigma=np.full(len(contacts), _NORMAL_SIGMA))
    free = None if source.sweep is None else source.sweep()
    return Evidence(contacts, (), free, told, normal_scale_known=False)


def prior_of(asked: Asked, evidence: Evidence) -> Prior | None:
    """As told, or round the contacts; None where nothing was told."""
    if asked.center is None:
        return None if asked.radius == WIDE else Prior.around(evidence.contacts, asked.radius)
    return Prior(np.asarray(asked.center, dtype=float), asked.radius)


def locate(
    asked: Asked, model: str, units: Units, scale: float, body: int | None = None, facets: bool = False
) -> dict[str, Any]:
    """Every pose of one known model that the contacts allow, with its probability."""
    source = read_source(asked.source)
    evidence = evidence_of(asked, source)
    entry, noted = kept_model(model, units, scale, body, facets)
    library = Library({entry.name: lambda: entry})
    _ = entry.samples, entry.field, entry.symmetry  # the model's own preparation is start-up
    began = time.perf_counter()
    belief, evidence = settled(evidence, library, prior_of(asked, evidence), 0.0, asked.matching)
    told = modes(belief, entry)
    return {
        "command": "locate",
        "decision": entry.name,
        "confidence": told[0]["probability"],
        "contacts": len(evidence.contacts),
        **_cost(source),
        "wall_seconds": time.perf_counter() - began,
        "candidates": told,
        "history": [],
        "why": {"runner_up": entry.name if len(told) > 1 else None, "separating_contacts": []},
        "truth": truth_of(asked.source, belief, library, scale),
        "warnings": [
            *source.warnings,
            *noted,
            *of_contacts(belief, evidence),
            *other_object(belief.hypotheses[0], evidence, entry),
            *other_unit(evidence, library, [entry.name]),
        ],
    }


def recognize(asked: Asked, folder: Path | None, units: Units, scale: float) -> dict[str, Any]:
    """Which object of a library (the built-in parts, without a folder) was touched, and where it is."""
    source = read_source(asked.source)
    evidence = evidence_of(asked, source, scatter)
    library = part_library() if folder is None else Library.open(folder, units, scale)
    began = time.perf_counter()
    belief, evidence = settled(evidence, library, prior_of(asked, evidence), _UNKNOWN, asked.matching)
    seconds = time.perf_counter() - began
    noted = [
        *warnings_of(belief, evidence),
        *other_unit(evidence, library, [h.name for h in belief.hypotheses]),
    ]
    return {
        "command": "recognize",
        "decision": belief.decision,
        "confidence": belief.confidence,
        "unknown": belief.probabilities.get("unknown", 0.0),
        "contacts": len(evidence.contacts),
        **_cost(source),
        "wall_seconds": seconds,
        "candidates": objects(belief, library),
        "history": [],
        "why": why(belief, _would_tell(belief, evidence, library, asked.seed), source.rows),
        "truth": truth_of(asked.source, belief, library, scale),
        "warnings": [*source.warnings, *library.warnings, *noted],
    }


def _would_tell(belief: Belief, evidence: Evidence, library: Library, seed: int) -> Choice | None:
    """Where it is not sure, the touch of the usual array, coming from above, that would tell most of the name."""
    if belief.confidence >= _SURE:
        return None
    likely = Library({name: _taken(library, name) for name in belief.probabilities if belief.best(name)})
    if not len(likely):
        return None
    evidence = turned(evidence) if belief.inward > 0.5 else evidence
    pad = load_sensor(ExploreOptions("").sensors[0]).array.size
    around = believed_ball(evidence.contacts, len(evidence.contacts), belief, likely, pad)
    above = around.center + np.array([0.0, 0.0, around.radius])
    here = pose(np.diag([1.0, -1.0, -1.0]), above)
    rng = np.random.default_rng(seed)
    known = sampled(belief, likely, evidence, rng)
    found = separating(belief, likely, here, around, pad, Pace(), rng, known=known)
    return found if isinstance(found, Choice) else None


def _taken(library: Library, name: str) -> Callable[[], Entry]:
    return lambda: library[name]


def _cost(source: Source) -> dict[str, Any]:
    """What the evidence took to touch, as far as its source says; nothing is touched for the answer."""
    return {"touches": source.felt.touches, "travel_mm": source.felt.travel}

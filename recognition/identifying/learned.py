"""What touches tell together: one `Evidence`, and the belief that follows from it.

Contacts, the space swept while the object stood still, places of the skin that felt nothing beside others that
did, the whole picture that the skin felt, and approaches that met nothing are matched at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.touching.lone_touch import LoneTouch, joined
from models.library import Library
from primitives.arrays import frozen
from primitives.evidence import Contacts
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.belief import UNKNOWN


@dataclass(frozen=True)
class LearnConfig:
    """How far touches are trusted, and what is tried again."""

    bounding: int = 4  # touches with normals, from which swept space tells poses apart
    starts: int = 40  # hypotheses that are tried again after the next touch
    made: float = 0.12  # [mm] by which an object differs from its model
    made_angle: float = 0.02  # [rad] likewise


def evidence_of(touches: Sequence[LoneTouch], config: LearnConfig | None = None) -> Evidence:
    """All that was felt, with what an object may differ from its model added to the noise."""
    config = config or LearnConfig()
    met = [t for t in touches if t.met]
    contacts = Contacts.concatenate([t.contacts for t in met])
    contacts = replace(
        contacts,
        sigma=frozen(np.hypot(contacts.sigma, config.made)),
        normal_sigma=frozen(np.hypot(contacts.normal_sigma, config.made_angle)),
    )
    traces = tuple(trace for t in met for trace in t.edges)
    held_still = sum(bool(t.contacts.has_normal.any()) for t in met) >= config.bounding
    return Evidence(
        contacts,
        traces,
        joined([t.free for t in touches]) if held_still else None,
        untouched=np.concatenate([np.empty((0, 3)), *(t.untouched for t in touches)]),
        missed=joined([t.free for t in touches if not t.met]),
        imprints=tuple(t.imprint for t in met if t.imprint is not None),
    )


def unfelt(library: Library, unknown: float) -> Belief:
    """What is believed before anything was met: the prior."""
    each = {name: (1.0 - unknown) / len(library) for name in library}
    return Belief((), each | ({UNKNOWN: unknown} if unknown > 0 else {}))


def learned(
    touches: Sequence[LoneTouch],
    library: Library,
    prior: Prior,
    unknown: float,
    before: Belief | None,
    config: LearnConfig | None = None,
) -> Belief | None:
    """The belief after all touches; `before` is the one until now, whose poses are tried again."""
    config = config or LearnConfig()
    evidence = evidence_of(touches, config)
    if not len(evidence.contacts):
        return before
    starts = [] if before is None else [(h.name, h.pose) for h in before.hypotheses]
    return match(evidence, library, prior, unknown, starts[: config.starts])

"""The library of a trial, and what it says of the answer.

A library of built-in parts holds the trial's part and, after it in the list of parts and round its end, so many
others; where the part is to be unknown, all of those but itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from models import parts
from models.library import Library
from models.solid import Solid
from primitives.errors import PalpateError
from recognition.builtin import part_library
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work
from recognition.identifying.answer import truth_json
from recognition.matching.belief import Belief


def library_of(settings: Mapping[str, Value], name: str, work: Work) -> Library:
    """What the object is looked for in."""
    folder, size, unknown = settings["library"], settings["library_size"], bool(settings["unknown"])
    if folder:
        opened = _opened(str(work.base / str(folder)))
        if not unknown:
            return opened
        return Library({other: partial(opened.__getitem__, other) for other in opened if other != name})
    listed = parts.names()
    if name not in listed:
        raise PalpateError(f"{name} is no built-in part; give a library that holds it")
    first = listed.index(name)
    count = len(listed) if size is None else min(int(size), len(listed))
    chosen = [listed[(first + k) % len(listed)] for k in range(count + unknown)]
    chosen = [other for other in chosen[: len(listed)] if not (unknown and other == name)]
    return _built(tuple(sorted(chosen)))


def told_of(belief: Belief | None, library: Library, name: str, solid: Solid) -> dict[str, Value]:
    """The columns that every recognition has."""
    truth: dict[str, Any] = truth_json(belief, library, name, solid)
    answer = truth["name"]
    return {
        "decision": None if belief is None else belief.decision,
        "answer": answer,
        "correct": truth["correct"],
        "confidence": 0.0 if belief is None else belief.confidence,
        "answer_probability": 0.0 if belief is None else belief.probabilities.get(answer, 0.0),
        "translation_error_mm": truth["translation_error_mm"],
        "rotation_error_deg": truth["rotation_error_deg"],
    }


@lru_cache(maxsize=4)
def _opened(folder: str) -> Library:
    return Library.open(Path(folder))


@lru_cache(maxsize=8)
def _built(names: tuple[str, ...]) -> Library:
    return part_library(names)

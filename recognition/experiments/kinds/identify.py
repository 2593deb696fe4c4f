"""A trial that identifies, as the command does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from models.part import load_part
from recognition.experiments.kinds.libraries import library_of
from recognition.experiments.kinds.sensors import sensor_of
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work
from recognition.identifying.options import IdentifyOptions
from recognition.identifying.run import run

_COST = ("touches", "strokes", "frames", "travel_mm", "device_seconds", "wall_seconds")


def carry(settings: Mapping[str, Value], work: Work) -> dict[str, Value]:
    """Identify, and say whether the name is right and from which touch on it was."""
    s: Mapping[str, Any] = settings
    named = work.file(s["part"])
    library = library_of(s, load_part(named).name, work)
    options = IdentifyOptions(
        part=named,
        sensors=(sensor_of(s, work),),
        pose_noise=s["pose_noise_mm"],
        policy=s["policy"],
        confidence=s["stop_confidence"],
        max_touches=s["max_touches"],
        seed=s["seed"],
        out=work.scratch / "run",
    )
    summary = run(options, library)
    truth, answer = summary["truth"], summary["truth"]["name"]
    right = [led(step["top"], answer) for step in summary["history"]]
    shares = {c["name"]: c["probability"] for c in summary["candidates"]}
    return {
        "decision": summary["decision"],
        "answer": answer,
        "correct": truth["correct"],
        "confidence": summary["confidence"],
        "answer_probability": summary["confidence"] if truth["correct"] else shares.get(answer, 0.0),
        "translation_error_mm": truth["translation_error_mm"],
        "rotation_error_deg": truth["rotation_error_deg"],
        **{key: summary[key] for key in _COST},
        "touches_to_correct": since(right),
        "first_touches_right": "".join(str(int(led)) for led in right),
    }


def led(top: Sequence[Sequence[Any]], name: str) -> bool:
    """Whether a name is the likeliest, alone."""
    return bool(top) and top[0][0] == name and (len(top) < 2 or top[0][1] > top[1][1])


def since(right: Sequence[bool]) -> int | None:
    """The touch, counted from 1, from which on the right name led until the end."""
    if not right or not right[-1]:
        return None
    wrong = [k for k, led in enumerate(right) if not led]
    return wrong[-1] + 2 if wrong else 1

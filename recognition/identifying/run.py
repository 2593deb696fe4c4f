"""`palpate identify`: an object among those of a library, touched until it is sure which one it is.

The identifier sees the guard and the library; the object is asked for the truth when all touching has ended.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from models.library import Library
from primitives.errors import PalpateError
from recognition.builtin import part_library
from recognition.config import settings
from recognition.identifying.answer import of_pose, of_search, top, truth_json
from recognition.identifying.hand import GuardedHand
from recognition.identifying.identify import Identifier, IdentifyConfig, Step
from recognition.identifying.learned import unfelt
from recognition.identifying.options import IdentifyOptions
from recognition.live import so_far
from recognition.matching import Belief
from recognition.matching.next_touch.choose import Choice, separating
from recognition.recognizing.answer import objects, why
from recognition.report.against import drawn_truth, off_truth
from recognition.report.drawn import drawn
from recognition.report.page import write_report
from recognition.report.run_report import ReportMesh, RunReport
from recognition.running.felt_run import FeltRun, felt_run
from recognition.running.progress import Progress
from recognition.running.simulation import beside, load_world
from recognition.truth import LabeledFaces

Watch = Callable[[Step, Identifier], None]
_TOLD = 8  # likeliest names of each touch that the history lists


def run(
    options: IdentifyOptions,
    library: Library | None = None,
    told: Callable[[Progress], None] = lambda progress: None,
    watch: Watch = lambda step, identifier: None,
) -> dict[str, Any]:
    """Identify, and leave a run folder; returns what `summary.json` holds."""
    world = load_world(options)
    known = opened(options.library) if library is None else library
    if not len(known):
        raise PalpateError("the library holds no object; add CAD files to its folder")
    with felt_run(options, "identify", world, told) as felt:
        config = IdentifyConfig(
            options.policy,
            options.confidence,
            options.max_touches,
            options.unknown,
            place=options.pose_mm,
            turn=float(np.deg2rad(options.pose_deg)),
            finishing=options.pose_touches,
        )
        rng = np.random.default_rng([options.seed, 1])
        hand = GuardedHand(felt.guard, felt.warnings, beside(world, options), options.feature)
        identifier = Identifier(hand, known, felt.world.box.ravel(), config, rng, felt.announce)
        history: list[dict[str, Any]] = []
        prior = unfelt(known, options.unknown)

        def page() -> RunReport:
            felt_by_now = (identifier.evidence.contacts, identifier.evidence.traces)
            return so_far.identified(
                history, felt_by_now, world, felt.logbook.frames(), _model(identifier, known)
            )

        told(replace(felt.stand("looking for the object"), page=page))
        for step in identifier.run():
            history.append(_entry(step, step.belief or prior))
            watch(step, identifier)
            told(replace(felt.stand(step.touch.note), page=page))
        for trace in identifier.evidence.traces:
            felt.logbook.announce_trace(trace)
        felt.announce("ended", {"why": identifier.ended})
        separate = _separating(identifier)
    return _finish(felt, options, identifier, history, separate, known)


def opened(folder: Path | None) -> Library:
    """A library's folder; without one the built-in parts."""
    return part_library() if folder is None else Library.open(folder)


def _entry(step: Step, belief: Belief) -> dict[str, Any]:
    return {
        "touch": step.touch.touch,
        "entropy_bits": belief.entropy_bits,
        "top": top(belief.probabilities, _TOLD),
        "felt": step.touch.note,
        "device_seconds": step.seconds,
        "expected_bits": None if step.choice is None else step.choice.bits,
    }


def _separating(identifier: Identifier) -> Choice | None:
    """The touch that would settle what is left, where it is not sure."""
    if identifier.belief is None or identifier.ended == "sure":
        return None
    hand = identifier.hand
    try:
        around = hand.here, identifier.ball(), hand.pad, hand.pace, identifier.rng
        found = separating(identifier.belief, identifier.library, *around)
    except PalpateError:
        return None
    return found if isinstance(found, Choice) else None


def _finish(
    felt: FeltRun,
    options: IdentifyOptions,
    identifier: Identifier,
    history: list[dict[str, Any]],
    separate: Choice | None,
    library: Library,
) -> dict[str, Any]:
    belief = identifier.told or unfelt(library, options.unknown)
    candidates = objects(belief, library)
    said: dict[str, Any] = {
        "decision": belief.decision,
        "confidence": belief.confidence,
        "met": sum(touch.met for touch in identifier.touches),
        "ended": identifier.ended,
        "policy": options.policy,
        "library": {"objects": len(library), "folder": None if options.library is None else str(options.library)},
        "candidates": candidates,
        "history": history,
        "why": why(belief, separate),
        "truth": truth_json(identifier.told, library, felt.world.part.name, felt.world.solid)
        if felt.world.known
        else None,
        "warnings": list(library.warnings)
        + of_pose(identifier.ended, candidates)
        + of_search(identifier.ended, [touch.met for touch in identifier.touches]),
    }  # fmt: skip
    contacts, world = identifier.evidence.contacts, felt.world
    model = _model(identifier, library)
    summary = felt.told(said) | {
        "files": {"recording": "episode.mcap", "contacts": "contacts.csv", "report": "report.html"}
    }
    report = RunReport(
        summary=summary,
        settings=settings(options),
        model=model,
        contacts=contacts.points,
        contact_face=np.full(len(contacts), -1),
        frames=felt.logbook.frames(),
        pad_size=world.spec.array.size,
        housing_size=world.spec.housing.size,
        truth=drawn_truth(world.part, world.solid) if world.known else None,
        off=off_truth(model, world.solid) if world.known else None,
        traces=[trace.points for trace in identifier.evidence.traces],
    )
    with felt.folder.writing("report.html") as path:
        write_report(path, report)
    felt.folder.write_contacts(contacts, np.full(len(contacts), -1))
    felt.folder.finish(summary)
    return summary


def _model(identifier: Identifier, library: Library) -> ReportMesh | None:
    """The object decided for, where it is believed to be."""
    belief = identifier.told
    best = None if belief is None else belief.best(belief.decision)
    if best is None:
        return None
    solid = library[best.name].solid.placed(best.pose)
    return drawn(solid, LabeledFaces.of(solid).of_triangle)

"""`palpate explore`: an object of unknown shape and pose, touched until its boundary is closed, becomes a model.

Load, explore, reconstruct, compare, write: the steps of one run.  The explorer sees the guard alone; the object
is asked again only when exploration is over.

A run that a fault ended keeps what was felt before it, and says so in `ended`; where the fault is a bug of ours,
`bug.txt` beside the summary has the details.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from importlib.metadata import version

import numpy as np

from exploration.control.latency import measure_latency
from exploration.devices.guard import Guard
from exploration.planning.explorer import Explorer, ExplorerConfig, Findings
from exploration.planning.known.face_pictures import FacePicture, face_pictures
from exploration.recordings.mcap import Recorder
from models.solid import Solid
from primitives.errors import NotWritten, PalpateError
from recognition.assembly import NotClosed
from recognition.config import ExploreOptions, settings, to_toml
from recognition.console import bugs, interrupts
from recognition.draft import draft
from recognition.live import so_far
from recognition.reconstruct import Reconstruction, reconstruct
from recognition.report.against import drawn_truth, off_truth
from recognition.report.drawn import drawn
from recognition.report.felt import felt_faces
from recognition.report.page import write_report
from recognition.report.run_report import ReportFrames, RunReport
from recognition.report.skin_pictures import of_faces
from recognition.running.evidence_log import EvidenceLog
from recognition.running.folder import RunFolder
from recognition.running.logbook import Logbook
from recognition.running.patience import Patience
from recognition.running.picture_log import PICTURE
from recognition.running.picture_log import told as told_picture
from recognition.running.progress import Progress
from recognition.running.simulation import World, beside, guarded, load_world, tools
from recognition.running.summary import FAULT, summarize
from recognition.running.writing import write_model
from recognition.truth import LabeledFaces, Truth, evaluate

Watcher = Callable[[Progress], None]


def run(options: ExploreOptions, progress: Watcher) -> dict[str, object]:
    """Explore, and leave a run folder; returns what `summary.json` holds.

    Bad input is refused before anything is written.  An interrupt leaves the recording whole and no summary.
    """
    began = time.perf_counter()
    world = load_world(options, several=options.policy == "closure")
    folder = RunFolder.create(options.out, world.part.name, options.overwrite)

    def show(stand: Progress) -> None:
        interrupts.checkpoint()
        progress(stand.within(folder.path))

    with _owning_up(folder), interrupts.held(), closing(world):
        return _run(options, world, folder, show, began)


def _run(
    options: ExploreOptions, world: World, folder: RunFolder, progress: Watcher, began: float
) -> dict[str, object]:
    folder.write_text("config.toml", to_toml(options, version("palpate"), world.resolved()))
    with Recorder(folder.recording) as recorder:
        logbook = Logbook(recorder, specs=world.specs)
        guard = guarded(world, options, logbook.observe)
        if not world.known:
            guard.pending.latency = measure_latency(guard).seconds
        findings, pictures = _explored(guard, options, world, logbook, folder, progress)
    world.close()
    progress(_stand("reconstructing", guard, findings))
    free = np.concatenate(findings.inside) if findings.inside else None
    traces = [trace for trace, _ in findings.traces]
    made = reconstruct(findings.graph, traces, world.box, free=free, plates=findings.plates)
    truth = _compared(made, world.solid) if world.known else None
    seconds = time.perf_counter() - began
    summary = summarize(options, world, findings.ended, guard.cost, made, truth, findings.warnings, seconds)
    progress(_stand("writing", guard, findings))
    summary["files"], unwritten = write_model(folder, made)
    summary["warnings"] = [*summary["warnings"], *unwritten]
    report = _report(summary, options, world, made, findings, pictures, logbook.frames())
    with folder.writing("report.html") as path:
        write_report(path, report)
    folder.finish(summary)
    return summary


@contextmanager
def _owning_up(folder: RunFolder) -> Iterator[None]:
    """What goes wrong and should not is told as our bug, its details beside the recording."""
    try:
        yield
    except PalpateError:
        raise
    except Exception as error:
        if interrupt := interrupts.behind(error):
            raise interrupt from None
        raise bugs.told(error, folder.path) from error


def _explored(
    guard: Guard,
    options: ExploreOptions,
    world: World,
    logbook: Logbook,
    folder: RunFolder,
    progress: Watcher,
) -> tuple[Findings, list[FacePicture]]:
    """What exploration found until it ended, by itself or by a fault, which costs only the rest of it."""
    config = ExplorerConfig(
        feature=options.feature,
        max_touches=options.max_touches,
        max_minutes=options.max_minutes,
        policy=options.policy,
        seed=options.seed,
    )
    told = beside(world, options)
    explorer = Explorer(
        guard, world.box.ravel(), config, logbook.announce, tools(world), told, partial(draft, box=world.box)
    )
    found, patience = explorer.found, Patience()
    evidence = EvidenceLog(logbook.announce, world.box)
    try:
        for findings in explorer.run():
            evidence.note(findings)
            stand = _stand("exploring", guard, findings)
            progress(replace(stand, page=lambda: so_far.explored(found, world, logbook.frames())))
            known = len(findings.graph.faces) + len(findings.traces)
            thinking = not findings.hollow and options.policy == "closure"
            if thinking and patience.lost(guard.cost.touches, known, findings.open):
                found.hollow = True  # what would be so of a convex object leads nowhere
    except NotWritten:
        raise
    except PalpateError as error:
        found.ended = f"{FAULT}{str(error).splitlines()[0]}"
    except Exception as error:
        if interrupt := interrupts.behind(error):
            raise interrupt from None
        found.ended = f"{FAULT}{bugs.named(error)}"
        found.warnings.append(f"the fault is a bug in palpate; {bugs.BUG} has its details")
        folder.write_text(bugs.BUG, bugs.report_text(error))
    evidence.note(found)
    pictures = face_pictures(found.graph.faces, explorer.pad.skin.mosaic)
    for each in pictures:
        logbook.announce(PICTURE, told_picture(each))
    logbook.announce("ended", {"why": found.ended})
    return found, pictures


def _stand(phase: str, guard: Guard, findings: Findings) -> Progress:
    cost = guard.cost
    return Progress(
        phase,
        cost.touches,
        cost.strokes,
        cost.frames,
        cost.travel,
        cost.seconds,
        findings.open,
        findings.note,
    )


def _compared(made: Reconstruction, solid: Solid) -> Truth | None:
    if isinstance(made.assembly, NotClosed) or made.boundary is None:
        return None
    faces = LabeledFaces(made.boundary.brep.faces, made.boundary.of_triangle)
    return evaluate(made.assembly.solid, solid, model_faces=faces)


def _report(
    summary: dict[str, object],
    options: ExploreOptions,
    world: World,
    made: Reconstruction,
    findings: Findings,
    pictures: Sequence[FacePicture],
    frames: ReportFrames,
) -> RunReport:
    assembly, boundary = made.assembly, made.boundary
    if isinstance(assembly, NotClosed) or boundary is None:
        model = felt_faces(made.faces, made.contacts.points, made.face_of_contact)
    else:
        model = drawn(assembly.solid, boundary.of_triangle)
    return RunReport(
        summary=summary,
        settings=settings(options),
        model=model,
        truth=drawn_truth(world.part, world.solid) if world.known else None,
        off=off_truth(model, world.solid) if world.known else None,
        contacts=made.contacts.points,
        contact_face=made.face_of_contact,
        traces=[trace.points for trace, _ in findings.traces],
        frames=frames,
        pad_size=world.spec.array.size,
        housing_size=world.spec.housing.size,
        pictures=of_faces(pictures, made.faces),
    )

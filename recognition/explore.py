"""`palpate explore`: an object of unknown shape and pose, touched until its boundary is closed, becomes a model.

Load, explore, reconstruct, compare, write: the steps of one run.  The explorer sees the guard alone; the object
is asked again only when exploration is over.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

from exploration.devices.guard import Guard
from exploration.planning.explorer import Explorer, ExplorerConfig, Findings
from exploration.recordings.mcap import Recorder
from models.formats import mesh, openscad, step_out
from models.solid import Solid
from primitives.arrays import Ints
from primitives.errors import PalpateError
from recognition.assembly import NotClosed
from recognition.assembly.described import written_tree
from recognition.config import ExploreOptions, settings, to_toml
from recognition.logbook import Logbook
from recognition.patience import Patience
from recognition.progress import Progress
from recognition.reconstruct import Reconstruction, reconstruct
from recognition.report.page import write_report
from recognition.report.run_report import ReportFrames, ReportMesh, RunReport
from recognition.run_folder import RunFolder
from recognition.simulation import World, guarded, load_world
from recognition.summary import summarize
from recognition.truth import LabeledFaces, Truth, evaluate

_DRAWN_FACET = 0.02  # [mm] between a drawn facet and the surface that it stands for
Watcher = Callable[[Progress], None]
_log = logging.getLogger(__name__)


def run(options: ExploreOptions, progress: Watcher) -> dict[str, object]:
    """Explore, and leave a run folder; returns what `summary.json` holds.

    Bad input is refused before anything is written.  An interrupt leaves the recording whole and no summary.
    """
    began = time.perf_counter()
    world = load_world(options)
    folder = RunFolder.create(options.out, world.part.name, options.overwrite)
    folder.write_text("config.toml", to_toml(options, version("palpate"), world.resolved()))
    with Recorder(folder.recording) as recorder:
        logbook = Logbook(recorder)
        guard = guarded(world, options, logbook.observe)
        findings = _explored(guard, options, logbook, lambda p: progress(p.within(folder.path)))
    progress(_stand("reconstructing", guard, findings).within(folder.path))
    made = reconstruct(findings.graph, [trace for trace, _ in findings.traces], world.box)
    truth = _compared(made, world.solid)
    summary = summarize(
        options,
        world,
        findings.ended,
        guard.cost,
        made,
        truth,
        findings.warnings,
        time.perf_counter() - began,
    )
    progress(_stand("writing", guard, findings).within(folder.path))
    _write(folder, made)
    _write_step(folder, made, summary)
    report = _report(summary, options, world, made, findings, logbook.frames())
    with folder.writing("report.html") as path:
        write_report(path, report)
    folder.finish(summary)
    return summary


def _explored(guard: Guard, options: ExploreOptions, logbook: Logbook, progress: Watcher) -> Findings:
    """What exploration found until it ended, by itself or by a fault.

    A fault costs the rest of the exploration and not what was felt before it: an object that is not convex
    contradicts what the planner believes, and a contradiction may surface anywhere.
    """
    config = ExplorerConfig(feature=options.feature, max_touches=options.max_touches)
    explorer = Explorer(guard, np.asarray(options.workspace), config, logbook.announce)
    patience = Patience()
    try:
        for findings in explorer.run():
            progress(_stand("exploring", guard, findings))
            known = len(findings.graph.faces) + len(findings.traces)
            if patience.lost(guard.cost.touches, known, findings.open):
                raise PalpateError("the last touches taught nothing new; the object may not be convex")
    except Exception as error:
        if _interrupted(error):
            raise KeyboardInterrupt from None
        _log.warning("exploration ended by a fault", exc_info=not isinstance(error, PalpateError))
        fault = str(error) if isinstance(error, PalpateError) else f"{type(error).__name__}: {error}"
        explorer.found.ended = f"fault: {fault.splitlines()[0]}"
    logbook.announce("ended", {"why": explorer.found.ended})
    return explorer.found


def _interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: a compiled kernel hands it on as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


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


def _write(folder: RunFolder, made: Reconstruction) -> None:
    folder.write_contacts(made.contacts, made.face_of_contact)
    folder.write_json("brep.json", made.brep_json())
    if isinstance(made.assembly, NotClosed):
        return
    with folder.writing("model.csg") as path:
        openscad.write(written_tree(made.assembly), path)
    for name in ("model.stl", "model.glb"):
        with folder.writing(name) as path:
            mesh.save(made.assembly.solid, path)


def _write_step(folder: RunFolder, made: Reconstruction, summary: dict[str, Any]) -> None:
    """Where the extra for it is installed; a kernel that cannot is a warning, and the rest of the run stands."""
    if isinstance(made.assembly, NotClosed) or not step_out.available():
        return
    try:
        with folder.writing("model.step") as path:
            step_out.write(made.assembly.tree, path, name="model")
        summary["files"] = {**summary["files"], "step": "model.step"}
    except PalpateError as error:
        summary["warnings"] = [*summary["warnings"], f"no model.step: {error}"]


def _report(
    summary: dict[str, object],
    options: ExploreOptions,
    world: World,
    made: Reconstruction,
    findings: Findings,
    frames: ReportFrames,
) -> RunReport:
    assembly, boundary = made.assembly, made.boundary
    model = None
    if not isinstance(assembly, NotClosed) and boundary is not None:
        model = _drawn(assembly.solid, boundary.of_triangle)
    return RunReport(
        summary=summary,
        settings=settings(options),
        model=model,
        truth=_truth_to_draw(world),
        contacts=made.contacts.points,
        contact_face=made.face_of_contact,
        traces=[trace.points for trace, _ in findings.traces],
        frames=frames,
        pad_size=world.spec.array.size,
        housing_size=world.spec.housing.size,
    )


def _truth_to_draw(world: World) -> ReportMesh:
    """The object, in facets as coarse as a drawing allows where it was made from a tree."""
    solid = world.solid
    if world.part.csg is not None:
        solid = Solid.from_csg(world.part.csg, _DRAWN_FACET).placed(solid.pose)
    return _drawn(solid, LabeledFaces.of(solid).of_triangle)


def _drawn(solid: Solid, of_triangle: Ints) -> ReportMesh:
    return ReportMesh(solid.vertices, solid.triangles, of_triangle)

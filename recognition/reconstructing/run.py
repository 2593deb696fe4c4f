"""Read, find the surfaces, reconstruct, write: the steps of `palpate reconstruct`."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.toml_text import toml_lines
from recognition.assembly import NotClosed
from recognition.console import bugs, interrupts
from recognition.open_sides import open_ended
from recognition.reconstruct import Reconstruction, ReconstructOptions, reconstruct
from recognition.reconstructing.facing_alike import facing_alike
from recognition.reconstructing.facing_out import facing_out
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.scatter import scatter
from recognition.reconstructing.surfaces import surfaces
from recognition.report.drawn import drawn
from recognition.report.felt import felt_faces
from recognition.report.page import write_report
from recognition.report.run_report import EMPTY_FRAMES, RunReport
from recognition.running.folder import RunFolder
from recognition.running.progress import Progress
from recognition.running.summary import counted
from recognition.running.writing import write_model
from recognition.sources import Source, read_source
from recognition.sources.places import one_a_place

_LEAST = 4  # contacts, without which nothing has a volume
_ROOM = 0.5  # of the contacts' extent, by which the body may reach past them
Watcher = Callable[[Progress], None]


def run(options: ReconstructSourceOptions, watch: Watcher) -> dict[str, Any]:
    """Leave a run folder; returns what `summary.json` holds.

    An interrupt ends it at once, but for files that are being written: these are made whole.
    """
    began = time.perf_counter()
    watch(Progress("reading", note=str(options.source)))
    source = read_source(options.source)
    if source.kind == "contacts" and len(source.contacts) < _LEAST:
        held = len(source.contacts)
        raise PalpateError(
            f"{options.source} holds {held} contact{'s' * (held != 1)}; at least {_LEAST} are needed"
        )
    folder = RunFolder.create(options.out, source.name, options.overwrite)
    try:
        return _run(options, source, folder, watch, began)
    except Exception as error:
        if interrupt := interrupts.behind(error):
            raise interrupt from None
        raise bugs.told(error, folder.path) from error


def _run(
    options: ReconstructSourceOptions, source: Source, folder: RunFolder, watch: Watcher, began: float
) -> dict[str, Any]:
    felt = facing_out(_with_scatter(facing_alike(_by_place(source)), options))
    sigma = _typical(felt)
    head = toml_lines({"version": version("palpate"), "command": "reconstruct"})
    settings = [*head, "", "[settings]", *toml_lines(options.as_settings())]
    resolved = ["", "[resolved]", *toml_lines({"contact_sigma_mm": sigma, "contacts": len(felt.contacts)})]
    with interrupts.held():
        folder.write_text("config.toml", "\n".join([*settings, *resolved]) + "\n")
    watch(Progress("reconstructing", note=f"{len(felt.contacts)} contacts", folder=folder.path))
    made = _made(felt)
    summary = _summary(options, felt, made, time.perf_counter() - began)
    watch(Progress("writing", folder=folder.path))
    with interrupts.held():
        summary["files"], unwritten = write_model(folder, made)
        summary["warnings"] = [*summary["warnings"], *unwritten]
        interrupts.checkpoint()
        with folder.writing("report.html") as path:
            write_report(path, _report(options, summary, made))
        interrupts.checkpoint()
        folder.finish(summary)
    return summary


def _by_place(source: Source) -> Source:
    """With one contact a place, where nothing but contacts is known: faces are told by how dense these lie."""
    if source.kind != "contacts":
        return source
    placed, read = one_a_place(source.contacts), len(source.contacts)
    if placed is source.contacts:
        return source
    told = f"{read - len(placed)} of {read} contacts were read where another was, and count once with it"
    return replace(source, contacts=placed, warnings=(*source.warnings, told))


def _with_scatter(source: Source, options: ReconstructSourceOptions) -> Source:
    """With the contacts' sigma as told or measured, else as their faces say."""
    if options.contact_sigma is None and not source.measured_sigma:
        return source.with_sigma(scatter(source.contacts))
    return source.with_sigma(options.contact_sigma)


def _made(source: Source) -> Reconstruction:
    """From what an exploration made of its contacts, where there was one; else from the contacts alone."""
    if (told := source.explored) is not None:
        return reconstruct(told.graph, told.traces, told.box, free=told.free, plates=told.plates)
    graph, box = surfaces(source.contacts), box_around(source.contacts)
    made = reconstruct(graph, [], box)
    # a scan shows its sides to their ends, so what no face ends is cut off where contacts end, however near
    return reconstruct(graph, [], box, ReconstructOptions(run_on=0.0)) if open_ended(made.assembly) else made


def box_around(contacts: Contacts) -> Floats:
    """(2, 3) [mm] the contacts with room for the body behind them."""
    if not len(contacts):
        return np.array([[-1.0] * 3, [1.0] * 3])
    low, high = contacts.points.min(axis=0), contacts.points.max(axis=0)
    room = _ROOM * float(np.linalg.norm(high - low)) + 1.0
    return np.stack([low - room, high + room])


def _summary(
    options: ReconstructSourceOptions, source: Source, made: Reconstruction, seconds: float
) -> dict[str, Any]:
    assembly = None if isinstance(made.assembly, NotClosed) else made.assembly
    felt = source.felt
    ended = "closed" if made.closed else "no closed body"
    if source.explored is not None and ended == "closed":
        ended = source.explored.ended
    return {
        "command": "reconstruct",
        "version": version("palpate"),
        "part": source.name,
        "source": str(source.path),
        "sensor": felt.sensor,
        "seed": options.seed,
        "closed": ended == "closed",
        "ended": ended,
        "contacts": len(source.contacts),
        "contact_sigma_mm": _typical(source),
        "touches": felt.touches,
        "strokes": felt.strokes,
        "frames": felt.frames,
        "travel_mm": felt.travel,
        "device_seconds": felt.seconds,
        "wall_seconds": seconds,
        "faces": made.faces,
        "edges": made.edges,
        "primitives": made.primitives,
        "regularities": made.regularities,
        "volume_mm3": None if assembly is None else assembly.solid.volume,
        "csg": None if assembly is None else {"leaves": sum(1 for _ in assembly.tree.leaves())},
        "truth": None,
        "warnings": counted([*source.warnings, *made.warnings]),
        "files": {},
    }


def _typical(source: Source) -> float:
    return float(np.median(source.contacts.sigma)) if len(source.contacts) else 0.0


def _report(options: ReconstructSourceOptions, summary: dict[str, Any], made: Reconstruction) -> RunReport:
    if isinstance(made.assembly, NotClosed) or made.boundary is None:
        model = felt_faces(made.faces, made.contacts.points, made.face_of_contact)
    else:
        solid = made.assembly.solid
        model = drawn(solid, made.boundary.of_triangle)
    shown = _thinned(len(made.contacts))
    return RunReport(
        summary=summary,
        settings=options.as_settings(),
        model=model,
        contacts=made.contacts.points[shown],
        contact_face=made.face_of_contact[shown],
        frames=EMPTY_FRAMES,
        pad_size=(0.0, 0.0),
        housing_size=(0.0, 0.0, 0.0),
    )


_DRAWN = 20_000  # contacts that a page shows


def _thinned(count: int) -> np.ndarray:
    return np.unique(np.linspace(0, max(count - 1, 0), min(count, _DRAWN)).astype(np.int64))

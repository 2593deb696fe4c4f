"""A run's page written anew from its folder: what was felt, what was found, and what the recording holds.

The object and the library's models are read again from where the run's settings say they were; where they are gone
the page does without.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from models.library import Library
from models.part import Part, load_part
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError
from primitives.pose import from_quaternion
from recognition.report.against import drawn_truth, off_truth
from recognition.report.drawn import drawn
from recognition.report.page import write_report
from recognition.report.recorded import Recorded, recorded, resolved_specs
from recognition.report.relabeled import labeled_mesh
from recognition.report.run_report import ReportMesh, RunReport
from recognition.report.skin_pictures import of_faces
from recognition.report.suite_page import suite_html
from recognition.running.folder import RECORDING, SUMMARY, RunFolder
from recognition.truth import LabeledFaces

PAGE = "report.html"
_TAIL = ("sigma", "face")


def rewrite(run: Path) -> Path:
    """Write the page of a run, or of a suite, again; its path."""
    summary = _summary(run)
    folder = RunFolder(run)
    try:
        if summary["command"] == "experiment":
            folder.write_text(PAGE, suite_html(summary))
        else:
            report = _report(run, summary)
            with folder.writing(PAGE) as path:
                write_report(path, report)
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise PalpateError(f"{run / SUMMARY} is not as palpate writes it ({error}); run it again") from error
    return run / PAGE


def _summary(run: Path) -> dict[str, Any]:
    if not run.is_dir():
        raise PalpateError(f"{run} is no folder; give the folder of a run")
    path = run / SUMMARY
    if not path.is_file():
        raise PalpateError(f"{run} holds no {SUMMARY}; give the folder of a run that has ended")
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise PalpateError(f"cannot read {path}; run it again") from error
    if not isinstance(told, dict) or not isinstance(told.get("command"), str):
        raise PalpateError(f"{path} is no run's summary; give the folder of a run")
    return told


def so_far(run: Path) -> RunReport:
    """What is recorded of a run that goes on, or that was ended before it had a page."""
    settings, resolved = _config(run / "config.toml")
    told = recorded(run / RECORDING, resolved_specs(resolved))
    name = Path(str(settings.get("part") or run.name)).stem
    return RunReport(
        summary={"part": name, "sensor": None, "ended": "not yet"},
        settings=settings,
        model=None,
        contacts=np.empty((0, 3)),
        contact_face=np.empty(0, dtype=np.int64),
        frames=told.frames,
        pad_size=told.pad,
        housing_size=told.housing,
        traces=told.traces,
    )


def _report(run: Path, summary: dict[str, Any]) -> RunReport:
    points, faces = _contacts(run / "contacts.csv")
    settings, resolved = _config(run / "config.toml")
    specs = resolved_specs(resolved)
    told = recorded(run / RECORDING, specs) if (run / RECORDING).is_file() else Recorded()
    trace = np.array(summary.get("trace") or np.empty((0, 3)), dtype=float).reshape(-1, 3)
    model = labeled_mesh(run / "model.stl", points, faces)
    if summary["command"] == "identify":
        model = _decided(summary, settings)
    part = _touched(settings, resolved)
    return RunReport(
        summary=summary,
        settings=settings,
        model=model,
        contacts=points,
        contact_face=faces,
        frames=told.frames,
        pad_size=told.pad,
        housing_size=told.housing,
        truth=None if part is None else drawn_truth(part, part.solid),
        off=None if part is None else off_truth(model, part.solid),
        traces=[*told.traces, *([trace] if len(trace) > 1 else [])],
        pictures=of_faces(told.pictures, summary.get("faces") or []),
    )


def _config(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The settings, and what they came to."""
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}, {}
    settings, resolved = told.get("settings", {}), told.get("resolved", {})
    return (settings if isinstance(settings, dict) else {}), (resolved if isinstance(resolved, dict) else {})


def _touched(settings: dict[str, Any], resolved: dict[str, Any]) -> Part | None:
    """The part at its pose; None off simulation, and where its file is gone."""
    try:
        pose = pose_of(resolved["world_from_part"])
        told = {key: settings[key] for key in ("units", "scale", "body", "facets") if key in settings}
        part = load_part(settings["part"], **told)
    except (KeyError, TypeError, PalpateError):
        return None
    return replace(part, solid=part.solid.placed(pose))


def _decided(summary: dict[str, Any], settings: dict[str, Any]) -> ReportMesh | None:
    """The object of the library that was decided for, where it was believed to be; None where its file is gone."""
    name = str(summary.get("decision"))
    pose = next((c["pose"] for c in summary.get("candidates") or [] if c["name"] == name and c["pose"]), None)
    if pose is None:
        return None
    try:
        folder = settings.get("library")
        solid = load_part(name).solid if folder is None else Library.open(Path(folder))[name].solid
    except (KeyError, PalpateError):
        return None
    solid = solid.placed(pose_of(pose))
    return drawn(solid, LabeledFaces.of(solid).of_triangle)


def pose_of(told: dict[str, Any]) -> Floats:
    """(4, 4) from a pose as files write it."""
    return from_quaternion(np.asarray(told["quaternion_wxyz"]), np.asarray(told["translation_mm"]))


def _contacts(path: Path) -> tuple[Floats, Ints]:
    """(n, 3) points and the face of each."""
    if not path.is_file():
        return np.empty((0, 3)), np.empty(0, dtype=np.int64)
    try:
        head, *rows = path.read_text(encoding="utf-8").splitlines()
        if not head.startswith("x,y,z") or not head.endswith(",".join(_TAIL)):
            raise ValueError("its columns are others")
        cells = [row.split(",") for row in rows]
        points = np.array([[float(x) for x in row[:3]] for row in cells]).reshape(-1, 3)
        faces = np.array([int(row[-1]) for row in cells], dtype=np.int64)
    except (OSError, ValueError, IndexError) as error:
        raise PalpateError(f"cannot read {path} ({error}); run it again") from error
    return points, faces

"""A run's page written anew from its folder: what was felt, what was found, and what the recording holds.

A face of the mesh gets the number that most contacts on it have.  The truth and the library are not in a folder,
so a page written anew shows neither.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from models.part import load_part
from models.rays.triangle_tree import TriangleTree
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError
from recognition.report.page import write_report
from recognition.report.recorded import recorded_frames
from recognition.report.run_report import EMPTY_FRAMES, ReportFrames, ReportMesh, RunReport
from recognition.report.suite_page import suite_html
from recognition.run_folder import RECORDING, SUMMARY, RunFolder

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


def _report(run: Path, summary: dict[str, Any]) -> RunReport:
    points, faces = _contacts(run / "contacts.csv")
    frames: ReportFrames = EMPTY_FRAMES
    pad: tuple[float, float] = (0.0, 0.0)
    housing: tuple[float, float, float] = (0.0, 0.0, 0.0)
    if (run / RECORDING).is_file():
        frames, pad, housing = recorded_frames(run / RECORDING)
    trace = np.array(summary.get("trace") or np.empty((0, 3)), dtype=float).reshape(-1, 3)
    return RunReport(
        summary=summary,
        settings=_settings(run / "config.toml"),
        model=_model(run / "model.stl", points, faces),
        contacts=points,
        contact_face=faces,
        frames=frames,
        pad_size=pad,
        housing_size=housing,
        traces=[trace] if len(trace) > 1 else [],
    )


def _settings(path: Path) -> dict[str, Any]:
    try:
        told = tomllib.loads(path.read_text(encoding="utf-8")).get("settings", {})
    except (OSError, ValueError):
        return {}
    return told if isinstance(told, dict) else {}


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


def _model(path: Path, points: Floats, faces: Ints) -> ReportMesh | None:
    if not path.is_file():
        return None
    solid = load_part(path, units="mm").solid
    vertices, triangles = solid.vertices, solid.triangles
    smooth = _smooth_parts(vertices, triangles)
    label = np.full(len(triangles), -1)
    told = faces >= 0
    if told.any():
        landed = smooth[TriangleTree(vertices, triangles).nearest(points[told]).triangle]
        for part in np.unique(landed):
            label[smooth == part] = np.bincount(faces[told][landed == part]).argmax()
    return ReportMesh(vertices, triangles, label)


_CREASE = np.cos(np.radians(15.0))  # of the angle between triangles of one smooth part


def _smooth_parts(vertices: Floats, triangles: Ints) -> Ints:
    """(t,) which smooth part of the surface each triangle belongs to."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = len(triangles)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    sides = np.sort(
        np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1
    )
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    owner, sides = order % count, sides[order]
    twins = np.flatnonzero((sides[1:] == sides[:-1]).all(axis=1))
    i, j = owner[twins], owner[twins + 1]
    flat = np.einsum("ij,ij->i", normals[i], normals[j]) > _CREASE
    joined = coo_matrix((np.ones(flat.sum()), (i[flat], j[flat])), shape=(count, count))
    parts: Ints = connected_components(joined, directed=False)[1].astype(np.int64)
    return parts

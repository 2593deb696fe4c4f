"""What exploration makes of what it feels, written into the recording as it does, and read back.

Frames perceived anew would come out a little otherwise than where a pad could look closer, and nothing in a cloud
of contacts says which stroke a face came from.  So after every move the recording gets the contacts that are new,
the faces with the contacts of each, and the places that an array was in and the outlines of plates, all as
numbers that give the same model again: from a whole run, and from what a kill has left of one.

    contacts: {"rows": [[x, y, z, nx, ny, nz, sigma, normal_sigma, touch, stroke, sensor], ...]}    what is new
    faces:    {"faces": [{"id", "shape", ..., "contacts": [[first, last], ...]}], "free_mm": ...,
               "plates": ...}                                                                       what now holds
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from exploration.planning.touching.findings import Findings
from exploration.recordings.mcap import events
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import Fit, NoFit
from primitives.patch_graph import Face, MergeOptions, PatchGraph
from primitives.plate import Plate
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

CONTACTS, FACES, TRACE, ENDED = "contacts", "faces", "trace", "ended"
CUT_SHORT = "cut short"  # where the recording does not say why it ended
_SHAPES: dict[str, Callable[..., Shape]] = {s.kind: s for s in (Plane, Cylinder, Cone, Sphere, Torus)}


@dataclass(frozen=True)
class Explored:
    """What an exploration had concluded when its recording ends."""

    graph: PatchGraph
    traces: tuple[EdgeTrace, ...]
    box: Floats  # (2, 3) the workspace [mm]
    free: Floats | None  # (n, 3) places [mm] that an array was in
    plates: tuple[Plate, ...]
    ended: str  # why

    @property
    def contacts(self) -> Contacts:
        """All of them, face by face, and last those of none, each as far as it is to be believed."""
        faces = sorted(self.graph.faces, key=lambda face: isinstance(face.fit, NoFit))
        return self.graph.believed(Contacts.concatenate([face.contacts for face in faces]))


class EvidenceLog:
    """Tells `announce` what is new in the findings of one exploration of a (2, 3) workspace `box` [mm]."""

    def __init__(self, announce: Callable[[str, Mapping[str, object]], None], box: Floats) -> None:
        self._announce, self._box = announce, np.reshape(box, (2, 3)).tolist()
        self._row: dict[bytes, int] = {}
        self._told: tuple[Face, ...] | None = None
        self._places = self._traces = 0

    def note(self, found: Findings) -> None:
        """Write down what changed since the last time."""
        for trace, _ in found.traces[self._traces :]:
            told = {
                "points_mm": trace.points.tolist(),
                "normals": trace.normals.tolist(),
                "closed": trace.closed,
            }
            self._announce(TRACE, told)
        self._traces = len(found.traces)
        if self._told is found.graph.faces and self._places == len(found.inside):
            return
        fresh: list[list[float | None]] = []
        faces = [_told(face, self._rows(face.contacts, fresh)) for face in found.graph.faces]
        if fresh:
            self._announce(CONTACTS, {"rows": fresh})
        free = np.concatenate([np.empty((0, 3)), *found.inside]).tolist()
        plates = [_told_plate(plate) for plate in found.plates]
        scatter = found.graph.options.scatter
        told = {
            "faces": faces,
            "scatter_mm": scatter,
            "free_mm": free,
            "plates": plates,
            "workspace_mm": self._box,
        }
        self._announce(FACES, told)
        self._told, self._places = found.graph.faces, len(found.inside)

    def _rows(self, contacts: Contacts, fresh: list[list[float | None]]) -> Ints:
        """(n,) numbers of contacts in the recording; of those that are new the rows are put to `fresh`."""
        table = _table(contacts)
        out = []
        for row in table:
            key = row.tobytes()
            if key not in self._row:
                self._row[key] = len(self._row)
                fresh.append([value if np.isfinite(value) else None for value in row.tolist()])
            out.append(self._row[key])
        return np.array(out, dtype=np.int64)


def explored(path: Path) -> Explored | None:
    """What the exploration of an episode had concluded at its end, or when it was cut short; None of others."""
    told: dict[str, list[Mapping[str, Any]]] = {kind: [] for kind in (CONTACTS, FACES, TRACE, ENDED)}
    for event in events(path):
        if event.kind in told:
            told[event.kind].append(event.detail)
    if not told[FACES]:
        return None
    try:
        rows = [row for detail in told[CONTACTS] for row in detail["rows"]]
        contacts = _contacts(np.array(rows, dtype=float).reshape(-1, 11))
        last = told[FACES][-1]
        faces = tuple(_face(face, contacts) for face in last["faces"])
        traces = tuple(_trace(detail) for detail in told[TRACE])
        free = np.array(last["free_mm"], dtype=float).reshape(-1, 3)
        plates = tuple(_plate(plate) for plate in last.get("plates", ()))
        box = np.array(last["workspace_mm"], dtype=float).reshape(2, 3)
        scatter = float(last.get("scatter_mm", 0.0))
        ended = str(told[ENDED][-1]["why"]) if told[ENDED] else CUT_SHORT
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise PalpateError(f"{path}: its faces are not as this version writes them ({error})") from None
    options = MergeOptions(scatter=scatter)
    return Explored(
        PatchGraph(faces, options=options), traces, box, free if len(free) else None, plates, ended
    )


def _table(c: Contacts) -> Floats:
    columns = (c.points, c.normals, c.sigma, c.normal_sigma, c.touch, c.stroke, c.sensor)
    return np.ascontiguousarray(np.column_stack(columns).astype(float))


def _contacts(table: Floats) -> Contacts:
    touch, stroke, sensor = table[:, 8:].T.astype(np.int64)
    return Contacts.of(table[:, :3], table[:, 3:6], table[:, 6], table[:, 7], touch, stroke, sensor)


def _told(face: Face, rows: Ints) -> dict[str, object]:
    told: dict[str, object] = {"id": face.id, "shape": None, "contacts": _runs(rows)}
    if isinstance(face.fit, NoFit):
        return told | {"why": face.fit.reason}
    fit, shape = face.fit, face.fit.shape
    strays = np.flatnonzero(~fit.inliers).tolist()
    parameters = {field.name: np.asarray(getattr(shape, field.name)).tolist() for field in fields(shape)}
    return told | {
        "shape": fit.kind,
        "convex": fit.convex,
        "parameters": parameters,
        "covariance": fit.covariance.tolist(),
        "rms_mm": fit.rms,
        "chi2": fit.chi2,
        "dof": fit.dof,
        "converged": fit.converged,
        "strays": strays,
    }


def _face(told: Mapping[str, Any], contacts: Contacts) -> Face:
    rows = np.concatenate([np.empty(0, dtype=np.int64), *(np.arange(a, b + 1) for a, b in told["contacts"])])
    mine = contacts.select(rows)
    if told["shape"] is None:
        return Face(int(told["id"]), NoFit(str(told["why"])), mine)
    kept: dict[str, Any] = {
        name: frozen(np.array(value)) if isinstance(value, list) else float(value)
        for name, value in told["parameters"].items()
    }
    inside = np.ones(len(mine), dtype=bool)
    inside[told["strays"]] = False
    shape = _SHAPES[told["shape"]](**kept)
    covariance, inliers = frozen(np.array(told["covariance"])), frozen(inside, bool)
    counts = (float(told["rms_mm"]), float(told["chi2"]), int(told["dof"]))
    fit = Fit(shape, covariance, *counts, inliers, bool(told["converged"]), bool(told["convex"]))
    return Face(int(told["id"]), fit, mine)


def _told_plate(plate: Plate) -> dict[str, object]:
    return {
        "pose": plate.pose.tolist(),
        "thick_mm": plate.thick,
        "there_mm": [rim.tolist() for rim in plate.there],
        "missing_mm": [rim.tolist() for rim in plate.missing],
        "lies": plate.lies,
        "step": plate.step,
    }


def _plate(told: Mapping[str, Any]) -> Plate:
    there, missing = (
        tuple(frozen(np.array(rim, dtype=float).reshape(-1, 2)) for rim in told[kind])
        for kind in ("there_mm", "missing_mm")
    )
    placed, thick = frozen(np.array(told["pose"], dtype=float)), float(told["thick_mm"])
    return Plate(placed, thick, there, missing, bool(told.get("lies")), bool(told.get("step")))


def _runs(rows: Ints) -> Sequence[tuple[int, int]]:
    """First and last of every run of consecutive numbers, in order."""
    if not len(rows):
        return []
    breaks = [0, *(np.flatnonzero(np.diff(rows) != 1) + 1).tolist(), len(rows)]
    return [(int(rows[a]), int(rows[b - 1])) for a, b in pairwise(breaks)]


def _trace(told: Mapping[str, Any]) -> EdgeTrace:
    points = np.array(told["points_mm"], dtype=float).reshape(-1, 3)
    normals = np.array(told.get("normals", np.full_like(points, np.nan)), dtype=float).reshape(-1, 3)
    none = frozen(np.full_like(points, np.nan))
    sigma = frozen(np.zeros(len(points)))
    return EdgeTrace(frozen(points), none, frozen(normals), sigma, bool(told.get("closed", False)), 0, 0)

"""A report's arrays as the page reads them: little-endian typed arrays in base64, thinned to stay small."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from primitives.arrays import Floats, Ints
from recognition.report.belief import belief_payload
from recognition.report.growth import felt_from
from recognition.report.run_report import Deviation, ReportFrames, ReportMesh, RunReport
from recognition.report.tables import without_body


@dataclass(frozen=True)
class PayloadLimits:
    """What a page may hold, for a file below 5 MB."""

    frames: int = 1500
    taxels: int = 800_000  # over all frames, one byte each
    contacts: int = 30_000
    trace_points: int = 10_000
    outline: int = 8_000  # segments per mesh; the longest stay
    triangles: int = 30_000  # per mesh; a larger one is left out, and the page says so


def payload(report: RunReport, limits: PayloadLimits | None = None) -> dict[str, Any]:
    """What the page's script unpacks."""
    limits = limits or PayloadLimits()
    model, truth = (_small_enough(mesh, limits) for mesh in (report.model, report.truth))
    kept = _kept_frames(report.frames, limits)
    faces: Any = report.summary.get("faces") or []
    return {
        "shapes": {str(face["id"]): face["shape"] for face in faces},
        "model": _mesh(model, limits),
        "truth": _mesh(truth, limits),
        "off": _off(report.off, limits),
        "contacts": _contacts(report, kept, limits),
        "traces": _traces(report, kept, limits),
        "belief": belief_payload(report.summary.get("history")),
        "frames": _frames(report.frames, kept),
        "pad": list(report.pad_size),
        "housing": list(report.housing_size),
        "bounds": _bounds(report),
    }


def left_out(report: RunReport, limits: PayloadLimits | None = None) -> list[str]:
    """What the page does not show, in words."""
    limits = limits or PayloadLimits()
    return [
        f"the {name} mesh has {len(mesh.triangles)} triangles and is not drawn here"
        for name, mesh in (("model's", report.model), ("truth's", report.truth))
        if mesh is not None and _small_enough(mesh, limits) is None
    ]


def _small_enough(mesh: ReportMesh | None, limits: PayloadLimits) -> ReportMesh | None:
    return mesh if mesh is not None and len(mesh.triangles) <= limits.triangles else None


def _mesh(mesh: ReportMesh | None, limits: PayloadLimits) -> Mapping[str, Any] | None:
    if mesh is None:
        return None
    return {
        "vertices": packed(mesh.vertices, "f4"),
        "triangles": packed(mesh.triangles, "i4"),
        "face": packed(mesh.face, "i4"),
        "edges": packed(_outline(mesh, limits.outline), "f4"),
    }


def _off(off: Deviation | None, limits: PayloadLimits) -> Mapping[str, Any] | None:
    if off is None or _small_enough(off.mesh, limits) is None:
        return None
    return {
        "vertices": packed(off.mesh.vertices, "f4"),
        "triangles": packed(off.mesh.triangles, "i4"),
        "face": packed(off.mesh.face, "i4"),
        "distance": packed(off.distance, "f4"),
        "scale": off.scale,
    }


def _contacts(report: RunReport, kept: Ints, limits: PayloadLimits) -> dict[str, Any]:
    """Points in the order in which they come, and the frame that each comes with."""
    chosen = _thinned(len(report.contacts), limits.contacts)
    points = report.contacts[chosen]
    order, born = _in_order(points, report, kept)
    return {
        "points": packed(points[order], "f4"),
        "face": packed(report.contact_face[chosen][order], "f4"),
        "from": packed(born, "i4"),
    }


def _traces(report: RunReport, kept: Ints, limits: PayloadLimits) -> dict[str, Any]:
    """Pieces of every trace in the order in which they come, and the frame that each comes with."""
    segments = _trace_segments(report, limits)
    order, born = _in_order(segments[:, 1], report, kept)
    return {"segments": packed(segments[order], "f4"), "from": packed(born, "i4")}


def _in_order(points: Floats, report: RunReport, kept: Ints) -> tuple[Ints, Ints]:
    frames = report.frames
    born = felt_from(points, frames.poses[kept], frames.touch[kept] >= 0, report.pad_size)
    order = np.argsort(born, kind="stable")
    return order, born[order]


def _outline(mesh: ReportMesh, most: int) -> Floats:
    """(k, 2, 3) the mesh edges between two faces, or on a rim."""
    if not len(mesh.triangles):
        return np.empty((0, 2, 3))
    t = mesh.triangles
    pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
    face = np.tile(mesh.face, 3)
    order = np.lexsort((face, pairs[:, 1], pairs[:, 0]))
    pairs, face = pairs[order], face[order]
    first = np.flatnonzero(np.r_[True, (pairs[1:] != pairs[:-1]).any(axis=1)])
    last = np.r_[first[1:], len(pairs)] - 1
    outer = first[(first == last) | (face[first] != face[last])]
    segments: Floats = mesh.vertices[pairs[outer]]
    if len(segments) > most:
        length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
        segments = segments[np.argsort(-length, kind="stable")[:most]]
    return segments


def _kept_frames(frames: ReportFrames, limits: PayloadLimits) -> Ints:
    count, rows, columns = frames.counts.shape
    return _thinned(count, min(limits.frames, limits.taxels // max(1, rows * columns)))


def _frames(frames: ReportFrames, kept: Ints) -> dict[str, Any]:
    count, rows, columns = frames.counts.shape
    counts = frames.counts[kept]
    low, high = (float(np.quantile(counts, 0.02)), float(counts.max())) if counts.size else (0.0, 1.0)
    levels = np.clip((counts - low) / max(high - low, 1e-9), 0.0, 1.0) * 255.0
    lines = [
        np.asarray(frames.lines[i], dtype=float).reshape(-1, 2) if frames.lines else np.empty((0, 2))
        for i in kept
    ]
    starts = np.concatenate([[0], np.cumsum([len(line) for line in lines])])
    return {
        "count": len(kept),
        "shape": [len(kept), rows, columns],
        "times": packed(frames.times[kept] - (frames.times[0] if count else 0.0), "f4"),
        "poses": packed(np.swapaxes(frames.poses[kept], 1, 2), "f4"),
        "counts": packed(np.rint(levels), "u1"),
        "forces": packed(frames.forces[kept], "f4"),
        "touch": packed(frames.touch[kept], "i4"),
        "lines": packed(np.concatenate([*lines, np.empty((0, 2))]), "f4"),
        "lineStart": packed(starts, "i4"),
    }


def _trace_segments(report: RunReport, limits: PayloadLimits) -> Floats:
    """(k, 2, 3) consecutive points of every trace."""
    total = sum(map(len, report.traces))
    pieces = [np.empty((0, 2, 3))]
    for trace in report.traces:
        kept = trace[_thinned(len(trace), max(2, len(trace) * limits.trace_points // max(total, 1)))]
        if len(kept) > 1:
            pieces.append(np.stack([kept[:-1], kept[1:]], axis=1))
    return np.concatenate(pieces)


def _bounds(report: RunReport) -> dict[str, Any]:
    """The ball that the camera looks at: what is drawn, and what was touched, or the pad's way."""
    drawn = report.truth if without_body(report.summary) or report.model is None else report.model
    clouds = [drawn.vertices if drawn is not None else report.contacts, report.contacts]
    points = np.concatenate([cloud for cloud in clouds if len(cloud)] or [report.frames.poses[:, :3, 3]])
    if not len(points):
        return {"center": [0.0, 0.0, 0.0], "radius": 50.0}
    low, high = points.min(axis=0), points.max(axis=0)
    radius = max(float(np.linalg.norm(high - low)) / 2.0, 1.0)
    return {"center": ((low + high) / 2.0).tolist(), "radius": radius}


def _thinned(count: int, most: int) -> Ints:
    """Indices of at most `most` of `count` rows, evenly spread, first and last among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(np.int64))


def packed(values: Any, kind: str) -> dict[str, str]:
    """An array as little-endian base64 of a numpy kind."""
    data = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<"))
    return {"type": kind, "base64": base64.b64encode(data.tobytes()).decode()}

"""A felt frame as the JSON of `palpate frames`: lengths in mm, angles in degrees, a missing unit as null."""

from math import degrees, isfinite, sqrt

from exploration.recordings.recording import Pad
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.local_surface import LocalSurface
from recognition.frames.felt import Felt

Row = dict[str, object]


def frame_row(felt: Felt, pad: Pad) -> Row:
    """One entry of `frames`."""
    touch = felt.touch
    known = pad.spec is not None
    row: Row = {
        "index": felt.index,
        "time_ms": round(1000.0 * felt.time, 3) if isfinite(felt.time) else None,
        "pad": felt.pad,
        "kind": touch.kind,
        "kinds": {kind: round(float(share), 4) for kind, share in touch.kinds.items()},
        "lines": [_line(line) for line in touch.lines],
        "arcs": [_arc(arc) for arc in felt.arcs],
        "curvatures_per_mm": _curvatures(touch.surface) if known else None,
        "curvature_sigma_per_mm": _sigma(touch.surface) if known else None,
        "force_n": round(touch.force, 4) if known else None,
    }
    return {**row, "unreadable": felt.unreadable} if felt.unreadable else row


def pad_row(index: int, pad: Pad, noise: float, plateau: float) -> Row:
    """One entry of `pads`."""
    return {
        "pad": index,
        "name": pad.array.name,
        "rows": pad.array.rows,
        "columns": pad.array.columns,
        "pitch_mm": list(pad.array.pitch) if not pad.assumed_pitch else None,
        "absent": int(pad.absent.sum()),
        "noise_counts": round(noise, 3),
        "plateau_counts": round(plateau, 1),
    }


def _line(line: Line) -> Row:
    angle, offset = sqrt(float(line.covariance[0, 0])), sqrt(float(line.covariance[1, 1]))
    return {
        "angle_deg": degrees(line.angle),
        "offset_mm": line.offset,
        "angle_sigma_deg": degrees(angle),
        "offset_sigma_mm": offset,
        "length_mm": line.length,
        "material_side": line.material_side,
    }


def _arc(arc: Arc) -> Row:
    return {
        "center_mm": arc.center.tolist(),
        "radius_mm": arc.radius,
        "radius_sigma_mm": arc.radius_sigma,
        "span_deg": degrees(arc.span),
        "material_inside": arc.material_inside,
    }


def _curvatures(surface: object) -> list[float]:
    if isinstance(surface, LocalSurface) and surface.curved:
        return [round(float(value), 6) for value in surface.principal[0]]
    return [0.0, 0.0]


def _sigma(surface: object) -> float | None:
    """Of the greater curvature; null where none was needed."""
    if isinstance(surface, LocalSurface) and surface.curved:
        return round(sqrt(float(surface.curvature_covariance[[0, 2], [0, 2]].max())), 6)
    return None

"""Reading `brep.json` back: the boundary that `Brep.as_json` wrote, or one line that says what it lacks.

The file is not trusted: every field is converted, and the invariants are checked before anything is returned.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import numpy as np

from models.brep import Brep, Curve, Edge, Face, Kind
from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.shapes import KINDS, Cone, Cylinder, Plane, Shape, Sphere, Torus


def load_brep(path: str | Path) -> Brep:
    """The boundary in a file."""
    name = Path(path).name
    try:
        fields = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise PalpateError(f"cannot read {name}: {error.strerror}; give a brep.json") from None
    except (ValueError, RecursionError):
        raise PalpateError(f"{name} is not JSON; give a brep.json that palpate wrote") from None
    try:
        return brep_from_json(fields)
    except PalpateError as error:
        raise PalpateError(f"{name}: {error}") from None


def brep_from_json(fields: Any) -> Brep:
    """The boundary that `Brep.as_json` wrote."""
    try:
        brep = Brep(
            tuple(_face(face) for face in fields["faces"]),
            tuple(_edge(edge) for edge in fields["edges"]),
            _points(fields["vertices_mm"]),
            int(fields.get("shells", 1)),
            int(fields.get("genus", 0)),
        )
        wrong = brep.check()
    except KeyError as missing:
        raise PalpateError(f"not a boundary: a field {missing} is missing; write it again") from None
    except (AttributeError, IndexError, OverflowError, TypeError, ValueError, PalpateError) as error:
        raise PalpateError(f"not a boundary: {' '.join(str(error).split())}; write it again") from None
    if wrong:
        raise PalpateError(f"not a closed boundary: {wrong[0]}; write it again")
    return brep


def _face(fields: dict[str, Any]) -> Face:
    length, width = fields["extent_mm"]
    return Face(
        int(fields["id"]),
        _shape(str(fields["shape"]), fields["parameters"]),
        bool(fields["convex"]),
        float(fields["area_mm2"]),
        (float(length), float(width)),
        tuple(tuple(int(edge) for edge in loop) for loop in fields["loops"]),
        int(fields.get("handles", 0)),
    )


def _edge(fields: dict[str, Any]) -> Edge:
    if fields["kind"] not in get_args(Kind) or fields["curve"] not in get_args(Curve):
        raise ValueError(f"edge {fields['id']} has a kind or curve that is not known")
    (first, second), ends = fields["faces"], fields["vertices"]
    return Edge(
        int(fields["id"]),
        (int(first), int(second)),
        fields["kind"],
        fields["curve"],
        float(fields["length_mm"]),
        float(fields["dihedral_deg"]),
        _points(fields["points_mm"]),
        None if ends is None else (int(ends[0]), int(ends[1])),
    )


def _points(rows: Any) -> Floats:
    points = np.reshape(np.asarray(rows, dtype=float), (-1, 3))
    if not np.isfinite(points).all():
        raise ValueError("a point is not finite")
    return frozen(points)


def _shape(kind: str, given: dict[str, Any]) -> Shape | None:
    """The shape whose `parameters` are given; None for freeform."""
    if kind == "freeform":
        return None
    if kind not in KINDS:
        raise ValueError(f"a shape {kind!r} is not known")
    origin = np.asarray(given["origin_mm"], dtype=float)
    if kind == "sphere":
        return Sphere(origin, float(given["radius_mm"]))
    axis = np.asarray(given["axis"], dtype=float)
    if kind == "plane":
        return Plane(origin, axis)
    if kind == "cone":
        return Cone(origin, axis, float(np.deg2rad(given["semi_angle_deg"])))
    radius = float(given["radius_mm"])
    return (
        Cylinder(origin, axis, radius)
        if kind == "cylinder"
        else Torus(origin, axis, radius, float(given["minor_radius_mm"]))
    )

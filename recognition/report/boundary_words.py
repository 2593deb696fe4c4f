"""What a boundary's faces and edges are called, for the terminal and for the page."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

Json = Mapping[str, Any]
SHAPES = ("plane", "cylinder", "cone", "sphere", "torus", "freeform")
KINDS = ("convex", "concave", "smooth")
_PLURALS = {"torus": "tori", "freeform": "freeform faces"}
_CURVED = ("cylinder", "cone", "sphere", "torus")


def counted(summary: Json) -> str:
    """How many faces of each shape: `8 planes, 2 cylinders`."""
    counts = Counter(str(face["shape"]) for face in summary["faces"])
    return ", ".join(f"{counts[s]} {s if counts[s] == 1 else plural(s)}" for s in SHAPES if counts[s])


def plural(shape: str) -> str:
    """The shape's name for several."""
    return _PLURALS.get(shape, shape + "s")


def side(face: Json) -> str:
    """Whether a curved face bulges or is hollow; nothing for a plane."""
    return ("outside" if face["convex"] else "inside") if face["shape"] in _CURVED else ""


def extent(face: Json, digits: int = 2) -> str:
    """The two lengths of a face in words that say what they are."""
    a, b = (f"{x:.{digits}f}".rstrip("0").rstrip(".") for x in face["extent_mm"])
    match face["shape"]:
        case "cylinder":
            return f"{a} long, {b} round"
        case "cone":
            return f"{a} to {b} from apex"
        case "sphere":
            return f"{b} high, rim {a}"
        case "torus":
            return f"{a} round tube, {b} round axis"
    return f"{a} × {b}" if any(face["extent_mm"]) else ""


def sizes(face: Json, digits: int = 3) -> str:
    """Radii and angle, where the shape has them."""
    parameters = face["parameters"]
    out = []
    if "radius_mm" in parameters:
        out.append(f"r {_short(parameters['radius_mm'], digits)}")
    if "minor_radius_mm" in parameters:
        out.append(f"tube {_short(parameters['minor_radius_mm'], digits)}")
    if "semi_angle_deg" in parameters:
        out.append(f"{_short(parameters['semi_angle_deg'], digits)}°")
    return ", ".join(out)


def axis(face: Json) -> str:
    """The direction, as an axis of the frame where it is one."""
    direction = face["parameters"].get("axis")
    if direction is None:
        return ""
    for i, name in enumerate("xyz"):
        if abs(abs(direction[i]) - 1) < 1e-9:
            return ("+" if direction[i] > 0 else "-") + name
    return ", ".join(f"{round(x, 3) + 0.0:.3f}" for x in direction)


def neighbors(summary: Json) -> dict[int, dict[int, str]]:
    """Which faces each face meets, and how: the kind of edge, concave before smooth before convex if several."""
    rank = {"concave": 0, "smooth": 1, "convex": 2}
    out: dict[int, dict[int, str]] = defaultdict(dict)
    for edge in summary["edges"]:
        a, b = edge["faces"]
        for one, other in ((a, b), (b, a)):
            if one != other:
                old = out[one].get(other, "convex")
                out[one][other] = min(old, edge["kind"], key=lambda kind: rank[kind])
    return out


def edge_kinds(edges: Sequence[Json]) -> list[tuple[str, str, int, float]]:
    """Kind, curve, how many and how long in all [mm], of the edges that there are."""
    total: dict[tuple[str, str], list[float]] = defaultdict(list)
    for edge in edges:
        total[edge["kind"], edge["curve"]].append(edge["length_mm"])
    order = sorted(total, key=lambda key: (KINDS.index(key[0]), key[1]))
    return [(kind, curve, len(total[kind, curve]), sum(total[kind, curve])) for kind, curve in order]


def _short(value: float, digits: int) -> str:
    return f"{value:.{digits}f}".rstrip("0").rstrip(".")

"""Boundaries compared: time to match, to name the symmetry and to tell apart, on large and symmetric parts.

The same object comes in another pose, and, where the row says so, from a mesh of 0.05 mm tolerance.  With outside
data beside the checkout, the STEP part of 79 maximal faces is compared with itself moved and with its STL.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from models import parts
from models.boundary import boundary
from models.brep import Brep
from models.comparison.canonical import same_boundary
from models.comparison.isomorphism import same_topology
from models.csg import Csg, Cube, Cylinder
from models.part import load_part
from models.solid import Solid
from models.symmetry import symmetry
from primitives.pose import pose, random_rotation, transform_points

SHARED = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[3] / "shared"))


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    return [*_large_parts(), *_built_in_parts(), *_outside_parts()]


def _row(method: str, metric: str, value: float, unit: str, **asked: str) -> dict[str, Any]:
    return {"bench": "breps", "method": method, "metric": metric, "value": value, "unit": unit, **asked}


def _best(action: Callable[[], Any], times: int = 3) -> float:
    spans = []
    for _ in range(times):
        began = time.perf_counter()
        action()
        spans.append(time.perf_counter() - began)
    return 1e3 * min(spans)


def _holes(n: int) -> Csg:
    tree: Csg = Cube((20.0 * n, 20.0 * n, 8))
    for i in range(n * n):
        tree = tree - Cylinder(4, 20).at(20 * (i % n - (n - 1) / 2), 20 * (i // n - (n - 1) / 2), 0)
    return tree


def _gear(teeth: int) -> Csg:
    tree: Csg = Cylinder(50, 12)
    for i in range(teeth):
        tree = tree - Cube((10, 2.4, 30)).at(50, 0, 0).turned("z", 2 * pi * i / teeth)
    return tree


def _moved(brep: Brep, seed: int) -> Brep:
    rng = np.random.default_rng(seed)
    return brep.moved(pose(random_rotation(rng), rng.uniform(-100, 100, 3)))


def _timed(name: str, brep: Brep) -> list[dict[str, Any]]:
    other = _moved(brep, 1)
    match = same_boundary(brep, other)
    return [
        _row(f"{name}, {len(brep.faces)} faces", "same in another pose", float(bool(match)), "1", asked="1"),
        _row(f"{name}, {len(brep.faces)} faces", "compare", _best(lambda: same_boundary(brep, other)), "ms"),
        _row(
            f"{name}, {len(brep.faces)} faces", "isomorphism", _best(lambda: same_topology(brep, other)), "ms"
        ),
        _row(
            f"{name}, {len(brep.faces)} faces",
            f"symmetry {symmetry(brep).name}",
            _best(lambda: symmetry(brep)),
            "ms",
        ),
    ]


def _large_parts() -> list[dict[str, Any]]:
    rows = _timed("plate of 6x6 holes", boundary(Solid.from_csg(_holes(6), 0.02)))
    return rows + _timed("gear of 60 slots", boundary(Solid.from_csg(_gear(60), 0.02)))


def _built_in_parts() -> list[dict[str, Any]]:
    breps, moved, meshed, groups = {}, 0, 0, 0
    for i, name in enumerate(parts.names()):
        tree = parts.build(name)
        breps[name] = boundary(Solid.from_csg(tree))
        moved += bool(same_boundary(breps[name], _moved(breps[name], i)))
        coarse, rng = Solid.from_csg(tree, 0.05), np.random.default_rng(i)
        posed = transform_points(pose(random_rotation(rng), rng.uniform(-90, 90, 3)), coarse.vertices)
        bare = boundary(Solid.from_mesh(posed.astype(np.float32), coarse.triangles))
        meshed += bool(same_boundary(breps[name], bare))
        groups += symmetry(bare).name == symmetry(breps[name]).name
    names, wrong = list(breps), 0
    began = time.perf_counter()
    for i, first in enumerate(names):
        wrong += sum(bool(same_boundary(breps[first], breps[second])) for second in names[:i])
    pairs = len(names) * (len(names) - 1) // 2
    spent = 1e3 * (time.perf_counter() - began) / pairs
    total = f"{len(names)} built-in parts"
    return [
        _row(total, "same in another pose", moved / len(names), "1", asked="1"),
        _row(total, "same from a bare mesh of 0.05 mm", meshed / len(names), "1", asked=">= 0.95"),
        _row(total, "symmetry the same from that mesh", groups / len(names), "1"),
        _row(f"{pairs} pairs of them", "called the same", float(wrong), "pairs", asked="0"),
        _row(f"{pairs} pairs of them", "compare", spent, "ms"),
    ]


def _outside_parts() -> list[dict[str, Any]]:
    folder = SHARED / "parts"
    if not folder.is_dir():
        print("breps: left out STEP parts, for want of outside data", file=sys.stderr)
        return []

    def read(name: str, units: Any = "auto") -> Brep:
        return boundary(load_part(folder / name, units).solid)

    rows = _timed("featuretype.STEP", read("featuretype.STEP"))
    from_mesh = same_boundary(read("featuretype.STEP"), read("featuretype.STL", "in"))
    rows.append(_row("featuretype.STEP against .STL", "same", float(bool(from_mesh)), "1"))
    small = ["topology-a", "topology-b", "plain-block", "blind-hole", "ambiguous-open-semicircle"]
    breps = {name: read(f"{name}.step") for name in small}
    alike = sum(bool(same_boundary(brep, _moved(brep, 5))) for brep in breps.values())
    rows.append(_row("5 small STEP parts", "same in another pose", alike / len(small), "1", asked="1"))
    for i, first in enumerate(small):
        for second in small[:i]:
            same = bool(same_boundary(breps[first], breps[second]))
            expected = "1" if {first, second} == {"topology-a", "topology-b"} else "0"
            if same or expected == "1":
                rows.append(_row(f"{second} against {first}", "same", float(same), "1", asked=expected))
    texts = [(folder / f"topology-{letter}.step").read_text() for letter in "ab"]
    a, b = (_by_content(text) for text in texts)
    apart = sum(((a - b) | (b - a)).values())
    name = "topology-a and -b, their STEP entities by content"
    rows.append(_row(name, "without an equal in the other file", float(apart), f"of {a.total() + b.total()}"))
    return rows + _one_solid(breps["topology-a"], breps["topology-b"])


def _by_content(text: str) -> Counter[str]:
    """Entities of a STEP file with what they refer to in the place of its number; the order of units is free."""
    entities = {
        int(found[1]): re.sub(r"\s+", "", found[2])
        for found in re.finditer(
            r"#(\d+)\s*=\s*(.*?);\s*(?=#\d+\s*=|ENDSEC)", text.split("DATA;")[1], re.DOTALL
        )
    }
    known: dict[int, str] = {}

    def content(number: int) -> str:
        if number not in known:
            body = re.sub(r"'Context#\d+'", "", entities[number])
            units = re.search(r"UNIT_ASSIGNED_CONTEXT\(\(([^)]*)\)\)", body)
            if units:
                body = body.replace(
                    units[1], ",".join(sorted(content(int(u[1:])) for u in units[1].split(",")))
                )
            written = re.sub(r"#(\d+)", lambda found: content(int(found[1])), body)
            known[number] = hashlib.sha256(written.encode()).hexdigest()
        return known[number]

    return Counter(content(number) for number in entities)


def _one_solid(a: Brep, b: Brep) -> list[dict[str, Any]]:
    """Two files that are said to differ in topology, and hold one solid whose faces are numbered another way."""
    away = max(cKDTree(p.vertices).query(q.vertices)[0].max() for p, q in ((a, b), (b, a)))
    name = "topology-a and -b, one solid numbered another way"
    return [
        _row(name, "farthest vertex from one of the other", float(away), "mm", asked="0"),
        _row(name, "same incidence of faces and edges", float(bool(same_topology(a, b))), "1", asked="1"),
        _row(name, "difference in area", abs(_area(a) - _area(b)), "mm2", asked="0"),
    ]


def _area(brep: Brep) -> float:
    return float(sum(face.area for face in brep.faces))

"""Boundaries recovered from bare triangles, beside those that are known.

* featuretype.STL against its 79 maximal faces, and each STEP file against its own triangles: outside data.
* every built-in part, and generated ones (500, or as many as $PALPATE_BENCH_PARTS says), as an STL would have it:
  facets within 0.05 mm, single precision, no labels.  Right area is that of faces of the right shape, summed by
  shape; isomorphic means the same faces by shape and side, met in the same edges by kind.
"""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np

from models import parts
from models.boundary import boundary
from models.brep import Brep
from models.csg import Csg
from models.explained import freeform_area_fraction, unassigned_area_fraction
from models.formats.step import SUFFIXES as STEP
from models.generate import generate
from models.part import load_part
from models.recovery import recover
from models.solid import Solid

FACETS = 0.05  # [mm]
INCHES = {"featuretype.stl", "angle_block.stl", "idler_riser.stl"}
TRUE_FACES = {"plane": 49, "cylinder": 29, "freeform": 1}  # of featuretype
DATA = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[3] / "shared")) / "parts"


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    rows = [*_built_in(), *_generated(int(os.environ.get("PALPATE_BENCH_PARTS", "500")))]
    if not DATA.is_dir():
        print(f"boundaries: no {DATA}: outside parts are left out", file=sys.stderr)
        return rows
    return [*_featuretype(), *_outside(), *rows]


def bare(solid: Solid) -> Solid:
    """The triangles alone, as a binary STL keeps them."""
    return Solid.from_mesh(solid.body.vertices.astype(np.float32).astype(float), solid.triangles)


def incidence(brep: Brep) -> str:
    """A code that isomorphic boundaries share."""
    graph = nx.Graph()
    for face in brep.faces:
        graph.add_node(("face", face.id), label=f"{face.kind} {face.convex}")
    for edge in brep.edges:
        graph.add_node(("edge", edge.id), label=edge.kind)
        graph.add_edges_from((("edge", edge.id), ("face", face)) for face in edge.faces)
    code: str = nx.weisfeiler_lehman_graph_hash(graph, node_attr="label", iterations=6)
    return code


def wrong_area(found: Brep, truth: Brep) -> float:
    """Share of the area that has another shape than it should, in [0, 1]."""
    areas: list[Counter[str]] = [Counter(), Counter()]
    for brep, area in zip((found, truth), areas, strict=True):
        for face in brep.faces:
            area[face.kind] += face.area
    total = sum(areas[1].values())
    return sum(
        max(areas[1][kind] / total - areas[0][kind] / sum(areas[0].values()), 0.0) for kind in areas[1]
    )


def _featuretype() -> Iterator[dict[str, Any]]:
    file = DATA / "featuretype.STL"
    if not file.exists():
        return
    solid = load_part(file, units="in").solid
    recover(solid.body.vertices, solid.triangles, solid.neighbors)  # compiles
    began = time.perf_counter()
    brep = boundary(solid)
    seconds = time.perf_counter() - began
    kinds = Counter(face.kind for face in brep.faces)
    right = sum(min(kinds[kind], count) for kind, count in TRUE_FACES.items())
    name = "featuretype.STL"
    yield _row(f"{name}: maximal faces right", right, "of 79", ">= 78 (build123d 72)")
    yield _row(f"{name}: faces in all", len(brep.faces), "1", "79")
    yield _row(f"{name}: unassigned area", 100 * unassigned_area_fraction(solid), "%", "< 0.5")
    yield _row(f"{name}: freeform area (0.62 % is)", 100 * freeform_area_fraction(solid), "%", "0.62")
    yield _row(f"{name}: time", seconds, "s", "<= 2 (build123d 14)")
    yield _row(f"{name}: broken invariants", len(brep.check()), "1", "0")


def _outside() -> Iterator[dict[str, Any]]:
    for file in sorted(DATA.iterdir()):
        suffix = file.suffix.lower()
        if suffix == ".md":
            continue
        unit = "in" if file.name.lower() in INCHES else "m" if file.name.startswith("ariac") else "auto"
        solid = load_part(file, units=unit).solid  # type: ignore[arg-type]
        found = bare(solid) if solid.surfaces else solid
        began = time.perf_counter()
        brep = boundary(found)
        yield _row(f"{file.name}: time, {len(found.triangles)} triangles", time.perf_counter() - began, "s")
        yield _row(f"{file.name}: broken invariants", len(brep.check()), "1", "0")
        if suffix in STEP:
            yield _row(
                f"{file.name}: area of another shape than in STEP",
                100 * wrong_area(brep, boundary(solid)),
                "%",
                "<= 1",
            )


def _built_in() -> Iterator[dict[str, Any]]:
    same, wrong, seconds, size, turn = [], [], [], [0.0], [0.0]
    for name in parts.names():
        found, truth, took = _round_trip(parts.build(name))
        same.append(incidence(found) == incidence(truth))
        wrong.append(wrong_area(found, truth))
        seconds.append(took)
        if same[-1]:
            errors = _parameter_errors(found, truth)
            size += errors[0]
            turn += errors[1]
        else:
            print(f"boundaries: {name} differs from its tree", file=sys.stderr)
    yield _row("built-in parts: same faces and adjacency", 100 * float(np.mean(same)), "%", "100")
    yield _row("built-in parts: largest share of area wrong", 100 * max(wrong), "%", "0")
    yield _row("built-in parts: largest error of a radius", max(size), "mm", "<= 0.05")
    yield _row(
        "built-in parts: largest error of an axis or angle", float(np.rad2deg(max(turn))), "deg", "<= 0.1"
    )
    yield _row("built-in parts: median time", float(np.median(seconds)), "s")
    yield _row("built-in parts: longest time", max(seconds), "s")


def _generated(count: int) -> Iterator[dict[str, Any]]:
    same, wrong, seconds = [], [], []
    for seed in range(count):
        found, truth, took = _round_trip(generate(np.random.default_rng(seed)))
        same.append(incidence(found) == incidence(truth) and not found.check())
        wrong.append(wrong_area(found, truth))
        seconds.append(took)
    if count:
        yield _row(f"{count} generated parts: isomorphic", 100 * float(np.mean(same)), "%", ">= 95")
        yield _row(f"{count} generated parts: area right", 100 - 100 * float(np.mean(wrong)), "%", ">= 99")
        yield _row(f"{count} generated parts: median time", float(np.median(seconds)), "s")


def _round_trip(tree: Csg) -> tuple[Brep, Brep, float]:
    solid = Solid.from_csg(tree, FACETS)
    mesh = bare(solid)
    began = time.perf_counter()
    found = boundary(mesh)
    return found, boundary(solid), time.perf_counter() - began


def _parameter_errors(found: Brep, truth: Brep) -> tuple[list[float], list[float]]:
    """[mm] of sizes and [rad] of axes and angles, each face beside the nearest of its kind."""
    sizes, turns = [], []
    for face in found.faces:
        if face.shape is None:
            continue
        rivals = [f.shape for f in truth.faces if f.shape is not None and f.kind == face.kind]
        near = min(
            rivals,
            key=lambda s: (
                float(np.linalg.norm(s.anchor - face.shape.anchor))  # type: ignore[union-attr]
                + 100 * float(np.linalg.norm(np.cross(s.direction, face.shape.direction)))  # type: ignore[union-attr]
                + 10 * float(np.abs(np.subtract(s.sizes, face.shape.sizes)).sum())  # type: ignore[union-attr]
            ),
        )
        if face.kind != "sphere":
            turns.append(
                float(np.arcsin(min(1.0, np.linalg.norm(np.cross(near.direction, face.shape.direction)))))
            )
        difference = np.abs(np.subtract(near.sizes, face.shape.sizes)).tolist()
        (turns if face.kind == "cone" else sizes).extend(difference)
    return sizes, turns


def _row(metric: str, value: float, unit: str, asked: str | None = None) -> dict[str, Any]:
    row: dict[str, Any] = {
        "bench": "boundaries",
        "method": "palpate",
        "metric": metric,
        "value": float(value),
        "unit": unit,
    }
    return row if asked is None else {**row, "asked": asked}


if __name__ == "__main__":
    for line in run():
        print(line)

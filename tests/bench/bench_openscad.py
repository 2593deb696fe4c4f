"""OpenSCAD files: every built-in part written and read back, files as people write them, and the time of both.

Where OpenSCAD is installed, its own dump of every readable file is read too and must be the same tree, and what
it renders must have the same volume within its facets.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from models import parts
from models.csg import Cylinder
from models.formats import openscad
from models.normal.normal_form import same_tree
from models.part import load_part
from models.solid import Solid, iou
from primitives.errors import PalpateError

FILES = Path(__file__).parents[1] / "models" / "formats" / "openscad"
LONG = 1000  # solids in the file that is timed
FACETS = 0.02  # [1] of the volume, that OpenSCAD's facets may take off


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    return [*_round_trips(), *_files(), *_dumps(), *_time()]


def _row(method: str, metric: str, value: float, unit: str, **asked: str) -> dict[str, Any]:
    return {"bench": "openscad", "method": method, "metric": metric, "value": value, "unit": unit, **asked}


def _round_trips() -> list[dict[str, Any]]:
    same, overlap = 0, 1.0
    for name in parts.names():
        tree = parts.build(name)
        back = openscad.read_text(openscad.text(tree)).tree
        same += same_tree(back, tree, 1e-9)
        overlap = min(overlap, iou(Solid.from_csg(back), Solid.from_csg(tree)))
    count = len(parts.names())
    return [
        _row("built-in parts to .csg and back", "same tree", 100 * same / count, "%", asked="100"),
        _row("built-in parts to .csg and back", "least IoU", overlap, "1", asked=">= 0.9999"),
    ]


def _files() -> list[dict[str, Any]]:
    read, named, other = 0, 0, 0
    for file in sorted(path for path in FILES.iterdir() if path.is_file()):
        try:
            openscad.read(file)
            read += 1
        except PalpateError as error:
            named += str(error).startswith(f"{file.name}, line ")
            other += not str(error).startswith(f"{file.name}, line ")
    return [
        _row("files written for the purpose", "read", read, "files"),
        _row("files written for the purpose", "refused with their line", named, "files"),
        _row("files written for the purpose", "refused without", other, "files", asked="0"),
    ]


def _dumps() -> list[dict[str, Any]]:
    if shutil.which("openscad") is None:
        print("openscad: not installed; its own reading of the files is left out", file=sys.stderr)
        return []
    count = same = close = 0
    for file in sorted(FILES.glob("*.scad")):
        try:
            drawing = openscad.read(file)
        except PalpateError:
            continue
        if drawing.warnings:
            print(f"openscad: {file.name}: left out, its circles are read round", file=sys.stderr)
            continue
        count += 1
        with tempfile.TemporaryDirectory() as folder:
            dump, mesh = Path(folder) / "part.csg", Path(folder) / "part.stl"
            for out in (dump, mesh):
                command = ["openscad", "-D", "$fa=4", "-D", "$fs=0.5", "-o", str(out), str(file)]
                subprocess.run(command, check=False, capture_output=True, timeout=100)
            try:
                same += same_tree(openscad.read(dump).tree, drawing.tree, 1e-3)
                volume = sum(load_part(mesh, body=i + 1).solid.volume for i in range(_bodies(mesh)))
                close += abs(volume / Solid.from_csg(drawing.tree).volume - 1) < FACETS
            except PalpateError as error:
                print(f"openscad: {file.name}: {error}", file=sys.stderr)
    return [
        _row("against OpenSCAD's own dump", "same tree", 100 * same / count, "%", asked="100"),
        _row("against OpenSCAD's own mesh", "same volume", 100 * close / count, "%", asked="100"),
    ]


def _bodies(mesh: Path) -> int:
    count = 1
    try:
        load_part(mesh)
    except PalpateError as error:
        count = int(str(error).split(" holds ")[1].split()[0])
    return count


def _time() -> list[dict[str, Any]]:
    tree = Cylinder(2, 30).at(0, 0, 0.5) | Cylinder(3, 20).at(10, 0, 0)
    for i in range(LONG - 2):
        tree = tree | Cylinder(2, 30).at(10.0 * (i % 30), 10.0 * (i // 30), 0)
    text = openscad.text(tree)
    began = time.perf_counter()
    openscad.read_text(text)
    read = time.perf_counter() - began
    began = time.perf_counter()
    openscad.text(tree)
    return [
        _row(f".csg of {LONG} solids", "read", read, "s"),
        _row(f".csg of {LONG} solids", "written", time.perf_counter() - began, "s"),
        _row(f".csg of {LONG} solids", "length", len(text) / 1000, "kB"),
    ]

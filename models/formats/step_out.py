"""STEP out of a tree, with exact surfaces: needs the extra `step`, a kernel that is loaded in its own process.

The tree goes to `step_out_worker` as a plan, in JSON; what comes back is the file, or nothing.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from models.csg import (
    Cone,
    Csg,
    Cube,
    Cylinder,
    Difference,
    Intersection,
    Operation,
    Placed,
    Polyhedron,
    Prism,
    Sphere,
    Torus,
)
from models.formats.whole_file import write_whole
from primitives.errors import PalpateError

SECONDS = 120  # that the kernel may take
_WORKER = Path(__file__).with_name("step_out_worker.py")


def available() -> bool:
    """Whether the extra is installed."""
    return find_spec("OCP") is not None


def write(tree: Csg, path: str | Path, name: str = "", seconds: int = SECONDS) -> None:
    """Write a tree as STEP (AP214, mm); the file appears whole or not at all."""
    file = Path(path)
    write_whole(file, text(tree, name or file.stem, seconds))


def text(tree: Csg, name: str = "part", seconds: int = SECONDS) -> bytes:
    """The STEP file of a tree."""
    if not available():
        raise PalpateError(
            "writing STEP needs a geometry kernel; install it with: pip install 'palpate[step]'"
        )
    plan = json.dumps([_plan(tree), name])
    with tempfile.TemporaryDirectory(prefix="palpate-") as scratch:
        try:
            done = subprocess.run(
                [sys.executable, "-I", str(_WORKER)],
                input=plan.encode(),
                capture_output=True,
                timeout=seconds,
                cwd=scratch,
                env={**os.environ, "TMPDIR": scratch},
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise PalpateError(
                f"writing STEP took more than {seconds} s; write .csg or .stl instead"
            ) from None
    if done.returncode or not done.stdout:
        raise PalpateError(
            "the geometry kernel could not build the tree for STEP; write .csg or .stl instead"
        )
    return done.stdout


def _plan(tree: Csg) -> list[Any]:
    match tree:
        case Placed():
            return ["placed", tree.pose[:3].tolist(), _plan(tree.child)]
        case Operation():
            return [_OPERATIONS.get(type(tree), "union"), *map(_plan, tree.children)]
        case Cube():
            return ["cube", *tree.size]
        case Cylinder():
            return ["cylinder", tree.radius, tree.height]
        case Cone():
            return ["cone", tree.bottom_radius, tree.top_radius, tree.height]
        case Sphere():
            return ["sphere", tree.radius]
        case Torus():
            return ["torus", tree.major_radius, tree.minor_radius]
        case Prism():
            return _prism(tree)
        case Polyhedron():
            return ["polyhedron", tree.points, tree.faces]
    raise PalpateError(f"cannot write {tree!r} as STEP")


_OPERATIONS: dict[type[Operation], str] = {Intersection: "intersection", Difference: "difference"}


def _prism(prism: Prism) -> list[Any]:
    n, half = len(prism.outline), prism.height / 2
    points = [(x, y, z) for z in (-half, half) for x, y in prism.outline]
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return ["polyhedron", points, [tuple(range(n - 1, -1, -1)), tuple(range(n, 2 * n)), *sides]]

"""STEP in, in mm, its planes, cylinders, cones, spheres and tori exact: the only user of cascadio.

The reader runs in a process of its own (`step_worker`) under limits of memory and time: of broken files, one
in eight crashes it.  It gives triangles in meters, single precision, and per face the exact surface in double
precision, or nothing (splines, surfaces of revolution); faces without one are looked at in `step_faces`.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from models.formats.gltf_arrays import BROKEN, Gltf, Primitive
from models.formats.labeled import LabeledMesh
from models.formats.step_faces import labeled
from primitives.errors import PalpateError

SUFFIXES = (".step", ".stp")
_WORKER = Path(__file__).with_name("step_worker.py")
_MM_PER_M = 1000.0
_END = 4_000_000  # [bytes]
_PREFIXES = {"MILLI": 1.0, "CENTI": 10.0, "DECI": 100.0, "MICRO": 1e-3, "$": 1000.0}


@dataclass(frozen=True)
class StepConfig:
    """How finely a file is cut into triangles, and what reading it may cost."""

    tolerance: float = 0.005  # [mm] between a facet and its surface
    angle: float = 0.1  # [rad] between neighboring facets
    coarser: float = 0.1  # [mm] where the fine one takes too much
    most: int = 30_000_000  # [bytes] of triangles, about a million, above which coarser ones are made
    memory: int = 4_000_000_000  # [bytes]
    seconds: int = 60  # of processor time
    patience: float = 5.0  # times that by the clock, for a machine that does other things as well


def parse(data: bytes, name: str, config: StepConfig | None = None) -> list[LabeledMesh]:
    """The bodies of a file [mm], one mesh for each that the file names; a mesh may still hold several."""
    if find_spec("cascadio") is None:
        raise PalpateError(
            f"reading {name} needs cascadio, which has no build for every system: pip install cascadio, "
            "or export the part as STL"
        )
    limits = config or StepConfig()
    glb = _converted(data, name, limits)
    try:
        found = list(Gltf.of_glb(glb).primitives())
    except BROKEN:
        raise PalpateError(f"{name} gives no usable geometry; export it again as AP214") from None
    if not found:
        raise PalpateError(f"{name} has no solid in it, only {_held(data)}; export it as a solid")
    groups: dict[int, list[Primitive]] = {}
    for run in found:
        groups.setdefault(run.place, []).append(run)
    return [labeled(runs, _MM_PER_M) for runs in groups.values()]


def unit_mm(data: bytes) -> float:
    """How many mm the file's own unit of length has; 1 where it does not say."""
    ends = data if len(data) <= 2 * _END else data[:_END] + data[-_END:]  # the unit stands near either
    text = ends.decode("latin-1")
    if conversion := re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'(INCH|IN|FOOT|FT)\b", text, re.IGNORECASE):
        return 25.4 if conversion[1].upper() in ("INCH", "IN") else 304.8
    if plain := re.search(r"SI_UNIT\s*\(\s*\.?(\w+|\$)\.?\s*,\s*\.METRE\.\s*\)", text, re.IGNORECASE):
        return _PREFIXES.get(plain[1].upper(), 1.0)
    return 1.0


def _converted(data: bytes, name: str, limits: StepConfig) -> bytes:
    """GLB bytes from the worker, coarser where the fine mesh takes too much."""
    for tolerance in (limits.tolerance, limits.coarser):
        glb, why = _run(data, tolerance, limits)
        if 0 < len(glb) <= limits.most or why == "broken":
            break
    if glb:
        return glb
    if why == "slow":
        raise PalpateError(f"{name} takes more than {limits.seconds} s to read; simplify it first")
    if not data.rstrip().endswith(b"END-ISO-10303-21;"):
        raise PalpateError(
            f"{name} ends in the middle (no END-ISO-10303-21); it is truncated: export it again"
        )
    if b"_POINT" not in data:
        raise PalpateError(f"{name} has no geometry in it; export it again")
    raise PalpateError(f"cannot read {name} as STEP; export it again as AP214")


def _run(data: bytes, tolerance: float, limits: StepConfig) -> tuple[bytes, str]:
    """What the worker wrote, and else why not: broken, crashed or slow."""
    arguments = [str(tolerance), str(limits.angle), str(limits.memory), str(limits.seconds)]
    with tempfile.TemporaryDirectory(prefix="palpate-") as scratch:
        try:
            done = subprocess.run(
                [sys.executable, "-I", str(_WORKER), *arguments],
                input=data,
                capture_output=True,
                timeout=limits.patience * limits.seconds,
                cwd=scratch,
                env={**os.environ, "TMPDIR": scratch},
                check=False,
            )
        except subprocess.TimeoutExpired:
            return b"", "slow"
    if done.returncode == 0:
        return done.stdout, ""
    slow = done.returncode == -getattr(signal, "SIGXCPU", 0)
    return b"", "slow" if slow else "broken" if done.returncode == 3 else "crashed"


def _held(data: bytes) -> str:
    shells = re.search(rb"\b(OPEN_SHELL|SHELL_BASED_SURFACE_MODEL|GEOMETRIC_CURVE_SET)\b", data)
    return shells[1].decode().lower().replace("_", " ") + "s" if shells else "what is no geometry"

"""CAD files in and out: what STEP gives, what comes back, and what the largest and worst files cost.

Files come from $PALPATE_DATA/parts or ../shared/parts.  A STEP file's own triangles, their labels dropped, go
through recovery, and the faces' area by shape is held against the file's.  Two facetings of one solid agree no
better than they are fine, so a round trip that falls short is compared again in finer facets.
"""

import io
import os
import struct
import subprocess
import sys
import tempfile
import time
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np

from models import parts
from models.boundary import boundary
from models.brep import Brep
from models.csg import Csg
from models.formats import step_out
from models.formats.load import load
from models.formats.step import StepConfig
from models.part import load_part
from models.solid import TOLERANCE, Solid, iou

ROOT = Path(__file__).parents[2]
DATA = Path(os.environ.get("PALPATE_DATA", ROOT.parent / "shared")) / "parts"
_PATIENT = 600  # [s] that the reader may take, else it gives coarse facets
FINENESS = (  # of the file's facets, and of the tree's [mm]
    (StepConfig(), TOLERANCE),
    (StepConfig(tolerance=0.002, angle=0.05, seconds=_PATIENT), 0.0007),
    (StepConfig(tolerance=0.001, angle=0.05, seconds=_PATIENT, most=150_000_000), 0.0005),
)
ASKED = 0.9999  # IoU
COST = """
import re, sys, time
from models.part import load_part
from primitives.errors import PalpateError
def peak():
    return int(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1]) / 1024
began, before = time.perf_counter(), peak()
try:
    load_part(sys.argv[1])
except PalpateError:
    pass
print(time.perf_counter() - began, peak() - before)
"""


def run() -> list[dict]:
    return [*step_in(), *step_round_trip(), *costs()]


def _row(method: str, metric: str, value: float, unit: str, asked: str = "") -> dict:
    out = {"bench": "formats", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return {**out, "asked": asked} if asked else out


def _areas(solid: Solid) -> Counter:
    areas: Counter = Counter()
    for face in boundary(solid).faces:
        areas[face.kind] += face.area
    return areas


def step_in() -> list[dict]:
    files = sorted(f for f in DATA.glob("*") if f.suffix.lower() in (".step", ".stp"))
    if not files:
        print(f"left out: STEP files, for {DATA} has none", file=sys.stderr)
    rows = []
    for file in files:
        scale = 0.2 if file.name.startswith("nist") else 1.0
        began = time.perf_counter()
        solid = load_part(file, scale=scale).solid
        loaded = time.perf_counter() - began
        exact = boundary(solid)
        bare = _areas(Solid.from_mesh(solid.vertices, solid.triangles))
        told = _areas(solid)
        wrong = sum(abs(told[kind] - bare[kind]) for kind in told | bare) / 2 / sum(told.values())
        rows += [
            _row(file.name, "load", loaded, "s"),
            _row(file.name, "faces", len(exact.faces), "faces"),
            _row(file.name, "broken invariants", len(exact.check()), "", "0"),
            _row(file.name, "area by shape against own triangles", 100 * wrong, "%", "< 1"),
        ]
    return rows


def step_round_trip() -> list[dict]:
    if not step_out.available():
        print("left out: STEP out, for the extra 'step' is not installed", file=sys.stderr)
        return []
    ious, same, writing = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for name in parts.names():
            file = Path(folder) / f"{name}.step"
            tree = parts.build(name)
            began = time.perf_counter()
            step_out.write(tree, file)
            writing.append(time.perf_counter() - began)
            read = load(file, fineness=StepConfig(seconds=_PATIENT)).solid
            gone, back = _kinds(boundary(Solid.from_csg(tree))), _kinds(boundary(read))
            same.append(gone == back)
            ious.append(_agreement(tree, file))
            if not same[-1] or ious[-1] < ASKED:
                print(f"STEP and back: {name}: same faces {same[-1]}, IoU {ious[-1]:.6f}", file=sys.stderr)
    return [
        _row("round trip", "parts with the same faces and edges", 100 * np.mean(same), "%", "100"),
        _row("round trip", "least IoU", min(ious), "", f">= {ASKED}"),
        _row("round trip", "parts", len(same), "parts"),
        _row("round trip", "median time to write", float(np.median(writing)), "s"),
    ]


def _kinds(brep: Brep) -> tuple[Counter, Counter]:
    return Counter(face.kind for face in brep.faces), Counter(edge.kind for edge in brep.edges)


def _agreement(tree: Csg, file: Path) -> float:
    """IoU of a tree and the file that it was written to, in the coarsest facets that let it pass."""
    best = 0.0
    for fineness, tolerance in FINENESS:
        best = max(best, iou(Solid.from_csg(tree, tolerance), load(file, fineness=fineness).solid))
        if best >= ASKED:
            break
    return best


def costs() -> list[dict]:
    if not Path("/proc/self/status").exists():
        print("left out: what the worst files cost, for memory is read where Linux has it", file=sys.stderr)
        return []
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, data in (
            ("5 M triangles.stl", _stl(np.random.default_rng(0).normal(size=(1000, 9)), 5_000_000)),
            ("1 M triangles.stl", _stl(_ring(707), 0)),
            ("soup of 100 k.stl", _stl(np.random.default_rng(0).normal(size=(100_000, 9)) * 50, 0)),
            ("zip bomb.3mf", _bomb()),
        ):
            file = Path(folder) / name
            file.write_bytes(data)
            done = subprocess.run(
                [sys.executable, "-c", COST, str(file)], capture_output=True, text=True, cwd=ROOT, check=True
            )
            seconds, megabytes = map(float, done.stdout.split())
            rows += [_row(name, "time", seconds, "s"), _row(name, "memory", megabytes, "MB")]
    return rows


def _stl(corners: np.ndarray, count: int) -> bytes:
    count = count or len(corners)
    records = np.zeros(count, dtype=[("normal", "<f4", 3), ("corners", "<f4", 9), ("more", "<u2")])
    records["corners"] = corners[np.arange(count) % len(corners)]
    return bytes(80) + struct.pack("<I", count) + records.tobytes()


def _ring(n: int) -> np.ndarray:
    """(2 n n, 9) corners of a torus's triangles."""
    turn = 2 * np.pi / n * np.arange(n + 1) % (2 * np.pi)
    u, v = np.meshgrid(turn, turn, indexing="ij")
    ring = 50 + 20 * np.cos(v)
    points = np.stack([ring * np.cos(u), ring * np.sin(u), 20 * np.sin(v)], axis=-1)
    points[-1], points[:, -1] = points[0], points[:, 0]
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 9) for t in ((a, b, c), (a, c, d))])


def _bomb() -> bytes:
    held = io.BytesIO()
    with (
        zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as files,
        files.open("3D/3dmodel.model", "w", force_zip64=True) as file,
    ):
        for _ in range(1100):
            file.write(bytes(1 << 20))
    return held.getvalue()

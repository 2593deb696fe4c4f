"""Five parts through emulators on pseudo-terminals, beside the simulation of the same part, pose and seed.

Each run is a command in a process of its own, the emulator in another, as a person would start them.  Asked: the
same model and decision, every extent within 0.1 mm, and an emulated controller that refused no line.
`PALPATE_BENCH_PARTS=cube,sphere` takes other parts, `PALPATE_BENCH_RUNS=track,explore` some of the commands.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from models.part import load_part
from models.solid import Solid
from primitives import pose as se3
from recognition.hardware.emulate import BOX
from recognition.running.simulation import WorldConfig, random_pose
from recognition.tracking.truth import edge_truth

PARTS = tuple(os.environ.get("PALPATE_BENCH_PARTS", "block,cylinder,disc,wedge,frustum").split(","))
RUNS = tuple(os.environ.get("PALPATE_BENCH_RUNS", "track,explore,identify").split(","))
COMMANDS = {"track": ["track", "edge"], "explore": ["explore"], "identify": ["identify"]}
PALPATE = [sys.executable, "-m", "recognition.cli"]
EXTENT = 0.1  # [mm] asked
SEEDS = 12  # poses at most, until the simulation closes
SAME_FACE = 0.99  # cosine between the normals of two faces that are one
STARTS = 60.0  # [s] at most until the emulator answers


def run() -> list[dict[str, Any]]:
    """A row for every part and command, and what the emulators saw."""
    rows: list[dict[str, Any]] = []
    for first, part in enumerate(PARTS, int(os.environ.get("PALPATE_BENCH_SEED", "0"))):
        for name in RUNS:
            with tempfile.TemporaryDirectory() as folder:
                rows += _compared(name, part, first, Path(folder))
                _tell(rows)
    return rows


def _compared(name: str, part: str, first: int, folder: Path) -> list[dict[str, Any]]:
    """At the first pose where the simulation closes: one that gets lost has no outline to compare with."""
    for seed in range(first, first + SEEDS):
        pose, box = _pose(part, seed), ",".join(f"{x:g}" for x in BOX)
        common = ["--seed", str(seed), "--json"]
        out = ["--out", str(folder / f"simulated{seed}")]
        simulated = _json([*COMMANDS[name], part, "--pose", _told(pose), "--workspace", box, *out, *common])
        if simulated.get("closed", True):
            break
    began = time.monotonic()
    with _emulated(part, pose, seed, folder) as seen:
        config = str(folder / "rig.toml")
        wired = _json([*COMMANDS[name], "--device", config, "--out", str(folder / "wired"), *common])
    solid = load_part(part).solid
    compared = {"explore": _model, "identify": _decision, "track": partial(_track, solid=solid.placed(pose))}
    rows = compared[name](simulated, wired)
    most, hits, refused = seen
    rows += [
        ("refused lines", refused, "", 0),
        ("housing hits", hits, "", None),
        ("most force", most, "N", 60.0),
    ]
    rows.append(("seed", seed, "", None))
    rows.append(("seconds of the machine", time.monotonic() - began, "s", None))
    return [_row(f"{name} {part}", *row) for row in rows]


def _model(simulated: dict[str, Any], wired: dict[str, Any]) -> list[tuple[Any, ...]]:
    """Of two explorations: whether they gave one model, and how far its extents differ."""
    kinds = [sorted(face["shape"] for face in s["faces"]) for s in (simulated, wired)]
    built = [sorted((p["kind"], p["operation"]) for p in s["primitives"]) for s in (simulated, wired)]
    same = kinds[0] == kinds[1] and built[0] == built[1] and simulated["closed"] == wired["closed"]
    off = _extents_off(simulated["faces"], wired["faces"]) if kinds[0] == kinds[1] else float("nan")
    solid = [
        np.sort(np.concatenate([p["extent_mm"] for p in s["primitives"]] or [[]])) for s in (simulated, wired)
    ]
    of_solid = float(np.abs(solid[0] - solid[1]).max(initial=0.0)) if built[0] == built[1] else float("nan")
    return [
        ("same model", float(same), "", 1.0),
        ("closed, simulated", float(simulated["closed"]), "", None),
        ("closed", float(wired["closed"]), "", None),
        ("extents of faces off, most", off, "mm", EXTENT),
        ("extents of primitives off, most", of_solid, "mm", EXTENT),
        ("touches, simulated", simulated["touches"], "", None),
        ("touches", wired["touches"], "", None),
        ("device time", wired["device_seconds"], "s", None),
    ]


def _extents_off(a: list[dict[str, Any]], b: list[dict[str, Any]]) -> float:
    """[mm] the greatest difference of an extent, each face beside the one that lies where it does."""
    apart = np.array(
        [[np.linalg.norm(_place(p) - _place(q)) + 1e6 * (p["shape"] != q["shape"]) for q in b] for p in a]
    )
    pairs = zip(*linear_sum_assignment(apart), strict=True) if a else ()
    return float(
        max((np.abs(np.subtract(a[i]["extent_mm"], b[j]["extent_mm"])).max() for i, j in pairs), default=0.0)
    )


def _place(face: dict[str, Any]) -> np.ndarray:
    """(6,) where a face lies and how it is turned [mm], a radian as 50 mm."""
    told = face["parameters"]
    return np.concatenate(
        [told.get("origin_mm", np.zeros(3)), 50.0 * np.array(told.get("axis", np.zeros(3)))]
    )


def _decision(simulated: dict[str, Any], wired: dict[str, Any]) -> list[tuple[Any, ...]]:
    return [
        ("same decision", float(simulated["decision"] == wired["decision"]), "", 1.0),
        ("sure, simulated", float(simulated["ended"] == "sure"), "", None),
        ("sure", float(wired["ended"] == "sure"), "", None),
        ("touches, simulated", simulated["touches"], "", None),
        ("touches", wired["touches"], "", None),
        ("device time", wired["device_seconds"], "s", None),
    ]


def _track(simulated: dict[str, Any], wired: dict[str, Any], solid: Solid) -> list[tuple[Any, ...]]:
    """Of two tracks of one face: edge by edge.  Where they came to two faces: with the object's own edges."""
    found = [s["found"] for s in (simulated, wired)]
    one = float(np.dot(*(f["face_normal"] or np.zeros(3) for f in found))) > SAME_FACE
    edges = [sorted((e["curve"], e["length_mm"]) for e in f["edges"]) for f in found]
    if one:
        same = [c for c, _ in edges[0]] == [c for c, _ in edges[1]] and simulated["closed"] == wired["closed"]
        off = max((abs(p[1] - q[1]) for p, q in zip(*edges, strict=True)), default=0.0) if same else np.nan
    else:
        truth = edge_truth(solid, np.reshape(wired["trace"], (-1, 3))) or {"edges": 0, "length_mm": 0.0}
        same = wired["closed"] and len(edges[1]) == truth["edges"]
        off = abs(found[1]["length_mm"] - truth["length_mm"]) / len(edges[1]) if same else np.nan
    return [
        ("same outline", float(same), "", 1.0),
        ("of the same face", float(one), "", None),
        ("closed, simulated", float(simulated["closed"]), "", None),
        ("closed", float(wired["closed"]), "", None),
        ("edges", len(edges[1]), "", None),
        ("lengths of edges off, most", off, "mm", EXTENT),
        ("device time", wired["device_seconds"], "s", None),
    ]


def _pose(part: str, seed: int) -> np.ndarray:
    """(4, 4) world_from_part as `palpate hardware emulate` draws it."""
    box, rng = np.reshape(BOX, (2, 3)), np.random.default_rng(seed)
    return random_pose(load_part(part).solid, box, rng, WorldConfig(offset=20.0))


def _told(pose: np.ndarray) -> str:
    """X,Y,Z,QW,QX,QY,QZ."""
    return ",".join(f"{x:.9f}" for x in (*pose[:3, 3], *se3.quaternion_wxyz(pose)))


@contextmanager
def _emulated(part: str, pose: np.ndarray, seed: int, folder: Path) -> Iterator[list[float]]:
    """An emulator in a process of its own; afterwards greatest force [N], housing hits, refused lines."""
    config, seen = folder / "rig.toml", [float("nan")] * 3
    told = ["hardware", "emulate", part, "--pose", _told(pose), "--seed", str(seed), "--config", str(config)]
    process = subprocess.Popen([*PALPATE, *told], stderr=subprocess.PIPE, text=True)
    try:
        until = time.monotonic() + STARTS
        while not config.exists() and process.poll() is None and time.monotonic() < until:
            time.sleep(0.1)
        yield seen
    finally:
        process.send_signal(signal.SIGTERM)
        said = process.communicate(timeout=30.0)[1]
        if found := re.search(r"most force ([\d.]+) N, housing hits (\d+), refused lines (\d+)", said):
            seen[:] = map(float, found.groups())


def _json(words: list[str]) -> dict[str, Any]:
    done = subprocess.run([*PALPATE, *words], capture_output=True, text=True)
    if not done.stdout.strip():
        raise RuntimeError(f"palpate {' '.join(words)}: {done.stderr.strip()}")
    return dict(json.loads(done.stdout))


def _tell(rows: list[dict[str, Any]]) -> None:
    last = [row for row in rows if row["method"] == rows[-1]["method"]]
    print(
        last[0]["method"],
        "; ".join(f"{r['metric']} {r['value']:.4g}" for r in last),
        file=sys.stderr,
        flush=True,
    )


def _row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, Any]:
    row = {"bench": "wired", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return row if asked is None else {**row, "asked": asked}

"""Clouds of contacts: faces of sparse noisy ones, models of dense clean ones, stated uncertainty, killed runs.

Sparse: 60, 200 and 1,000 contacts spread over a part, 0.3 mm and 3 degrees off, on the outside data's STEP files
(at 60 to 160 mm) and on random parts that nobody looked at; `clouds.score` says what is measured. CGAL's Efficient
RANSAC under the same noise reached an instance mIoU of 0.14, 0.32 and 0.42, and a shape accuracy of 0.21, 0.55 and
0.68. Dense: 20,000 exact contacts on built-in parts, each at a random attitude and size. Seconds are of the
process, so that a busy machine does not matter.

Quick by default, some minutes; PALPATE_BENCH_CLOUDS=all takes every part, 1,000 fits of each kind and 50 kills.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from clouds.fits import two_sigma_rows
from clouds.killed import killed_rows
from clouds.regular import regularity_rows
from clouds.sampled import DATA, Cloud, builtin_parts, generated_parts, sampled, step_parts
from clouds.score import instance_miou, shape_accuracy

from models.csg import Csg
from models.parts import names
from models.solid import Solid, iou
from primitives.arrays import Ints
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import PatchGraph
from recognition.assembly import NotClosed
from recognition.reconstruct import reconstruct
from recognition.reconstructing.run import box_around
from recognition.reconstructing.surfaces import surfaces
from recognition.sources.noise import estimated_sigma

WHOLE = os.environ.get("PALPATE_BENCH_CLOUDS", "") == "all"
SIGMA, TILT = 0.3, float(np.deg2rad(3.0))  # [mm], [rad]
ASKED = {60: (0.40, 0.60), 200: (0.70, 0.85), 1000: (0.85, 0.95)}
DENSE = 20_000
_NORMAL_SIGMA = 0.05  # [rad] as a table's, which does not say


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    if not DATA.is_dir():
        print(f"clouds: no {DATA}; its STEP files are left out", file=sys.stderr)
    rows: list[dict[str, Any]] = []
    steps, random = list(step_parts()), list(generated_parts(40 if WHOLE else 6))
    for count in ASKED:
        for name, parts in (("STEP files", steps), ("random parts", random)):
            rows += _sparse_rows(name, parts, count, normals=True) if parts else []
        if count > 60:
            rows += _sparse_rows("random parts, no normals", random, count, normals=False)
    rows += _dense_rows(names() if WHOLE else names()[::6])
    rows += [row for sigma in (0.05, SIGMA) for row in regularity_rows(names()[:: 1 if WHOLE else 6], sigma)]
    rows += two_sigma_rows(1000 if WHOLE else 150)
    rows += killed_rows(50 if WHOLE else 4)
    return rows


def _row(
    method: str, metric: str, value: float, unit: str, asked: float | str | None = None
) -> dict[str, Any]:
    found = {"bench": "clouds", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return found | ({} if asked is None else {"asked": asked})


def _sparse_rows(
    what: str, parts: list[tuple[str, Solid]], count: int, normals: bool
) -> Iterator[dict[str, Any]]:
    instance, shape, seconds = [], [], []
    for k, (_, solid) in enumerate(parts):
        cloud = sampled(solid, count, np.random.default_rng([k, count]), SIGMA, TILT, normals)
        began = time.process_time()
        found, kinds = labels(surfaces(cloud.contacts), cloud)
        seconds.append(time.process_time() - began)
        instance.append(instance_miou(cloud.face, found))
        shape.append(shape_accuracy(cloud.face, cloud.kinds, found, kinds))
    asked = ASKED[count] if normals else (None, None)
    where = f"{count} contacts, {len(parts)} {what}"
    yield _row("palpate", f"instance mIoU, {where}", np.mean(instance), "", asked[0])
    yield _row("palpate", f"shape accuracy, {where}", np.mean(shape), "", asked[1])
    yield _row("palpate", f"time, {where}", np.mean(seconds), "s")


def labels(graph: PatchGraph, cloud: Cloud) -> tuple[Ints, list[str]]:
    """(n,) face of each contact and the faces' kinds; what no face holds is a flat face of its own."""
    row = {tuple(point): i for i, point in enumerate(cloud.contacts.points)}
    found, kinds = np.full(len(row), -1, dtype=np.int64), list[str]()
    for face in graph.faces:
        if not isinstance(face.fit, Fit):
            continue
        found[[row[tuple(point)] for point in face.contacts.points]] = len(kinds)
        kinds.append(face.fit.kind)
    alone = np.flatnonzero(found < 0)
    found[alone] = len(kinds) + np.arange(len(alone))
    return found, [*kinds, *["plane"] * len(alone)]


def _dense_rows(wanted: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    overlaps, leaves, seconds = [], [], []
    for name, solid, scale in builtin_parts(wanted):
        exact = sampled(solid, DENSE, np.random.default_rng(1), 0.0, 0.0, scale=scale).contacts
        each = np.arange(len(exact))
        cloud = Contacts.of(
            exact.points, exact.normals, estimated_sigma(exact), _NORMAL_SIGMA, touch=each, stroke=each
        )
        began = time.process_time()
        made = reconstruct(surfaces(cloud), [], box_around(cloud)).assembly
        seconds.append(time.process_time() - began)
        truth = Solid.from_mesh(scale * solid.vertices, solid.triangles)
        overlaps.append(0.0 if isinstance(made, NotClosed) else iou(made.solid, truth))
        own = _leaves(solid.csg)
        leaves.append(np.inf if isinstance(made, NotClosed) else _leaves(made.tree) / own)
        print(
            f"  {name}: IoU {overlaps[-1]:.5f}, leaves x{leaves[-1]:.2f}, {seconds[-1]:.1f} s",
            file=sys.stderr,
        )
    where = f"{DENSE} clean contacts, {len(overlaps)} built-in parts"
    yield _row("palpate", f"median IoU, {where}", np.median(overlaps), "", ">= 0.995")
    yield _row("palpate", f"least IoU, {where}", np.min(overlaps), "", ">= 0.97")
    yield _row("palpate", f"median leaves, {where}", np.median(leaves), "x the part's own", "<= 1.2")
    yield _row("palpate", f"most leaves, {where}", np.max(leaves), "x the part's own")
    yield _row("palpate", f"longest, {where}", np.max(seconds), "s", "<= 10")


def _leaves(tree: Csg | None) -> int:
    return 1 if tree is None else sum(1 for _ in tree.leaves())

"""Smooth bodies from contacts: ours, the hull of the contacts, and distances interpolated by radial functions.

Each body is one to four ellipsoids melted into each other; its contacts are spread evenly, 0.3 mm off along each
axis and their normals 3 degrees, or 0.05 mm and 1 degree.  IoU is with the body itself.  PALPATE_BENCH_BODIES says
how many bodies (4 by default), drawn from numbers by which nothing was set.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from clouds.sampled import sampled
from clouds.smooth import hull, radial, smooth_body

from models.solid import Solid, iou
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from recognition.assembly import NotClosed
from recognition.reconstruct import reconstruct
from recognition.reconstructing.run import box_around
from recognition.reconstructing.surfaces import surfaces

BODIES = int(os.environ.get("PALPATE_BENCH_BODIES", "4"))
FIRST = 12  # number that the first body is drawn from: those before helped to find what was wrong
NOISES = ((0.3, 3.0), (0.05, 1.0))  # [mm], [deg]
COUNTS = (30, 60, 200, 1000)


def run() -> list[dict[str, Any]]:
    """Rows of the table."""
    ways: dict[str, Callable[[Contacts], Solid | None]] = {"palpate": ours, "hull": hull, "radial": radial}
    bodies = {k: smooth_body(np.random.default_rng(k)) for k in range(FIRST, FIRST + BODIES)}
    rows: list[dict[str, Any]] = []
    for sigma, degrees in NOISES:
        for count in COUNTS:
            clouds = [
                sampled(body, count, np.random.default_rng([k, count]), sigma, float(np.deg2rad(degrees)))
                for k, body in bodies.items()
            ]
            for name, way in ways.items():
                found = [
                    measured(way, cloud.contacts, body)
                    for cloud, body in zip(clouds, bodies.values(), strict=True)
                ]
                rows += _rows(name, f"{count} contacts, {sigma} mm", np.array(found))
    return rows


def measured(way: Callable[[Contacts], Solid | None], contacts: Contacts, body: Solid) -> tuple[float, float]:
    """IoU, 0 of what is no solid; seconds of the process."""
    began = time.process_time()
    try:
        made = way(contacts)
    except (PalpateError, ValueError):
        made = None
    return 0.0 if made is None else iou(made, body), time.process_time() - began


def ours(contacts: Contacts) -> Solid | None:
    """What `palpate reconstruct` makes of them."""
    made = reconstruct(surfaces(contacts), [], box_around(contacts)).assembly
    return None if isinstance(made, NotClosed) else made.solid


def _rows(method: str, where: str, found: np.ndarray) -> list[dict[str, Any]]:
    told = (
        ("IoU, median", np.median(found[:, 0]), ""),
        ("IoU, least", found[:, 0].min(), ""),
        ("time, median", np.median(found[:, 1]), "s"),
    )
    return [
        {
            "bench": "smooth",
            "method": method,
            "metric": f"{metric}, {where}",
            "value": float(value),
            "unit": unit,
        }
        for metric, value, unit in told
    ]

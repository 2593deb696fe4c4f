"""What planning is worth: device time to an IoU of 0.95, and the area under IoU over time, of each policy.

Every policy explores the same object at the same pose with the same approach and perception, and what it has felt
is made into a model, the same way, every few touches.  A policy that never comes to 0.95 counts with the time at
which it ended, which flatters it; its row says how high it came.  The area is over the time that the slowest took,
as a share of it: who has ended keeps his last model.  `PALPATE_BENCH_PARTS=block,bracket` runs some parts,
`PALPATE_BENCH_SEED` another pose, `PALPATE_BENCH_TOUCHES` lets the other policies touch more often.
"""

import os
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from exploration.planning.explorer import Explorer, ExplorerConfig, Findings
from models.solid import Solid, iou
from primitives.errors import PalpateError
from recognition.assembly import NotClosed
from recognition.config import ExploreOptions
from recognition.reconstruct import reconstruct
from recognition.running.patience import Patience
from recognition.running.simulation import World, guarded, load_world, tools

PARTS = tuple(
    os.environ.get("PALPATE_BENCH_PARTS", "block,cylinder,wedge,hex_bar,bracket,slotted_block").split(",")
)
SEED = int(os.environ.get("PALPATE_BENCH_SEED", "1"))
TOUCHES = int(os.environ.get("PALPATE_BENCH_TOUCHES", "200"))
POLICIES = ("closure", "grid", "raster", "random")
ENOUGH = 0.95
Course = list[tuple[float, float]]  # device time [s], IoU


def run() -> list[dict[str, Any]]:
    """Rows per part, and what ours takes of the others' time in the median."""
    rows: list[dict[str, Any]] = []
    shares: dict[str, list[float]] = {policy: [] for policy in POLICIES[1:]}
    for part in PARTS:
        courses: dict[str, Course] = {}
        for policy in POLICIES:
            courses[policy], cost = explored(part, policy)
            rows += [_row(f"{part}, {policy}", *each) for each in (*told(courses[policy]), *cost)]
            print(f"policies: {part}, {policy}: {told(courses[policy])} {cost}", file=sys.stderr, flush=True)
        horizon = max(course[-1][0] for course in courses.values())
        rows += [
            _row(f"{part}, {policy}", "area under IoU over time", area(course, horizon), "")
            for policy, course in courses.items()
        ]
        ours = time_to(courses["closure"])
        for policy in POLICIES[1:]:
            shares[policy].append(ours / time_to(courses[policy]))
    rows += [
        _row(f"ours over {policy}", f"time to IoU {ENOUGH}, median", float(np.median(share)), "", 1 / 3)
        for policy, share in shares.items()
    ]
    return rows


def explored(part: str, policy: str) -> tuple[Course, list[tuple[str, float, str]]]:
    """How IoU went over device time, and what it cost in touches and travel."""
    sensors = ("lts210", "fingertip") if policy == "closure" else ("lts210",)
    options = ExploreOptions(
        part, seed=SEED, sensors=sensors, noise=0.05, policy=policy, max_touches=TOUCHES, out=Path("unused")
    )
    course: Course = [(0.0, 0.0)]
    world = load_world(options, several=policy == "closure")
    with closing(world):
        guard = guarded(world, options, lambda *_: None)
        config = ExplorerConfig(max_touches=TOUCHES, policy=policy, seed=SEED)
        explorer = Explorer(guard, world.box.ravel(), config, lambda *_: None, tools(world))
        patience, modelled = Patience(), 0
        for findings in explorer.run():
            known = len(findings.graph.faces) + len(findings.traces)
            if (
                policy == "closure"
                and not findings.hollow
                and patience.lost(guard.cost.touches, known, findings.open)
            ):
                findings.hollow = True
            if guard.cost.touches >= modelled + max(2, modelled // 10):
                modelled = guard.cost.touches
                course.append((guard.cost.seconds, likeness(findings, world, world.solid)))
        course.append((guard.cost.seconds, likeness(explorer.found, world, world.solid)))
    cost = guard.cost
    return course, [
        ("touches", cost.touches, ""),
        ("travel", cost.travel / 1000.0, "m"),
        ("time", cost.seconds, "s"),
    ]


def likeness(findings: Findings, world: World, truth: Solid) -> float:
    """IoU of what would be written now; 0 without a body."""
    try:
        free = np.concatenate(findings.inside) if findings.inside else None
        made = reconstruct(findings.graph, [trace for trace, _ in findings.traces], world.box, free=free)
    except PalpateError:
        return 0.0
    return 0.0 if isinstance(made.assembly, NotClosed) else iou(made.assembly.solid, truth)


def time_to(course: Course) -> float:
    """[s] on the device to the first model that is good enough, or to the end."""
    return next((seconds for seconds, value in course if value >= ENOUGH), course[-1][0])


def told(course: Course) -> list[tuple[str, float, str]]:
    """What one course came to."""
    return [(f"time to IoU {ENOUGH}", time_to(course), "s"), ("IoU at the end", course[-1][1], "")]


def area(course: Course, horizon: float) -> float:
    """Mean IoU over time up to a horizon, the last model kept from when it was made."""
    seconds = np.array([*(at for at, _ in course), horizon])
    return float(np.diff(seconds) @ np.array([value for _, value in course]) / horizon)


def _row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, Any]:
    row = {"bench": "policies", "method": method, "metric": metric, "value": value, "unit": unit}
    return row if asked is None else row | {"asked": asked}

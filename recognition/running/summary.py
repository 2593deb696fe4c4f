"""`summary.json` of an exploration, and the settings as a report lists them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any

from exploration.devices.guard import Cost
from primitives.evidence import NOT_FELT
from primitives.pose import quaternion_wxyz
from recognition.assembly import NotClosed
from recognition.config import ExploreOptions
from recognition.reconstruct import Reconstruction
from recognition.running.simulation import World
from recognition.running.smallness import small_for
from recognition.truth import Truth

CLOSED = "closed"
FAULT = "fault: "
_OPEN = "nothing reachable is open"
_COUNTED = (
    (r"collision of .*", "the housing behind the pad met the object, and backed off"),
    (r"overpress of .*", "the skin was pressed through, and the pad backed off"),
    (r"pressed to .*", "a press passed its limit, and the pad backed off"),
)


def summarize(
    options: ExploreOptions,
    world: World,
    ended: str,
    cost: Cost,
    made: Reconstruction,
    truth: Truth | None,
    warnings: Iterable[str],
    wall_seconds: float,
) -> dict[str, Any]:
    """Everything that one exploration found; only `wall_seconds` differs from run to run of a seed."""
    assembly = None if isinstance(made.assembly, NotClosed) else made.assembly
    closed = ended == CLOSED and made.closed
    felt = made.contacts.points[made.contacts.touch != NOT_FELT]
    files = {"report": "report.html"}
    if assembly is not None:
        files = {"model": "model.csg", "mesh": "model.stl", **files}
    return {
        "command": "explore",
        "version": version("palpate"),
        "part": world.part.name,
        "sensor": world.sensor,
        "seed": options.seed,
        "closed": closed,
        "ended": _OPEN if ended == CLOSED and not closed else ended,
        "touches": cost.touches,
        "strokes": cost.strokes,
        "frames": cost.frames,
        "travel_mm": cost.travel,
        "device_seconds": cost.seconds,
        "wall_seconds": wall_seconds,
        "faces": made.faces,
        "edges": made.edges,
        "primitives": made.primitives,
        "regularities": made.regularities,
        "volume_mm3": None if assembly is None else assembly.solid.volume,
        "csg": None if assembly is None else {"leaves": sum(1 for _ in assembly.tree.leaves())},
        "truth": _told_truth(world, truth),
        "warnings": counted([*world.part.warnings, *small_for(felt, world.specs), *warnings, *made.warnings]),
        "files": files,
    }


def fault_of(summary: Mapping[str, Any]) -> str:
    """The fault that ended a run, and an empty text where it ended by itself."""
    ended = str(summary.get("ended") or "")
    return ended.removeprefix(FAULT) if ended.startswith(FAULT) else ""


def _told_truth(world: World, truth: Truth | None) -> dict[str, Any] | None:
    if not world.known:
        return None
    return _unmet(world) if truth is None else truth.as_dict()


def _unmet(world: World) -> dict[str, Any]:
    """Where the object was; there is no body to compare with it."""
    pose = world.solid.pose
    placed = {"translation_mm": pose[:3, 3].tolist(), "quaternion_wxyz": quaternion_wxyz(pose).tolist()}
    return {"iou": None, "hausdorff_mm": None, "surface_rms_mm": None, "world_from_part": placed}


def counted(warnings: Iterable[str]) -> list[str]:
    """Each kind of warning once, in order of appearance, with how often it came."""
    times = Counter(_worded(warning) for warning in warnings)
    return [text if n == 1 else f"{text} ({n} times)" for text, n in times.items()]


def _worded(warning: str) -> str:
    return next((text for pattern, text in _COUNTED if re.fullmatch(pattern, warning)), warning)

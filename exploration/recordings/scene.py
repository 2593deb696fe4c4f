"""What other tools show of a recording beside its frames: the pad as a body that moves, and events as a log.

Both are Foxglove's well-known messages: a `SceneUpdate` whose one entity is fastened to the array's own frame, and
a `Log` line for each event.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

_THICK = 2.0  # [mm] of the plate that stands for the pad, behind its skin
_COLOR = {"r": 0.18, "g": 0.44, "b": 0.49, "a": 0.85}
_INFO = 2  # level of a log line
_LONG = 200  # characters of what an event tells; longer ones are named alone


def pad_scene(sensor: str, size: tuple[float, float], nanoseconds: int) -> bytes:
    """The sensing area of `size` [mm] along x and y, in the array's frame."""
    stamp = _stamp(nanoseconds)
    cube = {
        "pose": {
            "position": {"x": 0.0, "y": 0.0, "z": -_THICK / 2000.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        },
        "size": {"x": size[0] / 1000.0, "y": size[1] / 1000.0, "z": _THICK / 1000.0},
        "color": _COLOR,
    }
    entity = {
        "timestamp": stamp,
        "frame_id": sensor,
        "id": f"{sensor} pad",
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{kind: [] for kind in ("arrows", "spheres", "cylinders", "lines", "triangles", "texts", "models")},
        "cubes": [cube],
    }
    return json.dumps({"deletions": [], "entities": [entity]}).encode()


def log_line(kind: str, detail: Mapping[str, Any], nanoseconds: int) -> bytes:
    """An event in one line."""
    told = ", ".join(f"{key} {value}" for key, value in detail.items())
    line = {
        "timestamp": _stamp(nanoseconds),
        "level": _INFO,
        "message": f"{kind}: {told}" if told and len(told) <= _LONG else kind,
        "name": "palpate",
        "file": "",
        "line": 0,
    }
    return json.dumps(line, default=str).encode()


def _stamp(nanoseconds: int) -> dict[str, int]:
    seconds, rest = divmod(nanoseconds, 1_000_000_000)
    return {"sec": seconds, "nsec": rest}

"""160 rays on 20,480 triangles: a posed solid and the portable tree beside the bare embreex call."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh

from models.raycast import PortableCaster, has_embree
from models.rays.triangle_tree import TriangleTree
from models.solid import Solid
from primitives.pose import pose, random_rotation, rotate, transform_points

ROUNDS = 400


def run() -> list[dict[str, Any]]:
    """Median microseconds a call, the methods taking turns, and each over the bare call."""
    ball = trimesh.creation.icosphere(5, 30.0)
    part = Solid.from_mesh(ball.vertices, ball.faces)
    rng = np.random.default_rng(0)
    world_from_part = pose(random_rotation(rng), rng.uniform(-200, 200, 3))
    x, y = np.meshgrid(np.linspace(-13.5, 13.5, 16), np.linspace(-8.1, 8.1, 10))
    origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, 35.0)], axis=1)
    down = np.tile([0.0, 0.0, -1.0], (x.size, 1))
    home = origins.astype(np.float32), down.astype(np.float32)
    away = (
        transform_points(world_from_part, origins).astype(np.float32),
        rotate(world_from_part, down).astype(np.float32),
    )
    placed = part.placed(world_from_part)
    portable = PortableCaster(TriangleTree(part.body.vertices, part.body.triangles))
    methods: dict[str, Callable[[], Any]] = {
        "first_hits": lambda: part.first_hits(*home),
        "first_hits, posed": lambda: placed.first_hits(*away),
        "portable": lambda: portable.first_hits(*home),
    }
    if has_embree():
        scene = part.body.caster._scene
        methods = {"bare embreex call": lambda: scene.run(*home, output=1), **methods}
    took = {name: [_seconds(call) for _ in range(3)] for name, call in methods.items()}
    for _ in range(ROUNDS):
        for name, call in methods.items():
            took[name].append(_seconds(call))
    median = {name: float(np.median(values)) * 1e6 for name, values in took.items()}
    rows = [_row(name, "time", value, "us") for name, value in median.items()]
    bare = median.get("bare embreex call")
    if bare:
        rows += [_row(name, "over the bare call", value / bare, "x") for name, value in median.items()]
    return rows


def _seconds(call: Callable[[], Any]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def _row(method: str, metric: str, value: float, unit: str) -> dict[str, Any]:
    return {"bench": "raycast", "method": method, "metric": metric, "value": value, "unit": unit}

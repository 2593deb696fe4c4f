"""A made-up run to report, and signals that are heeded as on the command line."""

import signal
import sys

import numpy as np
import pytest

from primitives.pose import frame_along, pose
from recognition.console import interrupts
from recognition.report.run_report import Deviation, ReportFrames, ReportMesh, RunReport


def cylinder_mesh(radius, height, sides=48):
    angle = np.arange(sides) * 2 * np.pi / sides
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    low, high = (np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height))
    vertices = np.concatenate([low, high, [[0, 0, 0], [0, 0, height]]])
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    b, t = np.full(sides, 2 * sides), np.full(sides, 2 * sides + 1)
    triangles = np.concatenate(
        [
            np.stack([i, j, j + sides], 1),
            np.stack([i, j + sides, i + sides], 1),
            np.stack([b, j, i], 1),
            np.stack([t, i + sides, j + sides], 1),
        ]
    )
    return ReportMesh(vertices, triangles, np.repeat([0, 0, 1, 2], sides))


def made_up_report(frame_count=2000, rows=10, columns=16):
    radius, height = 20.0, 45.0
    rng = np.random.default_rng(3)
    mesh = cylinder_mesh(radius, height)
    turn = rng.uniform(0, 2 * np.pi, 1500)
    wall = np.stack([radius * np.cos(turn), radius * np.sin(turn), rng.uniform(0, height, 1500)], axis=1)
    times = np.arange(frame_count) / 100.0
    around = 2 * np.pi * times / times[-1] * 3
    normals = np.stack([np.cos(around), np.sin(around), np.zeros(frame_count)], axis=1)
    lifted = np.maximum(0.0, np.sin(around * 4)) * 8
    centers = (
        normals * (radius + lifted)[:, None] + [0, 0, 1] * (height * (0.3 + 0.6 * times / times[-1]))[:, None]
    )
    poses = np.stack([pose(frame_along(-n, [0, 0, 1.0]), c) for n, c in zip(normals, centers, strict=True)])
    touching = lifted < 0.5
    x = (np.arange(columns) - (columns - 1) / 2) * 1.8
    y = (np.arange(rows) - (rows - 1) / 2) * 1.8
    edge = (x[None, None, :] < (4 * np.cos(around))[:, None, None]) * np.exp(-((y / 5) ** 2))[None, :, None]
    counts = 10 + 190 * edge * touching[:, None, None] + rng.normal(0, 2, (frame_count, rows, columns))
    lines = [
        np.array([[np.pi / 2, -4 * np.cos(a)]]) if on else np.empty((0, 2))
        for a, on in zip(around, touching, strict=True)
    ]
    rim = np.stack(
        [
            radius * np.cos(np.linspace(0, 6.2, 200)),
            radius * np.sin(np.linspace(0, 6.2, 200)),
            np.full(200, height),
        ],
        1,
    )
    touch = np.where(touching, np.cumsum(np.diff(touching, prepend=False) & touching) - 1, -1)
    summary = {
        "command": "explore",
        "version": "0.1.0",
        "part": "post <b>",
        "sensor": "lts210",
        "seed": 3,
        "closed": True,
        "ended": "closed",
        "touches": int(touch.max() + 1),
        "strokes": 18,
        "frames": frame_count,
        "travel_mm": 2120.5,
        "device_seconds": 20.0,
        "wall_seconds": 1.7,
        "volume_mm3": 56548.7,
        "faces": [
            {
                "id": 0,
                "shape": "cylinder",
                "status": "measured",
                "convex": True,
                "extent_mm": [45.01, 125.7],
                "area_mm2": 5654.9,
                "parameters": {"origin_mm": [0, 0, 22.5], "axis": [0, 0, 1], "radius_mm": 20.004},
                "sigma": {"radius_mm": 0.008},
            },
            {
                "id": 1,
                "shape": "plane",
                "status": "measured",
                "convex": True,
                "extent_mm": [40.0, 40.0],
                "area_mm2": 1256.6,
                "parameters": {"origin_mm": [0, 0, 0], "axis": [0, 0, -1]},
                "sigma": {},
            },
            {
                "id": 2,
                "shape": "plane",
                "status": "inferred",
                "convex": True,
                "extent_mm": [40.0, 40.0],
                "area_mm2": 1256.6,
                "parameters": {"origin_mm": [0, 0, 45], "axis": [0, 0, 1]},
                "sigma": {},
            },
        ],
        "edges": [
            {
                "id": i,
                "faces": [0, i + 1],
                "kind": "convex",
                "curve": "circle",
                "length_mm": 125.7,
                "dihedral_deg": 90.0,
                "status": "measured",
            }
            for i in range(2)
        ],
        "primitives": [
            {
                "kind": "cylinder",
                "operation": "add",
                "extent_mm": [40, 40, 45.0],
                "pose": {"translation_mm": [0, 0, 22.5], "quaternion_wxyz": [1, 0, 0, 0]},
            }
        ],
        "truth": {
            "iou": 0.9982,
            "hausdorff_mm": 0.11,
            "surface_rms_mm": 0.031,
            "face_shape_accuracy": 1.0,
            "extent_error_mm": {"median": 0.02, "max": 0.06},
        },
        "warnings": ["face 2 was outlined but not pressed in its middle"],
    }
    ghost = ReportMesh(mesh.vertices * [1.01, 1.01, 1.0], mesh.triangles, mesh.face)
    off = Deviation(mesh, np.where(mesh.vertices[:, 2] > 1, 0.05, -0.02), 0.05)
    return RunReport(
        summary=summary,
        settings={"part": "post", "seed": 3, "sensors": ["lts210"], "noise": 0.05, "feature_mm": 10.0},
        model=mesh,
        truth=ghost,
        off=off,
        contacts=wall,
        contact_face=np.zeros(len(wall), dtype=np.int64),
        traces=(rim,),
        frames=ReportFrames(
            times, poses, counts, np.where(touching, 4 + np.sin(9 * around), 0.0), touch, lines
        ),
        pad_size=(28.8, 18.0),
        housing_size=(34.0, 24.0, 14.0),
    )


@pytest.fixture(scope="session")
def report():
    return made_up_report()


@pytest.fixture
def heeded():
    names = [name for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {name: signal.getsignal(getattr(signal, name)) for name in names}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    interrupts.heed()
    hook = sys.unraisablehook
    yield
    interrupts.heed()  # forgets
    sys.unraisablehook = hook
    for name, handler in before.items():
        signal.signal(getattr(signal, name), handler)

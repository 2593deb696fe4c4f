"""The simulated array against one bare embree call, and its frames against closed forms.

A frame is timed on edge tracks of a block and of a finely tessellated cylinder's rim, each beside one bare call of
160 rays at the pad on the same mesh in the same run; figures are medians over frames.
"""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import replace

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from scipy.stats import norm

from exploration.devices.simulated import simulate
from exploration.sensing.physics.elastomer import Rubber, wrench
from exploration.sensing.physics.electronics import Memory, draw_unit, read_out
from exploration.sensing.physics.gap import gap, indentation
from exploration.sensing.physics.mesh_gap import FEW, MeshGap
from exploration.sensing.physics.skin import skin_of
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.pose import pose, rotation_exp

LTS = load_sensor("lts210")
EVERY = replace(
    LTS,
    elastomer=replace(LTS.elastomer, hysteresis=0.03),
    electronics=replace(LTS.electronics, gain_spread=0.05, dead=0.02, drift=0.002, scan=0.004),
)
DOWN = np.diag([1.0, -1.0, -1.0])
FRAMES = 200


def row(method, metric, value, unit, asked=None):
    found = {"bench": "simulator", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return found | ({} if asked is None else {"asked": asked})


def seconds(work):
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin


def block_track():
    for s in np.linspace(-12.0, 12.0, FRAMES):
        yield pose(DOWN @ rotation_exp([0.01, -0.005, 0.2 + 0.01 * s]), [20.0 + 0.02 * s, s, 19.5])


def rim_track():
    for a in np.linspace(0.0, 2 * np.pi, FRAMES):
        turn = rotation_exp([0.0, 0.0, a]) @ DOWN @ rotation_exp([0.01, -0.005, 0.1])
        yield pose(turn, [20.0 * np.cos(a), 20.0 * np.sin(a), 19.5])


def bare_rays(where):
    x, y = np.meshgrid(LTS.array.x, LTS.array.y)
    local = np.stack([x.ravel(), y.ravel(), np.full(x.size, -3.0)], axis=1)
    origins = (local @ where[:3, :3].T + where[:3, 3]).astype(np.float32)
    return origins, np.tile(where[:3, 2], (len(origins), 1)).astype(np.float32)


def frame_rows(name, solid, track):
    scene = EmbreeScene()
    TriangleMesh(scene, solid.vertices.astype(np.float32), solid.triangles.astype(np.int32))
    rng = np.random.default_rng(0)
    makers = {}
    for spec, label in ((LTS, "cast, spread, noise, quantize"), (EVERY, "all stages")):
        makers[label] = (spec, gap(solid, spec), Rubber(spec), draw_unit(spec, rng))
    skewed = 2 * skin_of(LTS).shape[0] + 1
    spent = {"bare": [], **{label: [] for label in makers}}
    for i, where in enumerate(track):
        rays = bare_rays(where)
        spent["bare"].append(min(seconds(lambda rays=rays: scene.run(*rays)) for _ in range(3)))
        for label, (spec, sensed, rubber, unit) in makers.items():
            memory = Memory.fresh(spec)
            shift = np.linspace(-0.1, 0.1, skewed) if spec.electronics.scan else np.zeros(1)
            poses = np.stack([pose(None, [0.0, s, 0.0]) @ where for s in shift])

            def frame(spec=spec, sensed=sensed, rubber=rubber, unit=unit, memory=memory, poses=poses):
                sensed.feel(poses)
                read_out(rubber.press(sensed.modes, sensed.partial), spec, unit, memory, 0.005, rng)

            spent[label].append(min(seconds(frame) for _ in range(3)) if i else seconds(frame))
    middle = {k: np.median(v) for k, v in spent.items()}
    rows = [
        row("bare embree, 160 rays", f"{name} ({len(solid.triangles)} triangles)", 1e6 * middle["bare"], "us")
    ]
    for label, asked in zip(makers, (3.0, 5.0), strict=True):
        rows.append(row(label, f"{name}: time of a frame", 1e6 * middle[label], "us"))
        rows.append(row(label, f"{name}: over the bare call", middle[label] / middle["bare"], "x", asked))
    return rows


def tick_rows(solid):
    stage, (array,) = simulate(solid, [LTS], np.random.default_rng(0), start_pose=pose(DOWN, [0, 0, 150.0]))
    stage.move(np.array([5.0, 0, 0, 0, 0, 0]))
    free = np.median([seconds(array.read) for _ in range(1000)])
    stage.go_to(pose(DOWN, [20.0, 0.0, 19.5]))
    while stage.moving:
        array.read()
    stage.move(np.array([0, 5.0, 0, 0, 0, 0]))
    touching = np.median([seconds(array.read) for _ in range(400)])
    return [
        row("read(), stage included", "free space", 1e6 * free, "us"),
        row("read(), stage included", "on a block's edge", 1e6 * touching, "us"),
    ]


def compile_row():
    code = (
        "import time, numpy as np; from exploration.sensing.physics.gap import indentation;"
        "from exploration.sensing.physics.elastomer import pressure;"
        "from exploration.sensing.spec import load_sensor;"
        "from models.solid import Solid; from models.csg import Cube; from primitives.pose import pose;"
        "s, k = Solid.from_csg(Cube((40., 40., 40.))), load_sensor('lts210'); t = time.perf_counter();"
        "pressure(indentation(s, pose(np.diag([1., -1, -1]), [20., 0, 19.5]), k), k);"
        "print(time.perf_counter() - t)"
    )
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "NUMBA_CACHE_DIR": folder},
            capture_output=True,
            text=True,
            check=True,
        )
    return row("numba", "cold compile before the first frame", float(done.stdout), "s")


def half_plane_share(nx, ny, c, x0, x1, y0, y1):
    if nx < 0:
        return half_plane_share(-nx, ny, c, -x1, -x0, y0, y1)
    if ny < 0:
        return half_plane_share(nx, -ny, c, x0, x1, -y1, -y0)
    if nx < 1e-12 or ny < 1e-12:
        low, high, at = (y0, y1, c / ny) if nx < 1e-12 else (x0, x1, c / nx)
        return np.clip((at - low) / (high - low), 0.0, 1.0) + np.zeros(
            np.broadcast_shapes(x0.shape, y0.shape)
        )
    area = sum(
        sign * np.maximum(0.0, c - nx * x - ny * y) ** 2
        for sign, x, y in ((1, x0, y0), (-1, x1, y0), (-1, x0, y1), (1, x1, y1))
    )
    return area / (2 * nx * ny * (x1 - x0) * (y1 - y0))


def edge_rows(solid, name, few):
    rng, skin, array = np.random.default_rng(0), skin_of(LTS), LTS.array
    sigma, z0, pitch = LTS.elastomer.spread, 0.5, 1.8
    node, weight = np.polynomial.legendre.leggauss(6)
    x = (array.x[:, None] + pitch / 2 * node).ravel()[None, :]
    y = (array.y[:, None] + pitch / 2 * node).ravel()[:, None]
    inner = (slice(2, -2), slice(2, -2))
    bare, spread = [], []
    sensed, rubber = MeshGap(solid, skin, LTS.elastomer.thickness, few), Rubber(LTS)
    for i in range(500):
        angle = 0.0 if i % 4 == 0 else rng.uniform(-0.7, 0.7)
        offset = pitch / 2 * rng.integers(-4, 5) if i % 8 == 0 else rng.uniform(-3.0, 3.0)
        where = pose(DOWN @ rotation_exp([0, 0, angle]), [20.0 + offset, 0.3, 19.5])
        sensed.feel(where[None])
        cells = skin.x_edges[None, :], skin.y_edges[:, None]
        edge = (np.cos(angle), -np.sin(angle), -offset)
        exact = half_plane_share(*edge, cells[0][:, :-1], cells[0][:, 1:], cells[1][:-1], cells[1][1:])
        bare.append(np.abs((sensed.modes[0] / z0 - exact).sum(axis=1)).max())
        distance = -offset - np.cos(angle) * x + np.sin(angle) * y
        mean = [
            np.einsum("rjci,i,j->rc", v.reshape(array.rows, 6, array.columns, 6), weight, weight)[inner] / 4
            for v in (norm.cdf(distance / sigma), norm.pdf(distance / sigma) / sigma)
        ]
        error = rubber.press(sensed.modes, sensed.partial)[inner] / LTS.elastomer.stiffness / z0 - mean[0]
        spread.append(abs((error * mean[1]).sum() / (mean[1] ** 2).sum()) / pitch)
    return [
        row(name, "place of an edge, no spread, worst row of 500 poses", max(bare), "taxel", 0.01),
        row(name, "place of an edge, after the spread, worst of 500 poses", max(spread), "taxel", 0.01),
    ]


def force_rows(block):
    width, height = LTS.array.size
    flat = -wrench(indentation(block, pose(DOWN, [1.0, 2.0, 19.6]), LTS), LTS)[2] / (
        0.1 * width * height * 0.4
    )
    rows = [row("flat press", "force over k A d, less one", abs(flat - 1), "ratio", 0.01)]
    for radius in (15.0, 30.0):
        ball, depth = Solid.from_csg(Sphere(radius)), 0.6
        felt = indentation(ball, pose(DOWN, [0.2, 0.1, radius - depth]), LTS)
        exact = 0.1 * np.pi * (radius * depth**2 - depth**3 / 3)
        worst = abs(-wrench(felt, LTS)[2] / exact - 1)
        rows.append(
            row(
                "sphere",
                f"force over the Winkler integral, less one, radius {radius:g}",
                worst,
                "ratio",
                0.02,
            )
        )
    return rows


def run():
    block, cylinder = Solid.from_csg(Cube((40.0, 40.0, 40.0))), Solid.from_csg(Cylinder(20.0, 40.0))
    return [
        *frame_rows("block's edge", block, block_track()),
        *frame_rows("cylinder's rim", cylinder, rim_track()),
        *tick_rows(block),
        compile_row(),
        *edge_rows(block, "drawn facets", FEW),
        *edge_rows(_fine_block(), "cast rays", -1),
        *force_rows(block),
    ]


def _fine_block():
    import trimesh

    mesh = trimesh.creation.box((40.0, 40.0, 40.0)).subdivide().subdivide()
    return Solid.from_mesh(mesh.vertices, mesh.faces)


if __name__ == "__main__":
    for found in run():
        asked = f"   (asked {found['asked']:g})" if "asked" in found else ""
        print(f"{found['method']:32} {found['metric']:58} {found['value']:10.4g} {found['unit']}{asked}")

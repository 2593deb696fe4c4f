"""Compile every numba kernel once, into the cache beside its source: `python -m recognition.warm`.

Part of installing: a kernel compiles the first time that it is called, which would otherwise be in the middle
of somebody's first exploration.  One whole exploration of a built-in part, one edge and one surface tracked, and a
recording of frames of every kind call them all.  Two processes share the work: what one has compiled, the other
reads from the cache.
"""

import os
import signal
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context
from pathlib import Path

import numpy as np
import trimesh
from scipy.ndimage import gaussian_filter

from exploration.control.edge_refined import Frames, moved_outward, nodes_along
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.stage_trail import StageTrail
from exploration.planning.inferring.rounded_corners import farthest_of_arc
from exploration.planning.known.swept_cells import SweptCells
from exploration.planning.open.mouths import mouths
from exploration.planning.open.views import best_view
from exploration.planning.ways.box_kernels import in_box
from exploration.planning.ways.routes import Tool
from exploration.sensing.frame import TactileImage
from exploration.sensing.levels import leveled
from exploration.sensing.response import rubber
from models.csg import Sphere
from models.library import Library, distance_field
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.grain import Grain
from primitives.implicit_surface import implicit_surface
from primitives.shapes import Plane
from primitives.soft_outlines import sharpened
from recognition.assembly.lists import Target
from recognition.assembly.search import shortest
from recognition.assembly.vocabulary import Vocabulary
from recognition.config import ExploreOptions
from recognition.console import interrupts
from recognition.explore import run as explore
from recognition.frames.options import FramesOptions
from recognition.frames.run import run as frames
from recognition.matching import Evidence, match
from recognition.tracking.options import TrackOptions
from recognition.tracking.run import run as track
from recognition.tracking.view import View

NOISE = 4.0  # [counts]
SHAPE = (10, 16)


def main() -> None:
    """Explore, track and perceive into a folder that is thrown away, and say how long that took."""
    began = time.perf_counter()
    interrupts.heed()
    print("compiling the kernels, once ...", flush=True)
    try:
        _compile()
    except KeyboardInterrupt:
        print("palpate: interrupted; what was compiled until then is kept", file=sys.stderr)
        sys.exit(interrupts.asked() or 130)
    print(f"compiled in {time.perf_counter() - began:.1f} s")


def _compile() -> None:
    with (
        tempfile.TemporaryDirectory(prefix="palpate-warm-") as name,
        ProcessPoolExecutor(
            min(2, os.cpu_count() or 1),
            get_context("spawn"),
            initializer=signal.signal,
            initargs=(signal.SIGINT, signal.SIG_IGN),  # Ctrl-C goes to all of them, and one of them answers
        ) as crew,
    ):
        try:
            for done in [
                crew.submit(task, Path(name))
                for task in (perceive_all, the_rest, explore_once, track_both, touch_mesh)
            ]:
                done.result()
        except BaseException:
            for child in active_children():  # else they would compile to their end, and keep the folder
                child.terminate()
            raise


def explore_once(folder: Path) -> None:
    """A block."""
    explore(ExploreOptions(part="block", out=folder / "run"), lambda _: None)


def track_both(folder: Path) -> None:
    """One edge of a disc, and one face: what has many facets is felt by rays, and not by drawing them."""
    for what in ("edge", "surface"):
        track(TrackOptions(part="disc", out=folder / what, what=what), View())


def touch_mesh(folder: Path) -> None:
    """A few touches of a mesh of which no exact surface is known: a ball with a dent, as a scan is."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=20.0)
    ball.vertices[ball.vertices[:, 2] > 15.0, 2] -= 2.0
    ball.export(folder / "scan.stl")
    options = ExploreOptions(part=str(folder / "scan.stl"), out=folder / "scanned", max_touches=6)
    explore(options, lambda _: None)


def the_rest(folder: Path) -> None:
    """What neither exploring nor tracking calls."""
    Grain().at(np.zeros((1, 3)))
    poles = np.concatenate([np.eye(3), -np.eye(3)])
    implicit_surface(poles, poles, np.ones(6), np.ones(6)).values(poles)
    distance_field(Solid.from_csg(Sphere(10.0))).signed_distance(np.zeros((1, 3)))
    match_once()
    KinematicChain.gantry().reach(np.eye(4), np.ones(6))
    StageTrail(0.0, np.eye(4)).at(np.zeros(1), np.eye(4))
    look_once()
    bent_edge_once()
    outline_once()
    assemble_once()


def look_once() -> None:
    """Round what is no block: ways past felt places, through swept cells, and in from afar."""
    tool, poles = Tool.of_size((8.0, 8.0)), np.concatenate([np.eye(3), -np.eye(3)])
    swept = SweptCells(np.repeat([-30.0, 30.0], 3))
    rows = np.zeros((1, 6))
    for points in (rows[:, :3], rows[:, :3].copy()):
        in_box(points, np.eye(4), (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
        tool.clear(np.eye(4)[None], points, 0.0, 0.0)
    mouths(10.0 * poles, rows[:, :3], poles[:1], poles[2])
    swept.holds_box(np.eye(4), tool.low, tool.high)
    best_view(10.0 * poles, poles, swept, tool.high[:2], np.eye(3))


def bent_edge_once() -> None:
    """One frame beside a line, which no part that is tracked here would ask for."""
    flat, places = np.zeros((1, *SHAPE)), nodes_along(-4.0, 4.0)
    curve = np.column_stack([places, np.zeros((len(places), 2))])
    frames = Frames(flat, flat + 1.0, (1.8, 1.8), np.eye(4)[None], np.ones((1, 2)), 1.0, np.zeros(1))
    moved_outward(curve, frames, float(places[0]), rubber(1.2, (1.8, 1.8)))


def outline_once() -> None:
    """A square hole in a picture, and the corner of another."""
    share = gaussian_filter(np.pad(np.ones((30, 30)), 15), 2.0)
    square = 7.0 + 15.0 * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    sharpened(share, share < 2.0, [square], 0.5)
    farthest_of_arc(square, square[0], np.array([0.6, 0.8]), 1.0, 0.1)


def assemble_once() -> None:
    """A cube less its half, from three planes and the cells between them."""
    planes = [Plane(np.array([height, 0.0, 0.0]), np.eye(3)[0]) for height in (-1.0, 0.0, 1.0)]
    above = np.arange(4)[:, None] > np.arange(3)
    shortest(Target(Vocabulary(planes, above), above.sum(axis=1) == 1, np.full(4, 100.0)))


def match_once() -> None:
    """A ball's six poles, with normals, and another ball."""
    poles = np.concatenate([np.eye(3), -np.eye(3)])
    balls = Library.of(
        {name: Solid.from_csg(Sphere(size)) for name, size in (("ball", 10.0), ("other", 12.0))}
    )
    match(Evidence(Contacts.of(10.0 * poles, poles, 0.1)), balls)


def perceive_all(folder: Path) -> None:
    """Read a recording of faces, edges, corners, walls, slots, discs, holes and domes, with a dead taxel."""
    rng, path = np.random.default_rng(0), folder / "frames.npy"
    pressed = [gaussian_filter(200.0 * face, 1.0) for face in faces()]
    for counts in pressed:
        counts[4, 7] *= 0.2
    stack = np.array([*np.zeros((12, *SHAPE)), *pressed])
    np.save(path, 30.0 + np.round(stack + NOISE * rng.standard_normal(stack.shape)))
    for felt in _seen(path):
        leveled(felt)


def _seen(path: Path) -> list[TactileImage]:
    options = FramesOptions(str(path))
    recording = options.recording()
    frames(options, recording)
    return [felt.image for felt in frames(FramesOptions(str(path), index=14), recording).shown]


def faces() -> list[Floats]:
    """(rows, columns) depth of each kind, before blur."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] - np.array(SHAPE)[:, None, None] / 2
    away = np.hypot(x, y)
    kinds = [
        np.ones(SHAPE),
        x > 0.3 * y,
        (x > -2) & (y > -1),
        (x > -2) & (y > -1) & (x + y < 4),
        np.abs(x) < 2,
        np.abs(x) > 2,
        away < 3,
        away > 2.5,
        np.maximum(0.0, 1 - away**2 / 12),
        np.maximum(0.0, 1 - y**2 / 2),
    ]
    return [np.asarray(kind, dtype=np.float64) for kind in kinds]


if __name__ == "__main__":
    main()

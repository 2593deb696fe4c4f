"""The rim of a lens, whose face curves away from the pad along its edge and across it."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.control.track_edge import EdgeConfig, follow_edge
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.moves.edge_from_face import EdgeFromFaceConfig, _bent, _curvatures
from exploration.planning.touching.pad import PadConfig
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.pose import frame_along, pose

RIM = 32.0  # [mm] radius
LENS = Solid.from_csg(Sphere(40.0).at(0.0, 0.0, -24.0) & Sphere(40.0).at(0.0, 0.0, 24.0))


def test_the_rim_of_a_lens_is_followed():
    along, outward, normal = np.array([0.0, 1.0, 0.0]), np.array([0.6, 0.0, -0.8]), np.array([0.8, 0.0, 0.6])
    place = np.array([RIM, 0.0, 0.0]) - 1.0 * outward - 0.5 * normal
    start = pose(frame_along(-normal, along), place)
    spec = load_sensor("lts210")
    stage, arrays = simulate(LENS, [spec], np.random.default_rng(0), start_pose=start, latency=0.02)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    guard.pending.latency = 0.02
    found = follow_edge(guard, along, 20.0, 0, 0, config=EdgeConfig(curvatures=(1 / 40, 1 / 40)))
    assert found.ended == "length"
    radii = np.hypot(found.trace.points[:, 0], found.trace.points[:, 1])
    assert np.abs(radii - RIM).max() < 0.1
    assert np.ptp(found.trace.points[:, 2]) < 0.1
    tilts = np.degrees(np.arccos(np.clip(found.trace.normals @ normal, -1.0, 1.0)))
    assert tilts[0] < 3.0
    assert 25.0 < tilts[-1] < 31.0  # the face has turned along with the rim


@pytest.mark.parametrize(
    ("hessian", "whole", "felt"),
    [
        ([[0.025, 0.0], [0.0, 0.05]], 30, (0.05, 0.025)),
        ([[0.002, 0.0], [0.0, -0.02]], 30, (0.0, 0.0)),
        ([[0.025, 0.0], [0.0, 0.05]], 5, (0.0, 0.0)),
    ],
)
def test_how_a_face_is_curved_is_told_by_a_stroke_over_it(hessian, whole, felt):
    pad = SimpleNamespace(guard=SimpleNamespace(world_from_sensor=np.eye(4)))
    reading, cut = (SimpleNamespace(hessian=np.array(h), whole=w) for h, w in ((hessian, True), (9.0, False)))
    stroke = SimpleNamespace(readings=[reading] * whole + [cut] * 40)
    x, y, z = np.eye(3)
    edge = Sighting(np.zeros(3), y, x, z, 0.1, 10.0)
    assert _curvatures(pad, stroke, edge, EdgeFromFaceConfig()) == pytest.approx(felt)


@pytest.mark.parametrize(
    ("part", "top", "bent"),
    [(Cube((80.0, 9.0, 30.0)), 15.0, 0.0), (Cylinder(40.0, 80.0).turned("y", np.pi / 2), 40.0, 1 / 40)],
)
def test_a_thin_wall_is_not_curved_and_a_bar_is(over, part, top, bent):
    down = np.diag([1.0, -1.0, -1.0])
    guard, _ = over(part, pose(down, [0.0, 0.0, top - 0.5]), noise=0.01)
    pad = SimpleNamespace(guard=guard, config=PadConfig())
    x, y, z = np.eye(3)
    felt = _bent(pad, EdgeFromFaceConfig())
    assert y @ felt @ y == pytest.approx(bent, rel=0.1, abs=1e-9)
    assert np.abs([x @ felt @ x, z @ felt @ z]).max() < 0.003

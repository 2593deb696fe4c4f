"""An object is found from wherever the array has come to in looking for it."""

from contextlib import suppress

import numpy as np
import pytest

from exploration.devices.guard import Collision, Guard, OverPress
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.known.told import Told
from exploration.planning.moves.finding import Finding
from exploration.planning.touching.findings import ExplorerConfig, Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder, Sphere
from models.scene import Scene, table_under
from models.solid import Solid
from primitives import pose as se3

# (qw, qx, qy, qz) and [mm] of a bowl that the array comes to lie in, on its first way down
ASLANT = (
    [0.3185828276437135, -0.21269536111609105, -0.4892992919575719, 0.7834869929871524],
    [10.049954948945503, -4.998418216481209, 32.02278049967116],
)


def test_a_bowl_that_lies_aslant_lets_the_array_out_again():
    """Too round inside for a pad to lie in, and straight up from there its wall is in the way."""
    bowl = (Sphere(45.0) - Sphere(39.0)) & Cube((120.0, 120.0, 40.0)).at(0.0, 0.0, -20.0)
    specs, start = [load_sensor("lts210"), load_sensor("fingertip")], se3.pose(np.diag([1.0, -1.0, -1.0]))
    start[2, 3] = 300.0
    solid, rng = Solid.from_csg(bowl).placed(se3.from_quaternion(*ASLANT)), np.random.default_rng(0)
    stage, arrays = simulate(solid, specs, rng, noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(array.spec) for array in arrays])
    box = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])
    tools = Tool.each([array.spec for array in arrays], [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, box, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(), AttributionConfig())
    assert Finding(study, box, ExplorerConfig(max_touches=30), None).find()
    assert len(study.found.warnings) < 10


def test_a_pad_that_settles_onto_the_table_has_not_found_what_lies_on_it():
    """As where noise passes for a touch at the end of a way down."""
    plate = Solid.from_csg(Cube((70.0, 50.0, 7.0)))
    spec, start = load_sensor("lts210"), se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 90.0])
    scene, rng = Scene((plate, table_under(plate))), np.random.default_rng(0)
    stage, arrays = simulate(scene, [spec], rng, noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    box = np.array([-100.0, -100.0, -4.5, 100.0, 100.0, 100.0])
    told = Told(table_under(plate), np.array([[60.0, 60.0, -3.5]]), Tool.of(spec), -3.5)
    pad, down = Pad(guard, box, lambda kind, detail: None, told=told), []

    def come_down(*way):
        down.append(guard.world_from_sensor[:3, 3])
        if len(down) > 1:
            return Pad.come_down(pad, *way)
        guard.go_to(se3.pose(np.diag([1.0, -1.0, -1.0]), [60.0, 60.0, -3.9]))
        return True

    pad.come_down = come_down
    assert Finding(Study(pad, Findings(), AttributionConfig()), box, ExplorerConfig(), told).find()
    assert len(down) > 1
    assert np.abs(guard.world_from_sensor[:3, 3]).max() < 50.0
    assert guard.world_from_sensor[2, 3] > 2.5


def over_nothing(size=(70.0, 50.0, 20.0)):
    """A pad high over a block at noise of 5 %, and its box."""
    spec, start = load_sensor("lts210"), se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 140.0])
    solid, rng = Solid.from_csg(Cube(size)), np.random.default_rng(0)
    stage, arrays = simulate(solid, [spec], rng, noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    box = np.array([-150.0, -150.0, -150.0, 150.0, 150.0, 150.0])
    return Pad(guard, box, lambda kind, detail: None), box


def test_noise_alone_is_no_touch():
    pad, _ = over_nothing()
    assert not any(pad.touches() for _ in range(2500))


def test_the_search_goes_on_where_what_passed_for_a_touch_was_none():
    pad, box = over_nothing((16.0, 16.0, 16.0))  # right below, where a way was cut short
    study = Study(pad, Findings(), AttributionConfig())
    finding, come_down = Finding(study, box, ExplorerConfig(), None), pad.come_down
    pad.come_down = lambda *way: True
    assert finding.find()
    pad.come_down = come_down
    for _ in range(12):
        if pad.felt and study.found.graph.faces:
            break
        finding.look_again()
    assert study.found.graph.faces


def test_a_place_that_always_passes_for_a_touch_does_not_hold_the_search():
    pad, box = over_nothing((120.0, 120.0, 20.0))
    study = Study(pad, Findings(), AttributionConfig())
    finding, come_down = Finding(study, box, ExplorerConfig(), None), pad.come_down

    def disturbed(*way):
        middle = np.abs(pad.guard.world_from_sensor[:2, 3]).max() < 1.0
        return True if middle else come_down(*way)

    pad.come_down = disturbed
    assert finding.find()
    for _ in range(30):
        if study.found.graph.faces:
            break
        finding.look_again()
    assert study.found.graph.faces


@pytest.mark.slow
def test_a_thin_rod_is_come_at_along_itself_from_one_side_and_another():
    """A pad that leans along it would meet it with its housing."""
    rod, down = Solid.from_csg(Cylinder(1.5, 80.0).turned("y", np.pi / 2)), np.diag([1.0, -1.0, -1.0])
    spec, rng = load_sensor("lts210"), np.random.default_rng(0)
    stage, arrays = simulate(rod, [spec], rng, noise=0.01, start_pose=se3.pose(down, [0.0, 0.0, 60.0]))
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    box = np.array([-100.0, -100.0, -100.0, 100.0, 100.0, 100.0])
    pad = Pad(guard, box, lambda kind, detail: None)
    finding = Finding(Study(pad, Findings(), AttributionConfig()), box, ExplorerConfig(), None)
    guard.go_to(se3.pose(down, [0.0, 0.0, 8.0]))
    cells = np.column_stack([np.arange(-12.0, 13.0, 2.0), np.zeros(13), np.full(13, 1.5)])
    pad.felt.append((cells, np.tile([0.6, 0.0, 0.8], (13, 1))))  # taken to lean, as at a rod's end
    touch, lain = pad.touch, []

    def noted(target, *how):
        settled = touch(target, *how)
        lain.append((target[:3, 2], settled))
        return settled

    pad.touch = noted
    for _ in range(4):
        with suppress(Collision, OverPress):
            finding.look_again()
    ways = np.array([way for way, settled in lain if settled])
    assert len(ways) >= 3
    assert np.abs(ways[:, 0]).max() < 0.1  # none leans along the rod,
    assert np.ptp(ways[:, 1]) > 0.5  # and they come from several sides

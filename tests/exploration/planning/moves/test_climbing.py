"""What stops a stroke is climbed where it is a step, and where it is none that is told."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.climbing import Climbing, ClimbingConfig
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study, Wall
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives import pose as se3

UP, AHEAD = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
SPEC = load_sensor("lts210")
BOX = np.array([-120.0, -120.0, -60.0, 120.0, 120.0, 120.0])
HEIGHT = 5.0  # [mm] of the step, a disc of 25 mm radius on a block whose top is at 0


@pytest.fixture
def study():
    """Over the block, of which nothing is known."""
    tree = Cube((120.0, 120.0, 20.0)).at(0.0, 0.0, -10.0) | Cylinder(25.0, 2.0 * HEIGHT)
    high = se3.pose(se3.frame_along(-UP), [-45.0, 0.0, 60.0])
    stage, arrays = simulate(Solid.from_csg(tree), [SPEC], np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    tools = Tool.each([SPEC], [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(hollow=True), AttributionConfig(convex=False))
    assert pad.touch(se3.pose(pad.attitude(UP, AHEAD), [-45.0, 0.0, 0.0]), 10.0, 10.0)
    study.face_here()
    return study


def stop(study, at, heading=AHEAD):
    """As a stroke that met something there leaves it."""
    pose = se3.pose(study.pad.attitude(UP, AHEAD), np.asarray(at) - 14.4 * heading)
    return Wall(np.asarray(at), heading, UP, pose, np.abs(study.pad.tool.high[:2]))


def test_a_step_too_low_to_be_faced_is_felt_from_over_it(study):
    climbing, wall = Climbing(study, Reach(study.pad)), stop(study, [-25.0, 0.0, 0.0])
    face, note = climbing.next([wall])()
    top = study.found.fit_of(face)
    assert note == "came down on what had stopped a stroke"
    assert top.kind == "plane"
    assert top.shape.signed_distance(np.array([[0.0, 0.0, HEIGHT]]))[0] == pytest.approx(0.0, abs=0.05)
    assert climbing.next([wall]) is None
    assert Climbing(study, Reach(study.pad)).next([wall]) is None  # whose top is known by now


def test_where_nothing_stands_that_is_told(study):
    wall = stop(study, [10.0, 42.0, 0.0], np.array([0.0, 1.0, 0.0]))
    _, note = Climbing(study, Reach(study.pad)).next([wall])()
    assert note == "nothing stands on the face where a stroke was stopped"


def test_a_stop_over_all_that_was_felt_is_looked_beyond_as_well(study):
    wall = stop(study, [10.0, 42.0, 3.0], np.array([0.0, 1.0, 0.0]))
    assert Climbing(study, Reach(study.pad)).next([wall]) is not None


def test_where_there_is_nothing_at_all_the_array_goes_past(study):
    wall = stop(study, [-75.0, 0.0, 0.0], -AHEAD)
    move = Climbing(study, Reach(study.pad)).next([wall])
    assert move()[1] == "nothing was beyond where a stroke was stopped"


def test_steps_that_are_never_there_are_soon_given_up(study):
    config = replace(ClimbingConfig(), vain=2)
    climbing, moves = Climbing(study, Reach(study.pad), config), 0
    walls = [stop(study, [-75.0, y, 0.0], -AHEAD) for y in (-40.0, -20.0, 0.0, 20.0, 40.0)]
    while (move := climbing.next(walls)) is not None:
        move()
        moves += 1
    assert moves == 2

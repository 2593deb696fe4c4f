"""Rims are rolled over, soonest first, and those of a face that lead nowhere are left alone."""

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.rolling import Rolling, RollingConfig
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3

UP, X, Y = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
SPEC = load_sensor("lts210")
BOX = np.array([-150.0, -150.0, -150.0, 150.0, 150.0, 150.0])


@pytest.fixture
def study():
    """On top of a block of 80 x 80 x 60 mm, whose top is at 30."""
    high = se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    solid = Solid.from_csg(Cube((80.0, 80.0, 60.0)))
    stage, arrays = simulate(solid, [SPEC], np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    tools = Tool.each([SPEC], [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(hollow=True), AttributionConfig(convex=False))
    assert pad.touch(se3.pose(pad.attitude(UP, X), [0.0, 0.0, 30.0]), 10.0, 10.0)
    study.face_here()
    return study


def edge(out, along, off=0.0):
    """An edge of the top, `off` mm beside where one is."""
    return Sighting(30.0 * UP + (40.0 + off) * out, along, out, UP, 0.05, 20.0)


def test_a_rim_leads_to_the_face_behind_it(study):
    ((_, roll),) = Rolling(study, Reach(study.pad)).ways([(edge(X, Y), 0)])
    face, note = roll()
    assert note == "crossed a rim"
    assert study.found.fit_of(face).shape.normals(np.zeros((1, 3)))[0] @ X > 0.999


def test_the_rim_beside_the_pad_is_sooner_come_to_than_one_on_the_far_side(study):
    assert Reach(study.pad).touch(se3.pose(study.pad.attitude(UP, X), [20.0, 0.0, 30.0]))
    (near, _), (far, _) = Rolling(study, Reach(study.pad)).ways([(edge(X, Y), 0), (edge(-X, Y), 0)])
    assert near < far


def test_rims_of_a_face_that_lead_to_nothing_new_are_left_alone(study):
    rolling = Rolling(study, Reach(study.pad), RollingConfig(vain=2, tries=9))
    nowhere = [(edge(X, Y, 30.0), 0), (edge(-X, Y, 30.0), 0)]
    for _ in range(2):
        rolling.ways(nowhere)[0][1]()
    assert not rolling.ways(nowhere)
    assert rolling.ways([(edge(X, Y), 1)])  # where another face ends


def test_a_rim_that_leads_on_gives_its_face_credit_again(study):
    rolling = Rolling(study, Reach(study.pad), RollingConfig(vain=2, tries=9))
    rolling.ways([(edge(X, Y, 30.0), 0)])[0][1]()
    rolling.ways([(edge(X, Y), 0)])[0][1]()
    rolling.ways([(edge(X, Y, 30.0), 0)])[0][1]()
    assert rolling.ways([(edge(Y, X), 0)])

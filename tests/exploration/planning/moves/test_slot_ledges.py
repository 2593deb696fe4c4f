"""A small array finds the floor of a pocket whose middle is a hole."""

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.slot_ledges import SlotLedges
from exploration.planning.open.mouths import Mouth
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

UP, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
SPECS = [load_sensor("fingertip")]
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
PLATE, SLOT = Cube((80.0, 60.0, 14.0)), Cube((11.0, 40.0, 30.0))
MOUTH = Mouth(np.array([0.0, 0.0, 7.0]), UP, ACROSS, 26.0)
BEHIND = Mouth(np.array([0.0, 1.0, -7.0]), -UP, -ACROSS, 11.0)


def explored(tree):
    solid, high = Solid.from_csg(tree), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(solid, SPECS, np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(spec) for spec in SPECS])
    tools = Tool.each(SPECS, [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(hollow=True), AttributionConfig(convex=False))
    return SlotLedges(study, Reach(pad)), study.found


@pytest.mark.parametrize("deep", [3.0, 9.0])
def test_the_ledges_beside_a_slot_in_a_pocket_s_floor_are_one_face(deep):
    pocket = Cube((26.0, 46.0, 20.0)).at(0.0, 0.0, 17.0 - deep)
    ledges, found = explored(PLATE - SLOT - pocket)
    ledges.went_through(MOUTH)
    assert ledges.next([MOUTH, BEHIND]) is MOUTH
    home, note = ledges.feel([MOUTH, BEHIND])
    assert note == "felt a ledge in a mouth"
    (floor,) = found.graph.faces
    assert floor.id == home
    assert floor.contacts.points[:, 2] == pytest.approx(7.0 - deep, abs=0.2)
    assert np.ptp(floor.contacts.points[:, 0]) > 11.0
    assert ledges.next([MOUTH, BEHIND]) is None


def test_a_window_as_wide_behind_is_not_gone_into_again():
    ledges, _ = explored(PLATE - Cube((26.0, 46.0, 30.0)))
    ledges.went_through(MOUTH)
    assert ledges.next([MOUTH, Mouth(BEHIND.center, -UP, -ACROSS, 26.0)]) is None


def test_where_the_other_side_is_not_known_a_window_s_sides_are_asked_for_once():
    ledges, found = explored(PLATE - Cube((26.0, 46.0, 30.0)))
    ledges.went_through(MOUTH)
    assert ledges.feel([MOUTH]) == (None, "felt no ledge in a mouth")
    assert found.graph.faces == ()
    assert ledges.next([MOUTH]) is None


def test_a_mouth_hardly_wider_than_the_array_has_no_room_for_a_ledge_beside_it():
    ledges, _ = explored(PLATE - SLOT)
    ledges.went_through(Mouth(MOUTH.center, UP, ACROSS, 11.0))
    assert ledges.next([]) is None

"""A small array finds out how a hole narrows that it has room in beside the axis."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.ledges import Ledges
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cone, Cube, Cylinder
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts

UP = np.array([0.0, 0.0, 1.0])
SPECS = [load_sensor("fingertip")]
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
PLATE = Cube((80.0, 60.0, 14.0)) - Cylinder(6.0, 30.0)
WIDE = RoundRim(np.array([0.0, 0.0, 7.0]), UP, 13.0, 0.02, 0, measured=True)
FAR = RoundRim(np.array([0.0, 0.0, -7.0]), -UP, 6.0, 0.02, 1, measured=True)


def explored(tree, rims):
    solid, high = Solid.from_csg(tree), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(solid, SPECS, np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(spec) for spec in SPECS])
    tools = Tool.each(SPECS, [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(hollow=True, rims=list(rims)), AttributionConfig(convex=False))
    return Ledges(study, Reach(pad)), study.found


@pytest.mark.parametrize("deep", [3.0, 9.0])
def test_it_is_stopped_as_deep_twice_by_a_ledge(deep):
    ledges, found = explored(PLATE - Cylinder(13.0, 20.0).at(0.0, 0.0, 17.0 - deep), [WIDE, FAR])
    move = ledges.next([])
    assert move is not None
    move()
    assert len(found.stopped) == 2
    assert np.allclose([stop.deep for stop in found.stopped], deep, atol=0.15)
    assert ledges.next([]) is None


def test_a_ledge_hardly_wider_than_the_room_beside_the_array_is_reached():
    wide, far = replace(WIDE, radius=12.7), replace(FAR, radius=9.8)
    hole = Cylinder(9.8, 30.0) | Cylinder(12.7, 20.0).at(0.0, 0.0, 9.0)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - hole, [wide, far])
    ledges.next([])()
    (stop,) = found.stopped
    assert stop.deep == pytest.approx(8.0, abs=0.15)


def test_it_is_stopped_deeper_nearer_to_the_axis_by_a_slope():
    sink = Cone(0.0, 13.0, 13.0).at(0.0, 0.0, 0.5)
    ledges, found = explored(PLATE - sink, [WIDE, FAR])
    ledges.next([])()
    outer, inner = found.stopped
    assert outer.off - inner.off == pytest.approx(2.5, abs=0.6)
    for stop in found.stopped:
        assert stop.deep == pytest.approx(13.0 - stop.off, abs=1.6)
    assert inner.deep - outer.deep > 1.5


def test_a_straight_hole_or_one_without_room_is_left_alone():
    assert explored(PLATE, [FAR])[0].next([]) is None
    tight = RoundRim(WIDE.center, UP, 5.0, 0.02, 0, measured=True)
    thin = RoundRim(FAR.center, -UP, 2.0, 0.02, 1, measured=True)
    ledges, found = explored(PLATE, [tight, thin])
    move = ledges.next([])
    assert move is None or move()[0] is None
    assert found.stopped == []


def test_a_floor_beside_a_slanting_bore_is_felt_and_a_plain_hole_is_not_gone_into():
    slanting = Cylinder(6.0, 60.0).turned("y", 0.3)
    wide = Cylinder(15.0, 20.0).at(0.0, 0.0, 7.0)
    lone = RoundRim(np.array([0.0, 0.0, 7.0]), UP, 15.0, 0.02, 0, measured=True)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - slanting - wide, [lone])
    home, note = ledges.next([])()
    assert note == "felt a floor beside the middle of a hole"
    (floor,) = [face for face in found.graph.faces if face.id == home]
    assert floor.fit.kind == "plane"
    assert np.median(floor.contacts.points[:, 2]) == pytest.approx(-3.0, abs=0.1)
    assert ledges.next([]) is None
    through = RoundRim(FAR.center, -UP, 15.0, 0.02, 1, measured=True)
    assert explored(PLATE - Cylinder(15.0, 20.0), [lone, through])[0].next([]) is None


def test_nothing_is_felt_beside_the_middle_of_a_hole_without_a_floor():
    lone = RoundRim(np.array([0.0, 0.0, 7.0]), UP, 15.0, 0.02, 0, measured=True)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - Cylinder(15.0, 30.0), [lone])
    assert ledges.next([])() == (None, "felt no floor beside the middle of a hole")
    assert found.graph.faces == ()


@pytest.mark.parametrize("radius", [6.3, 8.0])
def test_a_blind_hole_hardly_wider_than_the_array_is_felt_to_its_end(radius):
    rim = RoundRim(np.array([0.0, 0.0, 7.0]), UP, radius, 0.02, 0, measured=True)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - Cylinder(radius, 14.0).at(0.0, 0.0, 4.0), [rim])
    home, note = ledges.next([])()
    assert note == "felt where a hole ends"
    (floor,) = [face for face in found.graph.faces if face.id == home]
    assert floor.contacts.points[:, 2] == pytest.approx(-3.0, abs=0.1)
    assert ledges.next([]) is None


def test_a_hole_that_goes_through_or_is_too_narrow_shows_no_end():
    rim = RoundRim(np.array([0.0, 0.0, 7.0]), UP, 7.0, 0.02, 0, measured=True)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - Cylinder(7.0, 30.0), [rim])
    assert ledges.next([])() == (None, "went down a hole and met nothing")
    assert found.graph.faces == ()
    narrow = RoundRim(rim.center, UP, 5.9, 0.02, 0, measured=True)
    guessed = RoundRim(rim.center, UP, 7.0, 1.0, 0)
    for other in (narrow, guessed):
        assert explored(PLATE, [other])[0].next([]) is None


def test_an_end_that_a_first_frame_does_not_tell_is_pressed_again_at_another_turn():
    rim = RoundRim(np.array([0.0, 0.0, 7.0]), UP, 8.0, 0.02, 0, measured=True)
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - Cylinder(8.0, 14.0).at(0.0, 0.0, 4.0), [rim])
    feel, told, turns = ledges.study.pad.feel, [], []

    def doubtful():
        turns.append(ledges.study.pad.guard.world_from_sensor[:3, 0])
        told.append(feel() if turns[1:] else Contacts.of([]))
        return told[-1]

    ledges.study.pad.feel = doubtful
    home, note = ledges.next([])()
    assert note == "felt where a hole ends"
    assert abs(turns[0] @ turns[1]) < 0.8
    assert found.graph.faces[0].id == home
    ledges, found = explored(Cube((80.0, 60.0, 14.0)) - Cylinder(8.0, 14.0).at(0.0, 0.0, 4.0), [rim])
    ledges.study.pad.feel = lambda: Contacts.of([])
    assert ledges.next([])() == (None, "went down a hole and met what told no face")

"""An array goes into a hole and aside, and is stopped where the wall is, whatever the rim looks like."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.bores import Bores
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Bore, Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cone, Cube, Cylinder, Sphere
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, PatchGraph

UP = np.array([0.0, 0.0, 1.0])
SPECS = [load_sensor("fingertip")]
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
PLATE = Cube((80.0, 60.0, 16.0))
RIM = RoundRim(np.array([0.0, 0.0, 8.0]), UP, 12.0, 0.02, 0, measured=True)


def explored(tree, rims, faces=()):
    solid, high = Solid.from_csg(tree), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(solid, SPECS, np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(spec) for spec in SPECS])
    tools = Tool.each(SPECS, [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    found = Findings(graph=PatchGraph(tuple(faces)), hollow=True, rims=list(rims))
    study = Study(pad, found, AttributionConfig(convex=False))
    return Bores(study, Reach(pad)), study.found


def felt(tree, rim=RIM):
    bores, found = explored(tree, [rim])
    move = bores.next()
    assert move is not None
    home, note = move()
    assert home is None
    assert bores.next() is None
    return found.bores, note


@pytest.mark.parametrize("chamfer", [0.0, 1.0, 2.5])
def test_a_hole_is_as_wide_as_its_wall_and_not_as_its_rim(chamfer):
    sink = Cone(12.0 - chamfer - 4.0, 12.0, chamfer + 4.0) if chamfer else Cylinder(12.0, 1.0)
    tree = PLATE - Cylinder(12.0 - chamfer, 40.0) - sink.at(0.0, 0.0, 8.0 - 0.5 * (chamfer + 4.0))
    (bore,), note = felt(tree)
    assert note == "felt the wall of a hole"
    assert bore.radius == pytest.approx(12.0 - chamfer, abs=0.08)
    assert np.linalg.norm(bore.center - RIM.center) < 0.08


def test_its_wall_is_felt_above_a_floor_and_off_the_middle_of_a_rim_that_was_misread():
    (bore,), _ = felt(PLATE - Cylinder(11.0, 9.0).at(0.3, 0.0, 8.0))
    assert bore.radius == pytest.approx(11.0, abs=0.08)
    assert bore.center[:2] == pytest.approx([0.3, 0.0], abs=0.08)
    assert 3.0 < bore.deep < 4.2


def test_a_step_further_down_does_not_make_it_narrow():
    (bore,), _ = felt(PLATE - Cylinder(9.0, 40.0) - Cylinder(12.0, 14.0).at(0.0, 0.0, 8.0))
    assert bore.radius == pytest.approx(12.0, abs=0.08)


def test_a_shallow_hole_and_one_without_room_or_a_look_tell_nothing():
    assert felt(PLATE - Cylinder(12.0, 5.0).at(0.0, 0.0, 8.0))[0] == []
    tight, guessed = replace(RIM, radius=6.5), replace(RIM, measured=False)
    assert explored(PLATE, [tight, guessed])[0].next() is None


def test_a_hole_is_gone_into_from_one_end_and_not_where_it_was_felt():
    other = replace(RIM, center=-RIM.center, axis=-UP)
    bores, found = explored(PLATE - Cylinder(12.0, 40.0), [RIM, other])
    bores.next()()
    assert len(found.bores) == 1
    assert bores.next() is None
    bores, found = explored(PLATE - Cylinder(12.0, 40.0), [RIM])
    found.bores.append(Bore(RIM.center, -UP, 12.0, 5.0))
    assert bores.next() is None


def test_a_mouth_in_a_round_face_is_felt_below_its_rim_and_its_other_end_is_left_to_do():
    ways = np.random.default_rng(1).normal(size=(80, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    contacts = Contacts.of(40.0 * ways, ways, 0.02, 0.02)
    ball = Face(0, fit("sphere", contacts), contacts)
    lean = np.array([0.02, 0.0, np.sqrt(1.0 - 0.02**2)])
    gap = RoundRim(40.0 * lean, lean, 17.0, 0.3, 0, measured=True, bent=True)
    bores, found = explored(Sphere(40.0) - Cylinder(18.0, 100.0), [], [ball])
    bores.next([gap])()
    (bore,) = found.bores
    assert bore.radius == pytest.approx(18.0, abs=0.08)
    assert np.linalg.norm(bore.center[:2]) < 0.1
    assert bore.axis @ UP == pytest.approx(1.0, abs=1e-4)
    assert bores.next([gap]) is None
    assert bores.next([replace(gap, center=-gap.center, axis=-gap.axis)]) is not None

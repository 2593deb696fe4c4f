import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.inferring.inferred_walls import inferred_walls
from exploration.planning.moves.entering import Entering, EnteringConfig
from exploration.planning.open.mouths import Mouth, MouthConfig, gathered, lids, mouths
from exploration.planning.touching.findings import ExplorerConfig, Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.parts import build
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts

UP = np.array([0.0, 0.0, 1.0])
SPECS = [load_sensor("lts210"), load_sensor("fingertip")]
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])


def top_of_slotted_block():
    """What was touched of the top of a block with a slot 16 mm wide, and the slot's rims with the ways out."""
    x, y = np.meshgrid(
        [*np.arange(-29.0, -8.0, 2.0), *np.arange(9.0, 30.0, 2.0)], np.arange(-24.0, 25.0, 2.0)
    )
    cells = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 15.0)])
    rim = cells[np.abs(cells[:, 0]) < 10.0]
    return cells, rim, -np.sign(rim[:, :1]) * np.array([[1.0, 0.0, 0.0]])


def test_a_mouth_is_as_wide_as_the_first_place_straight_ahead_is_far():
    rng = np.random.default_rng(3)
    cells, rim = rng.uniform(-60.0, 60.0, (400, 3)), rng.uniform(-60.0, 60.0, (200, 3))
    out = rng.normal(size=(200, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    told = []
    for place, way in zip(rim, out, strict=True):
        ahead = (cells - place) @ way
        beside = np.linalg.norm(cells - place - ahead[:, None] * way, axis=1)
        far = ahead[(beside < MouthConfig.aside) & (ahead > MouthConfig.least) & (ahead < MouthConfig.most)]
        told += [far.min()] if len(far) else []
    assert len(told) > 20
    assert np.allclose([mouth.width for mouth in mouths(cells, rim, out, UP)], told)


def test_a_slot_has_one_mouth_with_its_middle_over_the_slots():
    cells, rim, out = top_of_slotted_block()
    found = mouths(cells, rim, out, UP)
    ((mouth, *_),) = gathered(found)
    assert np.abs(mouth.center - [0.0, 0.0, 15.0]).max() < 1.1
    assert mouth.width == pytest.approx(18.0)
    places, facing = lids(found)
    assert np.abs(places[:, 0]).max() < 9.0
    assert (facing == UP).all()


def test_a_rim_with_nothing_beyond_it_has_no_mouth():
    cells, _, _ = top_of_slotted_block()
    edge = cells[cells[:, 0] > 28.0]
    assert mouths(cells, edge, np.tile([[1.0, 0.0, 0.0]], (len(edge), 1)), UP) == []


@pytest.fixture
def over_slot():
    """Both arrays back to back over the block, whose top is known."""
    solid, high = Solid.from_csg(build("slotted_block")), se3.pose(None, [0.0, 0.0, 200.0])
    stage, arrays = simulate(solid, SPECS, np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(spec) for spec in SPECS])
    tools = Tool.each(SPECS, [array.flange_from_sensor for array in arrays])
    reach = Reach(Pad(guard, BOX, lambda kind, detail: None, tools=tools))
    cells, rim, out = top_of_slotted_block()
    reach.pad.felt.append((cells, np.tile(UP, (len(cells), 1))))
    return reach, guard, mouths(cells, rim, out, UP)


def test_the_finger_goes_into_a_slot_that_the_pad_has_no_room_in_and_comes_straight_out(over_slot):
    reach, guard, across = over_slot
    reach.lids = lids(across)
    into = se3.pose(se3.frame_along(-UP, [1.0, 0.0, 0.0]), [0.0, 0.0, 13.0])
    assert not reach.clear(into)
    guard.use(1)
    assert reach.clear(into)
    assert reach.sound(into)
    assert guard.world_from_sensor[2, 3] == pytest.approx(-0.45, abs=0.1)
    along_the_floor = into @ se3.pose(None, [0.0, 10.0, 13.0])
    assert reach.touch(along_the_floor)
    assert np.abs(guard.world_from_sensor[:3, 3] - along_the_floor[:3, 3]).max() < 0.6
    reach.come_out()
    assert guard.world_from_sensor[2, 3] > 22.0


def test_a_face_that_was_foreseen_at_a_wrong_angle_is_come_at_from_farther_off(over_slot):
    reach, guard, _ = over_slot
    foreseen = np.array([np.cos(0.45), np.sin(0.45), 0.0])
    target = se3.pose(reach.pad.attitude(foreseen, np.cross(UP, foreseen)), [30.0, 0.0, 8.0])
    assert not reach.touch(target)
    assert not reach.led
    assert reach.touch(target, give=True)
    assert guard.world_from_sensor[:3, 2] == pytest.approx([-1.0, 0.0, 0.0], abs=0.02)


def test_on_the_floor_of_a_slot_both_its_walls_are_found(over_slot):
    reach, guard, across = over_slot
    study = Study(reach.pad, Findings(), ExplorerConfig().attribution)
    entering = Entering(study, reach)
    assert not list(entering.ways_in(across, lambda normal: []))
    guard.use(1)
    ((_, move),) = entering.ways_in(across, lambda normal: [])
    face, _ = move()
    floor = study.found.fit_of(face).shape
    assert abs(floor.signed_distance(np.zeros((1, 3)))[0]) < 0.01
    assert len(study.walls) == 4
    places = np.array([[30.0, y, z] for y in (-9.0, 9.0) for z in (-9.0, 0.0, 9.0)])
    side = Contacts.of(places, np.tile([[1.0, 0.0, 0.0]], (6, 1)), 0.01, 0.002)
    study.found.graph, _ = study.found.graph.add_stroke(side)
    walls = inferred_walls(study.walls, study.found.graph.faces)
    assert sorted(float(np.median(lot.points[:, 0])) for lot in walls) == pytest.approx([-8.0, 8.0], abs=0.15)


def test_a_mouth_that_was_sounded_in_vain_is_sounded_elsewhere(over_slot):
    reach, guard, across = over_slot
    entering = Entering(Study(reach.pad, Findings(), ExplorerConfig().attribution), reach)
    guard.use(1)
    ((middle, _),) = entering.ways_in(across, lambda normal: [])
    entering._sounded.note(middle)
    beside = [place for place, _ in entering.ways_in(across, lambda normal: [])]
    assert [9.0 < abs(place[1] - middle[1]) < 24.0 for place in beside] == [True, True]


@pytest.mark.parametrize(("times", "left"), [(3, True), (4, False)])
def test_a_wide_mouth_that_arrays_came_through_again_and_again_is_left_alone(over_slot, times, left):
    reach, guard, _ = over_slot
    entering = Entering(Study(reach.pad, Findings(), ExplorerConfig().attribution), reach)
    guard.use(1)
    wide = [Mouth(np.array([x, 0.0, 15.0]), UP, np.array([0.0, 1.0, 0.0]), 60.0) for x in (-14.0, 0.0, 14.0)]
    for place in np.linspace(-24.0, -10.0, times):
        entering._through.note(np.array([0.0, place, 15.0]))
    assert bool(list(entering.ways_in(wide, lambda normal: [np.array([1.0, 0.0, 0.0])]))) == left


@pytest.mark.parametrize(("left", "ways"), [(36.0, 1), (-5.0, 0)])
def test_a_floor_in_the_slot_tells_what_is_behind_its_mouth_and_one_beyond_its_land_does_not(
    over_slot, left, ways
):
    reach, guard, across = over_slot
    study = Study(reach.pad, Findings(), ExplorerConfig().attribution)
    x, y = np.meshgrid(left + np.arange(0.0, 10.0, 2.0), np.arange(-20.0, 21.0, 4.0))
    cells = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    reach.pad.felt.append((cells, np.tile(UP, (len(cells), 1))))
    for places in (cells, top_of_slotted_block()[0]):
        flat = Contacts.of(places, np.tile(UP, (len(places), 1)), 0.01, 0.002)
        study.found.graph, _ = study.found.graph.add_stroke(flat)
    entering = Entering(study, reach, EnteringConfig(known=60.0))
    guard.use(1)
    assert len(list(entering.ways_in(across, lambda normal: []))) == ways


def test_a_step_that_a_slot_opens_onto_is_no_floor_of_it(over_slot):
    reach, guard, across = over_slot
    study = Study(reach.pad, Findings(), ExplorerConfig().attribution)
    x, y = np.meshgrid(np.arange(-5.0, 6.0, 2.0), np.arange(28.0, 40.0, 2.0))
    cells = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    reach.pad.felt.append((cells, np.tile(UP, (len(cells), 1))))
    step = Contacts.of(cells, np.tile(UP, (len(cells), 1)), 0.01, 0.002)
    study.found.graph, _ = study.found.graph.add_stroke(step)
    entering = Entering(study, reach, EnteringConfig(known=60.0))
    guard.use(1)
    assert len(list(entering.ways_in(across, lambda normal: []))) == 1


def over(tree):
    """The finger alone, over a body."""
    high = se3.pose(se3.frame_along(-UP), [0.0, 0.0, 80.0])
    stage, arrays = simulate(Solid.from_csg(tree), SPECS[1:], np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(SPECS[1])])
    tools = Tool.each(SPECS[1:], [array.flange_from_sensor for array in arrays])
    return Reach(Pad(guard, BOX, lambda kind, detail: None, tools=tools))


NARROW = Cube((60.0, 50.0, 30.0)) - Cube((10.0, 60.0, 20.0)).at(0.0, 0.0, 13.0)


def test_where_a_narrow_slot_comes_out_in_a_bore_the_finger_lies_on_its_floor_as_it_came():
    reach = over(NARROW - Cylinder(15.0, 40.0))
    entering = Entering(Study(reach.pad, Findings(), ExplorerConfig().attribution), reach)
    at_end = se3.pose(se3.frame_along(-UP, [1.0, 0.0, 0.0]), [0.2, 16.1, 13.0])
    assert not reach.sound(at_end)
    reach.come_out()
    assert entering._met(at_end)
    assert reach.pad.guard.world_from_sensor[2, 3] == pytest.approx(2.6, abs=0.4)


def test_in_a_slot_hardly_wider_than_itself_the_finger_turns_along_it():
    reach = over(NARROW)
    cells, rim, out = top_of_slotted_block()
    cells[:, 0] -= 3.0 * np.sign(cells[:, 0])
    rim[:, 0] -= 3.0 * np.sign(rim[:, 0])
    reach.pad.felt.append((cells, np.tile(UP, (len(cells), 1))))
    study = Study(reach.pad, Findings(), ExplorerConfig().attribution)
    slanting = np.array([np.cos(0.7), np.sin(0.7), 0.0])
    ((_, move),) = Entering(study, reach).ways_in(mouths(cells, rim, out, UP), lambda normal: [slanting])
    face, note = move()
    assert note == "went in and felt a floor and its walls"
    assert np.median(study.found.graph.faces[face].contacts.points[:, 2]) == pytest.approx(3.0, abs=0.1)


def test_the_floor_of_one_slot_says_nothing_of_the_next(over_slot):
    reach, guard, _ = over_slot
    study = Study(reach.pad, Findings(), ExplorerConfig().attribution)
    x, y = np.meshgrid(np.arange(-3.0, 4.0, 2.0), np.arange(-24.0, 25.0, 2.0))
    land, floor, found = np.column_stack([x.ravel(), y.ravel()]), np.empty((0, 2)), []
    for middle in (-12.0, 12.0):  # two slots 16 mm wide with a land of 8 mm between
        sides = np.array([[side * 21.0, v] for side in (-1.0, 1.0) for v in np.arange(-24.0, 25.0, 2.0)])
        cells = np.column_stack([np.concatenate([land, sides]), np.full(len(land) + len(sides), 15.0)])
        rim = cells[np.abs(np.abs(cells[:, 0] - middle) - 9.0) < 1e-6]
        ways = np.sign(middle - rim[:, :1]) * np.array([[1.0, 0.0, 0.0]])
        found += mouths(cells, rim, ways, UP)
        floor = np.column_stack([land[:, 0] - 12.0, land[:, 1], np.zeros(len(land))])
    top = np.column_stack([land, np.full(len(land), 15.0)])
    reach.pad.felt.clear()
    for places in (floor, top):
        reach.pad.felt.append((places, np.tile(UP, (len(places), 1))))
        flat = Contacts.of(places, np.tile(UP, (len(places), 1)), 0.01, 0.002)
        study.found.graph, _ = study.found.graph.add_stroke(flat)
    guard.use(1)
    entering = Entering(study, reach, EnteringConfig(known=60.0))
    assert [place[0] for place, _ in entering.ways_in(found, lambda normal: [])] == [12.0]

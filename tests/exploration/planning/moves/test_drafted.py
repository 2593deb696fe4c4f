"""What a draft of the object has, and nobody felt, is touched where it is."""

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.drafted import SPACING, Drafted, DraftedConfig
from exploration.planning.moves.looking import Looking
from exploration.planning.open.frontier import Predicted
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

UP, ALONG = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
SPEC = load_sensor("lts210")
BOX = np.array([-120.0, -120.0, -60.0, 120.0, 120.0, 120.0])


@pytest.fixture
def study():
    """Over a block whose top is at 0, touched once in a corner."""
    solid = Solid.from_csg(Cube((120.0, 90.0, 20.0)).at(0.0, 0.0, -10.0))
    high = se3.pose(se3.frame_along(-UP), [-40.0, -30.0, 60.0])
    stage, arrays = simulate(solid, [SPEC], np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    tools = Tool.each([SPEC], [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    assert pad.touch(se3.pose(pad.attitude(UP, ALONG), [-40.0, -30.0, 0.0]), 10.0, 10.0)
    pad.feel()
    return Study(pad, Findings(hollow=True), AttributionConfig(convex=False))


def level(z, wide=(60.0, 45.0)):
    """A draft whose surface is flat, at a height."""
    x, y = (np.arange(-half + 1.0, half, SPACING) for half in wide)
    points = np.stack(np.meshgrid(x, y, [z]), axis=-1).reshape(-1, 3)
    return Predicted(points, np.tile(UP, (len(points), 1)), np.zeros(len(points), dtype=np.int64))


def moves_of(study, surface):
    """What all touches of one draft did."""
    reach = Reach(study.pad)
    drafted = Drafted(study, reach, lambda: surface, lambda normal: [ALONG], Looking(study, reach))
    notes = []
    while (move := drafted.next()) is not None:
        notes.append(move()[1])
    return notes


def test_nothing_of_a_draft_is_known_where_nothing_was_felt(study):
    study.pad.felt.clear()
    assert moves_of(study, level(0.0))


def test_all_of_a_draft_that_is_there_is_felt(study):
    notes = moves_of(study, level(0.0))
    assert set(notes) == {"touched what a draft of the object has"}
    felt = np.concatenate([points for points, _ in study.pad.felt])
    assert np.abs(felt[:, 2]).max() < 0.6
    far = np.abs(level(0.0, (50.0, 35.0)).points[:, None, :2] - felt[None, :, :2]).max(axis=2).min(axis=1)
    assert far.max() < 10.0


def test_what_is_not_there_is_told_and_free_afterwards(study):
    notes = moves_of(study, level(30.0, (20.0, 12.0)))
    assert notes
    assert set(notes) == {"a draft of the object is wrong there"}
    assert study.pad.swept.holds(np.array([[0.0, 0.0, 34.0]])).all()


def test_what_was_felt_is_not_touched_again(study):
    known = level(0.0, (7.0, 5.0))
    moved = Predicted(known.points + np.array([-40.0, -30.0, 0.0]), known.normals, known.face)
    assert moves_of(study, moved) == []


def test_no_more_is_touched_than_the_drafts_allow(study):
    config = DraftedConfig()
    assert len(moves_of(study, level(0.0))) <= config.drafts * config.each


def test_a_draft_that_makes_no_body_asks_for_nothing(study):
    assert moves_of(study, Predicted(np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=np.int64))) == []


def test_a_place_that_no_short_way_leads_to_is_come_at_from_outside(study):
    reach = Reach(study.pad)
    down = se3.pose(study.pad.attitude(UP, ALONG), [20.0, 20.0, 0.0])
    assert Looking(study, reach).come_down_on(down)
    assert study.pad.guard.world_from_sensor[2, 3] == pytest.approx(0.0, abs=1.0)
    through = se3.pose(study.pad.attitude(-UP, ALONG), [20.0, 20.0, 5.0])
    study.pad.lie(np.array([[x, y, -20.0] for x in (15.0, 20.0) for y in (15.0, 20.0)]))
    assert Looking(study, reach).come_down_on(through) is None  # something known stands before it

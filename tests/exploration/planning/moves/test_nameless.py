"""A ring of which one touch tells no shape is followed round until it is one."""

import numpy as np
import pytest

from exploration.devices.guard import Collision, Guard, OverPress
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.nameless import Nameless, NamelessConfig
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Torus
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts

UP = np.array([0.0, 0.0, 1.0])
SPEC = load_sensor("lts210")
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])


@pytest.fixture
def study():
    """Over a ring of 30 mm by 6, of which nothing is known."""
    high = se3.pose(se3.frame_along(-UP), [30.0, 0.0, 40.0])
    stage, arrays = simulate(
        Solid.from_csg(Torus(30.0, 6.0)), [SPEC], np.random.default_rng(0), start_pose=high
    )
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    tools = Tool.each([SPEC], [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    return Study(pad, Findings(hollow=True), AttributionConfig(convex=False))


def hint(study, at, normal):
    """A contact that belongs to no face."""
    study.loose = Contacts.concatenate([study.loose, Contacts.of([at], [normal], 0.05, 0.05)])


def note_of(move):
    """What a move did, or that the housing met the ring."""
    try:
        return move()[1]
    except (Collision, OverPress) as error:
        return str(error)


@pytest.mark.long
def test_a_ring_is_followed_to_touches_apart_until_nothing_of_it_is_nameless(study):
    for y in (-5.0, 0.0, 5.0):
        hint(study, [np.sqrt(900.0 - y * y), y, 6.0], UP)
    nameless, notes = Nameless(study, Reach(study.pad)), []
    while (move := nameless.next()) is not None and len(notes) < 25:
        notes.append(note_of(move))
    met = [note for note in notes if note.startswith("followed")]
    assert len(met) >= 3, notes
    felt = np.concatenate([points for points, _ in study.pad.felt])
    assert np.abs(np.hypot(np.hypot(felt[:, 0], felt[:, 1]) - 30.0, felt[:, 2]) - 6.0).max() < 4.0
    assert np.ptp(np.arctan2(felt[:, 1], felt[:, 0])) > 1.0


def test_where_nothing_is_met_it_is_soon_given_up(study):
    hint(study, [60.0, 0.0, 20.0], UP)  # in the air
    nameless, moves = Nameless(study, Reach(study.pad)), 0
    while (move := nameless.next()) is not None:
        assert move()[0] is None
        moves += 1
    assert 0 < moves <= NamelessConfig().vain


def test_nothing_is_followed_without_a_nameless_contact(study):
    assert Nameless(study, Reach(study.pad)).next() is None

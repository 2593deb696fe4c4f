"""What the skin ran into on its way is touched, and told to be what it is."""

import numpy as np
import pytest

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.devices.simulated import simulate
from exploration.planning.any_form import AnyForm
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.bumped import Bumped
from exploration.planning.touching.bumps import bump_of
from exploration.planning.touching.findings import ExplorerConfig, Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts

BOX = np.array([-90.0, -90.0, -90.0, 90.0, 90.0, 90.0])
SIDEWAYS = se3.frame_along([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])


@pytest.fixture
def run_into_a_post():
    """A study whose pad has run into a post that stands on a plate, and the fault that ended it."""
    spec = load_sensor("lts210")
    post = Cube((60.0, 60.0, 10.0)) | Cylinder(6.0, 70.0, name="post").at(0.0, 0.0, 35.0)
    start = se3.pose(SIDEWAYS, [-50.0, 2.0, 40.0])
    stage, arrays = simulate(Solid.from_csg(post), [spec], np.random.default_rng(0), start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=[Tool.of_size(spec.array.size)])
    study = Study(pad, Findings(hollow=True), AttributionConfig(convex=False))
    with pytest.raises((OverPress, Collision)) as fault:
        guard.go_to(se3.pose(SIDEWAYS, [50.0, 2.0, 40.0]))
    study.back_off(fault.value)
    return study, fault.value


def test_it_is_noted_where_the_skin_was_hit_and_from_where_it_came(run_into_a_post):
    study, fault = run_into_a_post
    (bump,) = study.pad.bumps
    assert np.abs(bump.point - [-6.0, 0.0, 40.0])[:2].max() < 2.5
    np.testing.assert_allclose(bump.way, [1.0, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(bump.pose, fault.seen.world_from_sensor)
    assert bump_of(Collision("of nothing that is known")) is None


def test_it_is_touched_and_named(run_into_a_post):
    study, _ = run_into_a_post
    retreat(study.pad.guard, 20.0)
    bumped = Bumped(study, Reach(study.pad))
    move = bumped.next()
    assert move is not None
    face, _ = move()
    found = study.found.fit_of(face)
    assert (found.kind, found.convex) == ("cylinder", True)
    assert found.shape.radius == pytest.approx(6.0, abs=0.3)
    assert bumped.next() is None


def test_what_is_known_by_now_or_was_tried_is_left(run_into_a_post):
    study, _ = run_into_a_post
    bumped = Bumped(study, Reach(study.pad))
    assert bumped.next() is not None
    (bump,) = study.pad.bumps
    study.loose = Contacts.of(bump.point[None] + [1.0, 0.0, 1.0])
    assert bumped.next() is None


def test_exploring_goes_there_where_nothing_else_is_open(run_into_a_post):
    study, _ = run_into_a_post
    retreat(study.pad.guard, 20.0)
    assert next(AnyForm(study, ExplorerConfig()).run()) == "touched what an array had run into"

"""What a wide pad meets in a hollow and slips off, a small one lies on."""

import numpy as np
import pytest

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.slipped import Slipped
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.parts import build
from models.solid import Solid
from primitives import pose as se3

UP = np.array([0.0, 0.0, 1.0])
SPECS = [load_sensor("lts210"), load_sensor("fingertip")]
ALONG = [np.array([1.0, 0.0, 0.0])]
BOX = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])


def test_what_a_wide_pad_slips_off_in_a_bowl_a_fingertip_lies_on():
    solid, high = Solid.from_csg(build("dish")), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(solid, SPECS, np.random.default_rng(0), start_pose=high)
    guard = Guard(stage, arrays, [Calibration.nominal(spec) for spec in SPECS])
    tools = Tool.each(SPECS, [array.flange_from_sensor for array in arrays])
    pad = Pad(guard, BOX, lambda kind, detail: None, tools=tools)
    study = Study(pad, Findings(hollow=True), AttributionConfig(convex=False))
    assert not pad.touch(se3.pose(se3.frame_along(-UP), [9.0, 4.0, 8.0]), 10.0, 20.0)
    assert len(pad.slipped) == 1
    retreat(guard, 40.0)
    guard.use(1)
    slipped = Slipped(study, Reach(pad))
    move = slipped.next(lambda normal: ALONG)
    assert move is not None
    face, _ = move()
    bowl = study.found.fit_of(face)
    assert (bowl.kind, bowl.convex) == ("sphere", False)
    assert bowl.shape.radius == pytest.approx(45.0, abs=0.2)
    assert slipped.next(lambda normal: ALONG) is None

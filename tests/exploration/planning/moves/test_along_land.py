"""Going on along a ring that is narrower than the pad."""

import numpy as np

from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.known.mosaic import Lattice
from exploration.planning.moves.along_land import AlongLand
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cylinder
from models.solid import Solid
from primitives import pose as se3

DOWN = np.array([0.0, 0.0, -1.0])


def on_ring(cut=None):
    """A pad that has felt the top of a ring, 32 to 40 mm from its axis, in two places side by side."""
    ring = Cylinder(40.0, 8.0) - Cylinder(32.0, 10.0)
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(DOWN), [36.0, 0.0, 60.0])
    solid = Solid.from_csg(ring if cut is None else ring - cut)
    stage, arrays = simulate(solid, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    pad = Pad(guard, np.array([-90.0, -90.0, -60.0, 90.0, 90.0, 90.0]), lambda kind, detail: None)
    study, reach = Study(pad, Findings(), AttributionConfig(convex=False)), Reach(pad)
    for y in (-3.0, 3.0):
        lying = se3.pose(se3.frame_along(DOWN, np.array([0.0, 1.0, 0.0])), [36.0, y, 4.0])
        assert reach.touch(lying, False, AS_IT_CAME, AS_TOLD)
        study.take_in(pad.feel())
    return AlongLand(study, reach), pad


def shown(pad):
    """(n,) [rad] round the axis, where the picture shows the middle of the ring."""
    lattice = Lattice.over(np.array([[-45.0, -45.0, 0.0], [45.0, 45.0, 0.0]]), np.eye(3)[:, :2], 0.5, 0.0)
    seen = pad.skin.mosaic.picture(np.array([0.0, 0.0, 4.0]), -DOWN, lattice)
    places = lattice.origin + lattice.step * np.argwhere(seen.known & (seen.share > 0.5))
    middle = places[np.abs(np.linalg.norm(places, axis=1) - 36.0) < 1.0]
    return np.sort(np.arctan2(middle[:, 1], middle[:, 0]))


def gone_round(lands, most=20):
    """How many moves there were, each with its note."""
    notes = []
    while (move := lands.next()) is not None and len(notes) < most:
        notes.append(move()[1])
    return notes


def test_it_goes_on_all_round_and_ends_where_it_began():
    lands, pad = on_ring()
    assert np.ptp(shown(pad)) < 1.5
    notes = gone_round(lands)
    assert 4 <= notes.count("went on along a land") == len(notes) <= 14
    assert np.diff(shown(pad)).max() < 0.1
    assert np.ptp(shown(pad)) > 2.0 * np.pi - 0.1


def test_it_stops_at_a_gap_from_both_sides():
    gap = Cylinder(14.0, 20.0).at(-36.0, 0.0, 0.0)
    lands, pad = on_ring(gap)
    notes = gone_round(lands)
    assert len(notes) <= 14
    seen = shown(pad)
    assert np.abs(seen).max() < np.pi - 0.25
    assert np.diff(seen[np.abs(seen) < np.pi - 0.5]).max() < 0.1

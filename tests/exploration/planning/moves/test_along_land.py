"""Going on along a ring that is narrower than the pad."""

from dataclasses import replace

import numpy as np

from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.known.mosaic import Lattice
from exploration.planning.moves.along_land import AlongLand
from exploration.planning.open.land_ends import LandEnd
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cylinder
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts

DOWN = np.array([0.0, 0.0, -1.0])


def on_ring(cut=None, sensor="lts210", wide=8.0, places=(-3.0, 3.0)):
    """A pad that has felt the top of a ring, 36 mm from its axis, in places side by side."""
    ring = Cylinder(36.0 + 0.5 * wide, 8.0) - Cylinder(36.0 - 0.5 * wide, 10.0)
    spec, start = load_sensor(sensor), se3.pose(se3.frame_along(DOWN), [36.0, 0.0, 60.0])
    solid = Solid.from_csg(ring if cut is None else ring - cut)
    stage, arrays = simulate(solid, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    pad = Pad(guard, np.array([-90.0, -90.0, -60.0, 90.0, 90.0, 90.0]), lambda kind, detail: None)
    study, reach = Study(pad, Findings(), AttributionConfig(convex=False)), Reach(pad)
    for y in places:
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


def test_a_small_array_goes_on_as_well():
    """What a larger one has told of the face."""
    lands, pad = on_ring(sensor="fingertip", wide=5.0, places=(-3.0, 0.0, 3.0))
    told = np.column_stack([36.0 + np.tile([-2.0, 2.0], 5), np.linspace(-4.0, 4.0, 10), np.full(10, 4.0)])
    lands.study.take_in(Contacts.of(told, np.tile(-DOWN, (10, 1)), 0.02, 0.01))
    before = np.ptp(shown(pad))
    notes = gone_round(lands, 8)
    assert notes.count("went on along a land") >= 6
    assert np.ptp(shown(pad)) > before + 0.3


def test_the_two_sides_of_a_thin_ring_are_gone_on_along_both():
    lands, _ = on_ring()
    end = LandEnd(np.array([30.0, 0.0, 4.0]), np.array([0.0, 1.0, 0.0]), -DOWN)
    lands._tried.append(end)
    assert lands._given_up(replace(end, point=end.point - [0.0, 1.0, 0.0]))
    assert not lands._given_up(replace(end, point=end.point - [0.0, 0.0, 4.0], normal=DOWN))


def test_it_stops_at_a_gap_from_both_sides():
    gap = Cylinder(14.0, 20.0).at(-36.0, 0.0, 0.0)
    lands, pad = on_ring(gap)
    notes = gone_round(lands)
    assert 2 <= notes.count("went on along a land") <= len(notes) <= 14
    assert notes.count("a land did not go on") <= 2
    seen = shown(pad)
    assert min(seen.max(), -seen.min()) > 2.0
    assert np.abs(seen).max() < np.pi - 0.25
    assert np.diff(seen[np.abs(seen) < np.pi - 0.5]).max() < 0.1

"""The narrow top of a wall tells how thick the wall is."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.procedures.tare import tare
from exploration.control.sighting import Sighting
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.wall_tops import WallTops, WallTopsConfig
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.stops import Stop
from exploration.planning.touching.study import Study, Wall
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Prism
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face

X, Y, Z = np.eye(3)
RIM = Sighting(30.0 * Y + 12.5 * Z, X, Z, Y, 0.05, 14.0)


def flat(number, normal, at):
    u, v = np.roll(normal, 1), np.roll(normal, 2)
    points = at + np.array([a * u + b * v for a in (-9.0, 0.0, 9.0) for b in (-9.0, 0.0, 9.0)])
    return ranked_face(number, Contacts.of(points, np.tile(normal, (9, 1))), MergeOptions())


SIDE = flat(4, Y, 30.0 * Y)


def tray(wall, ends=True):
    """A box of 80 x 60 x 25 mm with such walls, or a channel without `ends`."""
    inside = Cube((80.0 - 2.0 * wall if ends else 99.0, 60.0 - 2.0 * wall, 25.0)).at(0.0, 0.0, 3.0)
    return Cube((80.0, 60.0, 25.0)) - inside


def looking(wall, faces=(SIDE,), ends=True, sensor="lts210"):
    """Looks at the tops of such a box."""
    return looking_at(tray(wall, ends), faces, sensor)


def looking_at(tree, faces=(SIDE,), sensor="lts210"):
    spec, start = load_sensor(sensor), se3.pose(se3.frame_along(-Z), [0.0, 30.0, 60.0])
    stage, arrays = simulate(
        Solid.from_csg(tree), [spec], np.random.default_rng(0), noise=0.05, start_pose=start
    )
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    pad = Pad(guard, box, lambda kind, detail: None)
    study = Study(pad, Findings(hollow=True, graph=PatchGraph(faces, ())), AttributionConfig(convex=False))
    return WallTops(study, Reach(pad)), study.found


@pytest.mark.parametrize(
    ("sensor", "wall"),
    [("lts210", 1.5), ("lts210", 2.5), ("lts210", 4.0), ("optical", 1.0), ("capacitive", 2.5)],
)
def test_a_look_at_the_top_of_a_wall_tells_where_it_is_and_how_thick_it_is(sensor, wall):
    tops, found = looking(wall, sensor=sensor)
    move = tops.next([(RIM, 4)])
    assert move is not None
    move()
    top = found.graph.faces[-1]
    assert isinstance(top.fit, Fit)
    assert top.fit.shape.normals(RIM.point[None])[0] @ Z > 0.999
    assert np.abs(top.contacts.points[:, 2] - 12.5).max() < 0.1
    ((inner, own),) = found.wall_rims
    assert own == top.id
    assert inner.outward @ Y < -0.999
    assert abs(float(inner.point[1]) - (30.0 - wall)) < 0.08
    assert tops.next([(RIM, 4)]) is None


def test_a_pad_that_reaches_past_the_end_of_a_wall_measures_it_no_less():
    tops, found = looking(2.5, ends=False)
    move = tops.next([(replace(RIM, point=RIM.point + 34.0 * X), 4)])
    assert move is not None
    assert move() == (None, "looked at the top of a thin wall")
    ((inner, _),) = found.wall_rims
    assert abs(float(inner.point[1]) - 27.5) < 0.12


def stopped(at, offset):
    """A stop of a stroke toward +y on a floor at z = -9.5, by a wall that is thought to be there."""
    pose = se3.pose(se3.frame_along(-Z, X), at)
    return Stop(Wall(pose[:3, 3] + 9.0 * Y, Y, Z, pose, np.array([15.3, 9.9])), -Y, offset)


@pytest.mark.parametrize("off", [-0.6, 0.0, 0.9])
def test_what_stopped_a_stroke_shows_both_its_edges_from_above(off):
    tops, found = looking(2.5, (flat(4, Z, -9.5 * Z),))
    tops.study.pad.felt.append((np.array([30.0 * Y + 12.0 * Z]), Y[None]))
    move = tops.over([stopped([0.0, 17.0, -9.5], -27.5 + off)])
    assert move is not None
    assert move() == (None, "looked at the top of a thin wall")
    assert tops.next(found.wall_rims) is None
    places = {round(float(edge.outward[1])): float(edge.point[1]) for edge, _ in found.wall_rims}
    assert places[-1] == pytest.approx(27.5, abs=0.1)
    assert places[1] == pytest.approx(30.0, abs=0.1)
    assert tops.over([stopped([1.0, 17.0, -9.5], -27.5)]) is None


def test_where_nothing_stands_on_the_floor_nothing_is_made_out():
    tops, found = looking(2.5, (flat(4, Z, -9.5 * Z),))
    move = tops.over([stopped([0.0, -10.0, -9.5], 0.0)])
    assert move is not None
    assert move() == (None, "nothing narrow was where a stroke was stopped")
    assert not found.wall_rims


def test_a_slanted_top_makes_no_face_that_looks_straight_up():
    top = ((26.0, 11.7), (30.0, 12.5), (30.0, -12.5), (26.0, -12.5))
    wall = Prism(tuple((y, z) for y, z in top), 80.0).placed(se3.pose(np.column_stack([Y, Z, X])))
    tops, found = looking_at(wall)
    move = tops.next([(RIM, 4)])
    assert move is not None
    move()
    assert found.graph.faces == (SIDE,)
    assert not found.wall_rims


def test_ways_that_lead_nowhere_stop_no_later_look():
    tops, _ = looking(2.5)
    tops.reach.touch = lambda *_: False
    for k in range(WallTopsConfig().vain + 1):
        move = tops.next([(replace(RIM, point=RIM.point + 100.0 * k * X), 4)])
        assert move is not None
        move()


def test_a_broad_top_is_no_wall_s():
    tops, found = looking(20.0)
    move = tops.next([(RIM, 4)])
    assert move is not None
    assert move() == (None, "no top of a thin wall was made out")
    assert found.graph.faces == (SIDE,)
    assert not found.wall_rims


def test_where_the_top_or_the_far_side_was_felt_nobody_looks():
    far_side, top = flat(5, -Y, 26.0 * Y), flat(5, Z, 24.0 * Y + 12.5 * Z)
    for other in (far_side, top):
        assert looking(2.5, (SIDE, other))[0].next([(RIM, 4)]) is None
    deep = flat(5, -Y, 0.0 * Y)
    assert looking(2.5, (SIDE, deep))[0].next([(RIM, 4)]) is not None
    assert looking(2.5)[0].next([(RIM, 3)]) is None

"""The narrow top of a wall tells how thick the wall is."""

import numpy as np
import pytest

from exploration.control.procedures.tare import tare
from exploration.control.sighting import Sighting
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.moves.wall_tops import WallTops
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
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


def looking(wall, faces=(SIDE,)):
    """Looks at the tops of a box of 80 x 60 x 25 mm with such walls."""
    inside = Cube((80.0 - 2.0 * wall, 60.0 - 2.0 * wall, 25.0)).at(0.0, 0.0, 3.0)
    tray = Solid.from_csg(Cube((80.0, 60.0, 25.0)) - inside)
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-Z), [0.0, 30.0, 60.0])
    stage, arrays = simulate(tray, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    pad = Pad(guard, box, lambda kind, detail: None)
    study = Study(pad, Findings(hollow=True, graph=PatchGraph(faces, ())), AttributionConfig(convex=False))
    return WallTops(study, Reach(pad)), study.found


@pytest.mark.parametrize("wall", [1.5, 2.5, 4.0])
def test_a_look_at_the_top_of_a_wall_tells_where_it_is_and_how_thick_it_is(wall):
    tops, found = looking(wall)
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

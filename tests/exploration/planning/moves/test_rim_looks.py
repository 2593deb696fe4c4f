"""A look at a rim shows the others beside it."""

import numpy as np
import pytest

from exploration.control.procedures.tare import tare
from exploration.control.sighting import Sighting
from exploration.devices.guard import Collision, Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.known.told import Told
from exploration.planning.moves.rim_looks import RimLooks
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.scene import Scene, table_under
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face

X, Y, Z = np.eye(3)


def flat(number, normal, at):
    u, v = np.roll(normal, 1), np.roll(normal, 2)
    points = at + np.array([a * u + b * v for a in (-9.0, 0.0, 9.0) for b in (-9.0, 0.0, 9.0)])
    return ranked_face(number, Contacts.of(points, np.tile(normal, (9, 1))), MergeOptions())


def rim(point, tangent, outward, normal):
    return Sighting(np.array(point), tangent, outward, normal, 0.05, 12.0)


def test_a_look_at_the_end_of_a_groove_remembers_every_edge_that_it_shows():
    groove = Cube((14.0, 60.0, 30.0)).at(0.0, 0.0, 11.0) | Cube((28.0, 60.0, 12.0)).at(0.0, 0.0, 2.0)
    block = Solid.from_csg(Cube((60.0, 50.0, 40.0)) - groove)
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-Y), [0.0, 60.0, 0.0])
    stage, arrays = simulate(block, [spec], np.random.default_rng(0), start_pose=start)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    pad = Pad(Guard(stage, arrays, [Calibration.nominal(spec)]), box, lambda kind, detail: None)
    end = flat(4, Y, 25.0 * Y)
    found = Findings(hollow=True, graph=PatchGraph((end,), ()))
    study = Study(pad, found, AttributionConfig(convex=False))
    move = RimLooks(study, Reach(pad)).next([(rim([11.0, 25.0, 2.0], Z, -X, Y), 4)])
    assert move is not None
    move()
    seen = [edge for edge, face in (*study.found.wall_rims, *study.found.glimpsed) if face == 4]
    for way, there in ((-X, -14.0), (Z, -4.0)):  # its side, which was looked for, and its floor
        offs = [float(edge.point @ way) for edge in seen if edge.outward @ way > 0.99]
        assert min(abs(off - there) for off in offs) < 0.3


def over_a_post(guess):
    """A look at a guess of the end of a post, 60 mm long, and what is known then."""
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-X), [60.0, 0.0, 0.0])
    post = Solid.from_csg(Cylinder(30.0, 60.0))
    stage, arrays = simulate(post, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    pad = Pad(guard, box, lambda kind, detail: None)
    turns = np.linspace(-0.6, 0.6, 7)
    ring = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    points = np.concatenate([30.0 * ring + z * Z for z in (-8.0, 0.0, 8.0)])
    side = ranked_face(4, Contacts.of(points, np.tile(ring, (3, 1)), 0.01, 0.01), MergeOptions())
    found = Findings(hollow=True, graph=PatchGraph((side,), ()))
    study = Study(pad, found, AttributionConfig(convex=False))
    return RimLooks(study, Reach(pad)).next([(guess, 4)]), study


@pytest.mark.parametrize("way", [Z, np.array([0.0, 0.8, 0.6])], ids=["straight", "aslant"])
def test_the_end_of_a_round_side_is_looked_for_farther_out_where_the_side_goes_on(way):
    """The contact on a cylinder is a narrow strip, whose end is seen in what is left of it.

    The guess is aslant where strokes have felt the side to end at a slant.
    """
    move, study = over_a_post(rim([30.0, 0.0, 23.0], np.cross(way, X), way, X))
    assert move is not None
    assert move()[1] == "looked at the rim of a wall that nothing has room to face"
    heights = [float(edge.point @ Z) for edge, face in study.found.wall_rims if face == 4]
    assert min(abs(height - 30.0) for height in heights) < 1.0


def test_a_rim_too_near_a_table_to_lie_over_is_looked_at_from_higher_up():
    """A slot 12 mm high that opens onto the table: over the middle of its side the pad would be in the table."""
    block = Solid.from_csg(Cube((80.0, 50.0, 40.0)) - Cube((20.0, 60.0, 24.0)).at(0.0, 0.0, -20.0))
    table = table_under(block)
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-Y), [0.0, 60.0, 0.0])
    stage, arrays = simulate(Scene((block, table)), [spec], np.random.default_rng(0), start_pose=start)
    x, y = np.meshgrid(np.arange(-150.0, 151.0, 4.0), np.arange(-150.0, 151.0, 4.0))
    tool = Tool.of(spec)
    told = Told(table, np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -20.0)]), tool, -20.0)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    pad = Pad(guard, box, lambda kind, detail: None, told=told, tools=(tool,))
    study = Study(
        pad, Findings(hollow=True, graph=PatchGraph((flat(4, Y, 25.0 * Y),), ())), AttributionConfig()
    )
    reach, side = Reach(pad), rim([-10.0, 25.0, -14.0], Z, X, Y)
    middle = side.point - 3.0 * X
    assert not reach.with_room([se3.pose(pad.attitude(Y, along), middle) for along in (X, Z)])
    move = RimLooks(study, reach).next([(side, 4)])
    assert move is not None
    assert move()[1] == "looked at the rim of a wall that nothing has room to face"
    seen = [edge for edge, _ in (*study.found.wall_rims, *study.found.glimpsed)]
    offs = [float(edge.point @ X) for edge in seen if edge.outward @ X > 0.99]
    assert min(abs(off + 10.0) for off in offs) < 0.3


def over_a_narrow_top():
    """A look at a guess 1 mm too far out of the top of a wall 6 mm thick, and what is known then."""
    wall = Solid.from_csg(Cube((6.0, 90.0, 30.0)).at(3.0, 0.0, -15.0))
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-Z), [0.0, 0.0, 40.0])
    stage, arrays = simulate(wall, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    pad = Pad(guard, box, lambda kind, detail: None)
    top = flat(4, Z, 3.0 * X)
    study = Study(pad, Findings(hollow=True, graph=PatchGraph((top,), ())), AttributionConfig(convex=False))
    looks = RimLooks(study, Reach(pad))
    return looks, looks.next([(rim([-1.0, 0.0, 0.0], Y, -X, Z), 4)]), study.found


def test_on_the_narrow_top_of_a_wall_the_pad_is_pressed_as_it_came():
    """It settles off the guess, and contact that fades with its tilt ends at no edge."""
    _, move, found = over_a_narrow_top()
    assert move()[1] == "looked at the rim of a wall that nothing has room to face"
    seen = [edge for edge, face in (*found.wall_rims, *found.glimpsed) if face == 4]
    assert min(float(edge.normal @ Z) for edge in seen) > 0.999
    assert min(abs(float(edge.point @ X)) for edge in seen if edge.outward @ -X > 0.99) < 0.1


def test_what_a_pad_saw_is_kept_where_pressing_it_again_is_a_fault():
    looks, move, found = over_a_narrow_top()
    touch, made = looks.reach.touch, []

    def once(*args, **kwargs):
        if made:
            raise Collision("collision of lts210 by 0.10 mm")
        made.append(touch(*args, **kwargs))
        return made[-1]

    looks.reach.touch = once
    with pytest.raises(Collision):
        move()
    assert any(edge.outward @ X > 0.9 for edge, _ in (*found.wall_rims, *found.glimpsed))

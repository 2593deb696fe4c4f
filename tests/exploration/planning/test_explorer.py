"""Whole explorations in simulation, and what ends them."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.devices.guard import Collision, Guard, OverPress
from exploration.devices.simulated import simulate
from exploration.planning import explorer as module
from exploration.planning.explorer import Explorer, ExplorerConfig
from exploration.planning.known.told import Told
from exploration.planning.ways.routes import Tool
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models import parts
from models.csg import Cone, Cube, Cylinder
from models.solid import Solid, iou
from primitives import pose as se3
from recognition.assembly.assemble import assemble

BOX = np.array([-200.0, -200.0, -200.0, 200.0, 200.0, 200.0])


def explorer_over(tree, seed, sensor="lts210", **config):
    rng = np.random.default_rng(seed)
    solid = Solid.from_csg(tree).placed(se3.pose(se3.random_rotation(rng), rng.uniform(-20.0, 20.0, 3)))
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 200.0])
    noise = 0.05 if sensor == "lts210" else None  # else as its preset says
    stage, arrays = simulate(solid, [load_sensor(sensor)], rng, noise=noise, start_pose=above)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    return Explorer(guard, BOX, ExplorerConfig(**config)), solid


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sensor", "name"), [("lts210", "cylinder"), pytest.param("dsa", "cylinder", marks=pytest.mark.long)]
)
def test_a_convex_part_is_explored_until_closed_and_rebuilt_by_coarse_arrays_and_fine_ones(sensor, name):
    explorer, solid = explorer_over(parts.build(name), seed=1, sensor=sensor, max_touches=120)
    for _ in explorer.run():
        pass
    built = assemble([face for face in explorer.found.graph.faces if face.fit], BOX.reshape(2, 3))
    assert explorer.found.ended == "closed"
    assert built
    assert iou(built.solid, solid) > 0.99


def test_the_chamfer_at_the_end_of_a_bar_is_found_and_its_sharp_end_left_sharp():
    explorer, solid = explorer_over(Cylinder(18.0, 30.0) & Cone(46.5, 16.5, 30.0), seed=1, max_touches=60)
    for _ in explorer.run():
        pass
    assert explorer.found.ended == "closed"
    (cone,) = [face.fit for face in explorer.found.graph.faces if face.fit.kind == "cone"]
    assert cone.shape.semi_angle == pytest.approx(0.25 * np.pi, abs=0.02)
    built = assemble([face for face in explorer.found.graph.faces if face.fit], BOX.reshape(2, 3))
    assert iou(built.solid, solid) > 0.995


def test_touches_never_exceed_the_budget():
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, max_touches=2)
    for _ in explorer.run():
        pass
    assert explorer.found.ended == "budget"
    assert explorer.guard.cost.touches <= 2


def test_time_on_the_stage_is_a_budget_too():
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, max_minutes=0.2)
    for _ in explorer.run():
        pass
    assert explorer.found.ended == "budget"
    assert 12.0 <= explorer.guard.cost.seconds < 40.0  # the move that was under way is ended


def test_an_empty_workspace_is_said_so():
    explorer, _ = explorer_over(Cube((10.0, 10.0, 10.0)).at(900.0, 0.0, 0.0), seed=0)
    small = np.array([-30.0, -30.0, -10.0, 30.0, 30.0, 200.0])
    explorer.box = explorer._finding.box = small
    assert list(explorer.run()) == []
    assert "nothing was found" in explorer.found.ended


def test_a_collision_while_arrays_are_changed_is_told_and_the_next_one_goes_on(monkeypatch):
    explorer, _ = explorer_over(Cube((10.0, 10.0, 10.0)), seed=0)
    explorer.guard.sensors, explorer.guard.calibrations = (
        2 * explorer.guard.sensors,
        2 * explorer.guard.calibrations,
    )

    def collide(*_):
        raise Collision("collision of lts210 by 0.05 mm")

    class Form:
        reach = SimpleNamespace(come_out=collide)

        def __init__(self, *_):
            self.conclude = lambda: None

        def run(self):
            yield f"felt with array {explorer.guard.active}"

    monkeypatch.setattr(module, "retreat", collide)
    monkeypatch.setattr(module, "AnyForm", Form)
    assert list(explorer._any_form()) == ["felt with array 0", "felt with array 1"]
    assert explorer.found.warnings == 3 * ["collision of lts210 by 0.05 mm"]


def test_an_array_whose_share_was_spent_goes_on_once_all_have_had_theirs(monkeypatch):
    explorer, _ = explorer_over(Cube((10.0, 10.0, 10.0)), seed=0, max_touches=100)
    guard = explorer.guard
    guard.sensors, guard.calibrations = 2 * guard.sensors, 2 * guard.calibrations
    wanted = {0: 80, 1: 10}  # touches that each array could still make good use of

    class Form:
        reach = SimpleNamespace(come_out=lambda: None)

        def __init__(self, study, config, *_):
            self.config, self.conclude = config, lambda: None

        def run(self):
            own, begun = guard.active, guard.cost.touches
            while wanted[own] and not self.config.spent(guard.cost):
                wanted[own] -= 1
                guard.cost.touches += 1
            yield f"array {own}: {guard.cost.touches - begun}"

    monkeypatch.setattr(module, "retreat", lambda *_: None)
    monkeypatch.setattr(module, "AnyForm", Form)
    assert list(explorer._any_form()) == ["array 0: 65", "array 1: 10", "array 0: 15"]


@pytest.mark.slow
def test_a_step_is_explored_to_its_inside_edge_without_a_fault():
    tree = Cube((60, 40, 15)).at(0, 0, 7.5) | Cube((30, 40, 35)).at(-15, 0, 17.5)
    explorer, solid = explorer_over(tree, seed=1, max_touches=80)
    for _ in explorer.run():
        pass
    planes = [face for face in explorer.found.graph.faces if face.fit]
    assert explorer.found.hollow
    assert explorer.found.ended in ("closed", "nothing reachable is open")
    assert len(planes) == 8
    for face in planes:
        assert np.quantile(np.abs(solid.signed_distance(face.contacts.points)), 0.9) < 0.3


@pytest.mark.parametrize("policy", ["grid", "random", "raster"])
def test_a_policy_without_thought_touches_until_its_budget_ends(policy):
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, max_touches=6, policy=policy)
    for _ in explorer.run():
        pass
    assert explorer.found.ended == "budget"
    assert explorer.guard.cost.touches <= 8
    assert explorer.found.graph.faces


def test_an_object_is_taken_for_hollow_where_move_after_move_is_stopped_though_a_convex_one_leaves_room():
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, stopped=3)

    def stopped():
        raise Collision("something is in the way")

    explorer._next = lambda face: stopped
    explorer._any_form = lambda: iter(())
    notes = [findings.note for findings in explorer.run()]
    assert sum(note.startswith("backed off") for note in notes) == 3
    assert explorer.found.hollow


def test_a_face_without_end_predicts_no_farther_than_round_what_was_touched():
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, region=30.0)
    run = explorer.run()
    next(run)
    felt = np.concatenate([face.contacts.points for face in explorer.found.graph.faces])
    around = explorer._around().reshape(2, 3)
    assert np.allclose(around, [felt.min(axis=0) - 30.0, felt.max(axis=0) + 30.0])
    explorer.box = np.concatenate([felt.min(axis=0), felt.max(axis=0)])
    assert np.allclose(explorer._around(), explorer.box)


def test_an_object_without_a_face_is_come_down_on_again_before_its_faces_are_explored_for_themselves():
    explorer, _ = explorer_over(Cube((40.0, 40.0, 40.0)), seed=0, first_tries=12)
    explorer._study.face_here, looks, explored = lambda: None, [], []
    explorer.found.hollow = True

    def look():
        explorer._finding.looked += 1
        looks.append(len(explored))
        raise Collision("something is in the way")  # before any touch

    explorer._finding.look_again = look
    explorer._any_form = lambda: iter(explored.append(1) or ())
    for _ in explorer.run():
        pass
    assert looks == [0] * 12
    assert explored == [1]


def told_of_a_table(height):
    x, y = np.meshgrid(np.arange(-150.0, 151.0, 10.0), np.arange(-150.0, 151.0, 10.0))
    top = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    body = Solid.from_csg(Cube((400.0, 400.0, 20.0)).at(0.0, 0.0, height - 10.0))
    return Told(body, top, Tool.of_size((18.0, 28.8)), height)


def move_on(guard, *velocity, ticks=400):
    for _ in range(ticks):
        guard.move(np.array([*velocity, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("begin", "down", "velocity", "tables"),
    [
        ([-60.0, 0.0, 3.5], 0.0, [40.0, 0.0, 0.0], False),  # level, in the air, into the block
        ([-60.0, 0.0, 5.5], 2.0, [40.0, 0.0, 0.0], False),  # down, and level then
        ([-60.0, 0.0, 30.0], 0.0, [0.0, 0.0, 40.0], True),  # down, onto the table
    ],
)
def test_what_stops_an_array_on_its_way_along_a_table_is_not_the_table(begin, down, velocity, tables):
    facing_down = np.diag([1.0, -1.0, -1.0])
    scene = Cube((40.0, 40.0, 40.0)).at(0.0, 0.0, 20.0) | Cube((400.0, 400.0, 20.0)).at(0.0, 0.0, -10.0)
    stage, arrays = simulate(
        Solid.from_csg(scene),
        [load_sensor("lts210")],
        np.random.default_rng(0),
        start_pose=se3.pose(facing_down, begin),
    )
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    explorer = Explorer(guard, BOX, ExplorerConfig(), told=told_of_a_table(0.0))
    move_on(guard, 0.0, 0.0, 20.0, ticks=round(down / (20.0 * guard.period)))
    with pytest.raises((Collision, OverPress)) as fault:
        move_on(guard, *velocity)
    assert explorer._by_what_is_told(fault.value) is tables

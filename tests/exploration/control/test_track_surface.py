"""Strokes on the plant of the benches: a stage that obeys late and errs, under a noisy array."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control import track_surface
from exploration.control.feel import feel
from exploration.control.latency import measure_latency
from exploration.control.procedures.land import land
from exploration.control.procedures.stroke_curvature import stroke_curvature
from exploration.control.track_surface import StrokeConfig, _lies_flush, follow_surface
from exploration.devices.guard import Collision, Guard, GuardLimits
from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.solid import Solid
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])
WIDE = GuardLimits()


def late(tree: Csg, start, limits: GuardLimits = WIDE) -> tuple[Guard, Solid]:
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    solid = Solid.from_csg(tree, 0.001)
    stage, arrays = simulate(
        solid,
        [spec],
        np.random.default_rng(1),
        pose_noise=PoseNoise(0.05, 0.02, 0.0, np.radians(0.02)),
        start_pose=start,
        latency=0.02,
    )
    guard = Guard(stage, arrays, [Calibration.nominal(spec)], limits)
    guard.pending.latency = measure_latency(guard).seconds
    return guard, solid


@pytest.mark.parametrize(
    ("tree", "top"), [(Sphere(20.0), 20.0), (Cylinder(25.0, 120.0).turned("y", np.pi / 2), 25.0)]
)
def test_a_stroke_under_latency_keeps_its_force_and_tells_where_the_surface_is(tree, top):
    guard, solid = late(tree, se3.pose(DOWN, [1.0, -1.0, top + 5.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    stroke = follow_surface(guard, np.array([0.6, 0.8]), 30.0, 1, 1)
    assert stroke.ended == "length"
    off = solid.signed_distance(stroke.trace.points)
    assert np.sqrt(np.mean(off**2)) < 0.08
    facing = np.sum(solid.normals(stroke.trace.points) * stroke.trace.normals, axis=1)
    assert np.sqrt(np.mean(np.arccos(np.clip(facing, -1.0, 1.0)) ** 2)) < np.radians(0.5)
    assert abs(np.mean(stroke.forces) / np.mean(stroke.set_points) - 1.0) < 0.05


def test_a_stroke_under_latency_stops_short_of_the_edge():
    guard, _ = late(Cube((70.0, 60.0, 30.0)), se3.pose(DOWN, [5.0, 0.0, 20.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    assert follow_surface(guard, np.array([1.0, 0.0]), 100.0, 1, 1).ended == "edge"
    assert 22.0 < guard.world_from_sensor[0, 3] < 34.0


def test_a_stroke_ends_where_the_stage_does():
    limits = GuardLimits(reach=(-600.0, -600.0, -600.0, 20.0, 600.0, 600.0))
    guard, _ = late(Cube((120.0, 80.0, 30.0)), se3.pose(DOWN, [0.0, 0.0, 20.0]), limits)
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    assert follow_surface(guard, np.array([1.0, 0.0]), 100.0, 1, 1).ended == "workspace"
    assert guard.world_from_sensor[0, 3] < 20.0


@pytest.mark.slow
def test_strokes_in_four_directions_tell_a_cone_and_its_radius_though_one_ends_early(monkeypatch):
    strokes = []

    def ends_early(guard, heading, length, *told, config):
        strokes.append(guard.world_from_sensor[:3, 3])
        length = 1.5 if len(strokes) == 5 else length  # of the way over the contact at 45 degrees
        return follow_surface(guard, heading, length, *told, config=config)

    monkeypatch.setattr("exploration.control.procedures.stroke_curvature.follow_surface", ends_early)
    guard, _ = late(
        Cone(40.0, 20.0, 80.0),
        se3.pose(
            se3.frame_along([-np.cos(np.arctan(0.25)), 0.0, -0.2425], [0.0, 1.0, 0.0]), [37.0, 0.0, 1.2]
        ),
    )
    assert land(guard, guard.world_from_sensor[:3, 2], 20.0, 25.0)
    z = float(guard.world_from_sensor[2, 3])
    found = stroke_curvature(guard)
    assert found.type == "cone"
    assert abs(abs(found.tangent) - 0.25) < 0.05
    radius = (30.0 - 0.25 * z) / np.cos(np.arctan(0.25))
    assert abs(found.radius[0] - radius) < 0.02 * radius
    assert len(strokes) == 15
    assert np.linalg.norm(strokes[6] - strokes[0]) < 0.5  # back, before it is tried again


@pytest.mark.parametrize(("aside", "lies"), [(0.0, True), (21.0, False)])
def test_a_pad_that_has_hung_on_a_corner_all_along_lies_on_nothing(over, aside, lies):
    guard, _ = over(Cube((20.0, 30.0, 30.0)), se3.pose(DOWN, [aside, aside, 14.5]))
    seen = guard.hold()
    away, area = np.array([1.0, 0.0]), feel(seen.image).area
    assert _lies_flush(seen, away, area, 9.0, 0.5, StrokeConfig()) is lies


@pytest.mark.parametrize(("where", "after"), [("look_closely", 3), ("read_surface", 30)])
def test_a_fault_carries_what_its_stroke_had_felt(over, monkeypatch, where, after):
    """Whether the pad was moving or held still to look."""
    guard, solid = over(Cube((90.0, 60.0, 30.0)), se3.pose(DOWN, [-20.0, 0.0, 14.6]))
    usual, calls = getattr(track_surface, where), []

    def fails(*given):
        calls.append(1)
        if len(calls) > after:
            raise Collision("collision of lts210 by 0.10 mm", guard.hold())
        return usual(*given)

    monkeypatch.setattr(track_surface, where, fails)
    with pytest.raises(Collision) as caught:
        follow_surface(guard, np.array([1.0, 0.0]), 40.0, 1, 1, config=StrokeConfig(walls=True))
    assert len(caught.value.kept)
    assert np.abs(solid.signed_distance(caught.value.kept.points)).max() < 0.1

"""Contact, normal, follow surface and follow edge, composed into surfaces, edges, corners, contours and holes.

Each test is one short sequence, as the literature composes them, on a plate with a hole; noise on array and stage.
"""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.dwell import dwell
from exploration.control.procedures.land import land
from exploration.control.procedures.surface_normal import surface_normal
from exploration.control.sighting import sight
from exploration.control.track_edge import follow_edge
from exploration.control.track_outline import follow_outline
from exploration.control.track_surface import follow_surface
from exploration.devices.guard import Guard
from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives import pose as se3

PLATE = Solid.from_csg(Cube((110.0, 70.0, 30.0)) - Cylinder(12.0, 60.0).at(25.0, 0.0, 0.0))
DOWN = np.diag([1.0, -1.0, -1.0])
EAST = np.array([1.0, 0.0, 0.0])


def in_contact(x, y):
    """*contact*: the pad flush on the plate's top."""
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    stage, arrays = simulate(
        PLATE,
        [spec],
        np.random.default_rng(1),
        pose_noise=PoseNoise(0.05, 0.02, 0.0, np.radians(0.02)),
        start_pose=se3.pose(DOWN, [x, y, 19.0]),
        latency=0.02,
    )
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    guard.pending.latency = 0.02
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    return guard


def test_contact_normal_and_a_stroke_give_a_surface():
    guard = in_contact(-25.0, 0.0)
    here = surface_normal(guard, np.array([1.0, 0.0]))
    stroke = follow_surface(guard, np.array([0.0, 1.0]), 8.0, 1, 1)
    there = surface_normal(guard, np.array([1.0, 0.0]))
    assert here.normal @ there.normal > np.cos(np.radians(0.5))
    heights = (stroke.contacts.points - here.point) @ here.normal
    assert np.abs(heights).max() < 0.15


def test_a_stroke_until_contact_ends_gives_an_edge():
    guard = in_contact(-25.0, 0.0)
    stroke = follow_surface(guard, np.array([-1.0, 0.0]), 100.0, 1, 1)
    assert stroke.ended == "edge"
    seen = dwell(guard, 6)
    edge = min((sight(line, seen) for line in find_lines(seen.image, 3)), key=lambda e: e.point[0])
    assert edge.point[0] == pytest.approx(-55.0, abs=0.2)
    assert edge.outward @ -EAST > 0.99


def test_an_edge_followed_to_its_end_gives_a_corner():
    tracked = follow_edge(in_contact(-10.0, 34.0), -EAST, 100.0, 1, 1)
    assert tracked.ended == "corner"
    end = tracked.trace.points[-1] + tracked.trace.tangents[-1] * 2.5
    assert np.linalg.norm(end[:2] - [-55.0, 35.0]) < 4.0


@pytest.mark.slow
def test_edges_and_corners_followed_round_give_a_contour():
    outline = follow_outline(in_contact(-10.0, 34.0), -EAST, 500.0, 1, 1)
    assert outline.ended == "closed"
    turned = [float(t.tangents[-1] @ EAST) for t in outline.traces]
    assert len(outline.corners) >= 4
    for corner in ([-55, 35], [-55, -35], [55, -35], [55, 35]):
        assert np.linalg.norm(outline.corners[:, :2] - corner, axis=1).min() < 0.5
    assert max(turned) > 0.99
    assert min(turned) < -0.99


@pytest.mark.slow
def test_a_closed_edge_with_the_material_outside_gives_a_hole():
    guard = in_contact(2.0, 0.0)
    stroke = follow_surface(guard, np.array([1.0, 0.0]), 40.0, 1, 1)
    assert stroke.ended == "edge"
    tracked = follow_edge(guard, np.array([0.0, 1.0, 0.0]), 200.0, 1, 1)
    assert tracked.ended == "closed"
    points = tracked.trace.points
    around = np.column_stack([2.0 * points[:, :2], np.ones(len(points))])
    x, y, rest = np.linalg.lstsq(around, np.sum(points[:, :2] ** 2, axis=1), rcond=None)[0]
    assert np.hypot(x - 25.0, y) < 0.15
    radius = np.sqrt(rest + x * x + y * y)
    assert radius == pytest.approx(12.0, abs=0.15)
    beside = guard.world_from_sensor[:2, 3] - [x, y]
    assert np.linalg.norm(beside) > radius  # the pad's center is kept over material

"""Parts of a frame: they cover it, and lie where they were."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.dwell import dwell
from exploration.control.sighting import Sighting, sight
from exploration.control.windows import going_on, windows
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Prism
from models.solid import Solid
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])
LEAN = np.arctan2(15.0, 9.0)
FLANK = np.array([np.sin(LEAN), -np.cos(LEAN)])  # out of the material, in x and y


@pytest.fixture(scope="module")
def seen():
    """A pad at the end of a dovetail groove: its mouth, a flank and its floor all lie under it."""
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    groove = Prism(
        ((-24.0, 0.0), (24.0, 0.0), (15.0, 15.0), (15.0, 30.0), (-15.0, 30.0), (-15.0, 15.0)), 80.0
    )
    block = Cube((100.0, 40.0, 60.0)).at(0.0, -5.0, -30.0)
    along = se3.rotation_exp([0.0, 0.0, np.arctan2(FLANK[0], -FLANK[1])]) @ DOWN
    start = se3.pose(along, [-21.5, 9.0, -0.45])
    stage, arrays = simulate(
        Solid.from_csg(block - groove), [spec], np.random.default_rng(2), start_pose=start
    )
    return dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), 8)


def flanks(observation):
    edges = [sight(line, observation) for line in sure_lines(observation.image, 3)]
    return [edge for edge in edges if edge.outward[:2] @ FLANK > 0.99]


def test_parts_cover_the_pad_and_keep_their_places(seen):
    seen = replace(seen, image=replace(seen.image, saturated=seen.image.depth > 0.4))
    image, covered = seen.image, np.zeros(seen.image.array.shape)
    places = np.stack(np.meshgrid(image.array.x, image.array.y), axis=-1)
    for part in windows(seen, 11.0):
        assert max(part.image.array.size) <= 11.0
        inside = np.stack(np.meshgrid(part.image.array.x, part.image.array.y), axis=-1).reshape(-1, 2)
        world = se3.transform_points(part.world_from_sensor, np.column_stack([inside, np.zeros(len(inside))]))
        local = se3.transform_points(se3.inverse(seen.world_from_sensor), world)[:, :2]
        off = np.linalg.norm(places.reshape(-1, 1, 2) - local, axis=2)
        assert off.min(axis=0).max() < 1e-9
        rows = off.argmin(axis=0)
        assert np.array_equal(image.depth.ravel()[rows], part.image.depth.ravel())
        assert np.array_equal(image.saturated.ravel()[rows], part.image.saturated.ravel())
        covered.ravel()[rows] += 1
    assert covered.min() >= 1


def test_an_edge_among_others_is_told_in_a_part_that_it_crosses_alone(seen):
    assert not flanks(seen)
    told = going_on([edge for part in windows(seen, 11.0) for edge in flanks(part)])
    assert len(told) >= 2
    longest = max(told, key=lambda edge: edge.length)
    assert abs(float((longest.point[:2] - [-24.0, 0.0]) @ FLANK)) < 0.2


def test_a_pad_that_is_no_larger_than_a_part_has_none(seen):
    assert not list(windows(seen, 100.0))


def edge(point, angle):
    outward = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return Sighting(np.array([*point, 0.0]), np.cross(up, outward), outward, up, 0.05, 10.0)


@pytest.mark.parametrize(("radius", "goes_on"), [(15.0, False), (40.0, False), (1e4, True)])
def test_a_round_rim_goes_on_in_no_other_part(radius, goes_on):
    turns = np.array([-5.4, 0.0, 5.4]) / radius
    parts = [edge((radius * np.cos(turn) - radius, radius * np.sin(turn)), turn) for turn in turns]
    assert bool(going_on(parts)) == goes_on

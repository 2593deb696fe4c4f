import numpy as np
import pytest
import trimesh

from exploration.sensing.physics.housing import HousingWatch, clearance
from exploration.sensing.spec import load_sensor
from models.solid import Solid
from primitives.pose import pose, rotation_exp

LTS = load_sensor("lts210")
DOWN = np.diag([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def block():
    mesh = trimesh.creation.box((80.0, 80.0, 40.0))
    return Solid.from_mesh(mesh.vertices, mesh.faces)


def test_clearance_of_a_flat_press_is_proud_less_depth(block):
    assert clearance(block, pose(DOWN, [0, 0, 19.5]), LTS) == pytest.approx(LTS.housing.proud - 0.5)
    assert clearance(block, pose(DOWN, [0, 0, 17.0]), LTS) == pytest.approx(LTS.housing.proud - 3.0)


def test_watch_sees_an_overlap_exactly_when_there_is_one(block):
    watch, rng = HousingWatch(block, LTS), np.random.default_rng(0)
    hits = 0
    for _ in range(300):
        turn = rotation_exp([*rng.uniform(-0.2, 0.2, 2), rng.uniform(-3, 3)])
        where = pose(DOWN @ turn, [*rng.uniform(-60, 60, 2), rng.uniform(14, 30)])
        dense = clearance(block, where, LTS)
        if abs(dense) < 1.0:
            continue
        hits += dense < 0
        assert (watch.overlap(where) > 0.0) == (dense < 0.0)
    assert hits > 20


def test_watch_along_a_path_sees_what_a_fresh_watch_sees(block):
    watch = HousingWatch(block, LTS)
    for z in np.linspace(30.0, 15.0, 151):
        where = pose(DOWN @ rotation_exp([0.05, 0.02, 0.3]), [30.0, 5.0, z])
        assert (watch.overlap(where) > 0) == (HousingWatch(block, LTS).overlap(where) > 0)

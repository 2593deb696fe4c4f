"""The world of a run: where the object is put, and what is refused."""

import numpy as np
import pytest

from models.csg import Cylinder
from models.solid import Solid
from primitives.errors import PalpateError
from recognition.config import ExploreOptions
from recognition.running.simulation import WorldConfig, load_world, random_pose

BOX = np.array([[-300.0, -300, -300], [300, 300, 300]])


def test_a_random_pose_keeps_the_middle_near_the_workspaces_and_turns_every_way():
    solid = Solid.from_csg(Cylinder(10, 60).at(500, 0, 0), 0.1)
    poses = [random_pose(solid, BOX, np.random.default_rng(k), WorldConfig()) for k in range(300)]
    middles = np.array([solid.placed(pose).center for pose in poses])
    assert np.linalg.norm(middles, axis=1).max() <= 60.0
    axes = np.array([pose[:3, 2] for pose in poses])
    assert np.abs(axes.mean(axis=0)).max() < 0.15
    assert np.abs(axes.T @ axes / len(axes) - np.eye(3) / 3).max() < 0.08


def test_where_room_is_scarce_the_part_still_fits():
    tight = BOX * 0.12
    solid = Solid.from_csg(Cylinder(10, 60), 0.1)
    for k in range(50):
        placed = solid.placed(random_pose(solid, tight, np.random.default_rng(k), WorldConfig()))
        assert (placed.bounds[0] >= tight[0]).all()
        assert (placed.bounds[1] <= tight[1]).all()


def test_one_seed_is_one_world():
    first, second, other = (load_world(ExploreOptions("wedge", seed=s)) for s in (4, 4, 5))
    assert np.array_equal(first.solid.pose, second.solid.pose)
    assert not np.array_equal(first.solid.pose, other.solid.pose)


def test_as_is_keeps_the_files_coordinates():
    assert np.array_equal(load_world(ExploreOptions("wedge", pose="as-is")).solid.pose, np.eye(4))


def test_noise_that_is_told_replaces_the_sensors_own():
    assert load_world(ExploreOptions("cube", noise=0.05)).spec.electronics.noise == 0.05


def test_who_works_with_one_array_takes_the_first_of_several_and_says_so():
    options = ExploreOptions("cube", sensors=("lts210", "fingertip"))
    one, both = load_world(options), load_world(options, several=True)
    assert one.sensor == "lts210"
    assert "only the first array" in one.part.warnings[-1]
    assert both.sensor == "lts210,fingertip"
    assert both.part.warnings == one.part.warnings[:-1]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (ExploreOptions("cube", pose=(290.0, 0, 0, 1, 0, 0, 0)), "--workspace"),
        (ExploreOptions("cube", sensors=("lts210", "lts210")), "names lts210 twice"),
    ],
)
def test_what_cannot_be_explored_is_refused(options, says):
    with pytest.raises(PalpateError, match=says):
        load_world(options)

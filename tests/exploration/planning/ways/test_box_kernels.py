"""Points in posed boxes, against the same said in the box's own frame."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exploration.planning.ways.box_kernels import free_of, in_box
from primitives import pose as se3

LOW, HIGH = (-9.0, -15.0, -60.0), (9.0, 12.0, 0.0)


def inside(points, pose, low, high):
    local = se3.transform_points(se3.inverse(pose), points)
    return ((low < local) & (local < high)).all(axis=1)


def pose(rng, far=20.0):
    return se3.pose(Rotation.random(random_state=rng).as_matrix(), rng.uniform(-far, far, 3))


@pytest.mark.parametrize("seed", range(5))
def test_points_in_a_posed_box_are_in_it_in_its_own_frame(seed):
    rng = np.random.default_rng(seed)
    points, at = rng.uniform(-60.0, 60.0, (500, 6))[:, :3], pose(rng)
    told = in_box(points, at, LOW, HIGH)
    assert 0 < told.sum() < len(points)
    assert np.array_equal(told, inside(points, at, LOW, HIGH))


def test_a_box_may_be_open_to_one_side():
    points = np.random.default_rng(6).uniform(-60.0, 60.0, (500, 3))
    told = in_box(points, np.eye(4), (-9.0, -15.0, -np.inf), HIGH)
    assert np.array_equal(told, inside(points, np.eye(4), (-9.0, -15.0, -np.inf), HIGH))


@pytest.mark.parametrize("seed", range(10))
def test_poses_are_free_whose_boxes_hold_no_point(seed):
    rng = np.random.default_rng(seed)
    points, poses = rng.uniform(-60.0, 60.0, (12, 3)), np.array([pose(rng, 60.0) for _ in range(30)])
    places = np.array([np.eye(4), se3.pose(translation=[40.0, 0.0, 0.0])])
    low, high = np.array([LOW, (-5.0, -5.0, -5.0)]), np.array([HIGH, (5.0, 5.0, 5.0)])
    told = free_of(poses, points, places, low, high)
    hits = [
        any(inside(points, at @ place, a, b).any() for place, a, b in zip(places, low, high, strict=True))
        for at in poses
    ]
    assert 0 < sum(hits) < len(poses)
    assert np.array_equal(told, ~np.array(hits))

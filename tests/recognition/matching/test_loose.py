"""Poses that a loose hypothesis stands for."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.pose import pose, rotation_exp
from recognition.matching.loose import cross_points, sigma_points

LIBRARY = Library.of(
    {"bar": Solid.from_csg(Cube((80.0, 30.0, 20.0))), "rod": Solid.from_csg(Cylinder(10.0, 60.0))}
)
AT = pose(rotation_exp([0.4, 0.1, -0.7]), [5.0, 6.0, 7.0])


def test_a_sharp_pose_stands_for_itself():
    found = sigma_points(AT, 1e-4 * np.eye(6), LIBRARY["bar"])
    assert len(found) == 1
    assert np.array_equal(found[0], AT)


def test_a_pose_that_may_slide_along_an_axis_lies_on_both_sides_of_it():
    found = sigma_points(AT, np.diag([64.0, *[1e-4] * 5]), LIBRARY["bar"])
    shifts = np.array([AT[:3, :3].T @ (p[:3, 3] - AT[:3, 3]) for p in found[1:]])
    assert sorted(shifts[:, 0]) == pytest.approx([-9.6, 9.6], abs=0.1)
    assert np.abs(shifts[:, 1:]).max() < 0.1


def test_a_turn_about_an_axis_of_revolution_is_no_other_pose():
    turning = np.diag([1e-4] * 5 + [2.0])
    assert len(sigma_points(AT, turning, LIBRARY["rod"])) == 1
    assert len(sigma_points(AT, turning, LIBRARY["bar"])) == 3


def test_crossed_poses_scatter_as_the_covariance_says():
    found = cross_points(AT, np.diag([16.0, 9.0, *[1e-4] * 4]), LIBRARY["bar"])
    shifts = np.array([AT[:3, :3].T @ (p[:3, 3] - AT[:3, 3]) for p in found])
    assert len(found) == 16
    assert shifts.mean(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)
    assert (shifts**2).mean(axis=0)[:2] == pytest.approx([20.0, 11.25], rel=0.01)
    assert cross_points(AT, 1e-4 * np.eye(6), LIBRARY["bar"]) == []

"""Poses that a loose hypothesis stands for."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.pose import pose, rotation_exp
from recognition.matching.loose import sigma_points

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

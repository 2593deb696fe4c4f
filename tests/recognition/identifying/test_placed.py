"""Sure of a name is not sure of a pose."""

import numpy as np
import pytest

from models import parts
from models.library import Library
from models.solid import Solid
from primitives.arrays import frozen
from primitives.pose import pose
from recognition.identifying.placed import is_placed
from recognition.matching import Belief, Hypothesis


@pytest.fixture(scope="module")
def wedge():
    return Library.of({"wedge": Solid.from_csg(parts.build("wedge"))})["wedge"]


def _belief(*modes):
    covariance = frozen(np.diag([1e-4] * 6))
    made = [
        Hypothesis("wedge", frozen(at), float(np.log(p)), covariance, 0.0, frozen(np.zeros(1)))
        for p, at in modes
    ]
    return Belief(tuple(made), {"wedge": 0.98, "unknown": 0.02})


def test_a_second_pose_far_away_is_not_placed(wedge):
    there = pose(np.eye(3), [5.0, 0.0, 0.0])
    assert not is_placed(_belief((0.7, np.eye(4)), (0.28, there)), wedge, 0.95)
    assert is_placed(_belief((0.97, np.eye(4)), (0.01, there)), wedge, 0.95)


def test_poses_beside_each_other_are_one(wedge):
    beside = pose(np.eye(3), [0.5, 0.0, 0.0])
    assert is_placed(_belief((0.5, np.eye(4)), (0.48, beside)), wedge, 0.95)

import itertools

import numpy as np
import pytest

from exploration.planning.ways.transit import Support, TransitConfig, box_supports, way
from primitives import pose as se3

BOX = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])
CLEARANCE = TransitConfig().clearance


def lying_on(normal, radius=20.0):
    """A pad against a sphere of that radius, and the plane that supports it there."""
    n = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    return se3.pose(se3.frame_along(-n), radius * n), Support(radius * n, n)


def along(poses, steps=60):
    for a, b in itertools.pairwise(poses):
        for s in np.linspace(0.0, 1.0, steps):
            yield (1 - s) * a[:3, 3] + s * b[:3, 3]


@pytest.mark.parametrize("far", [[0, 0, 1], [1, 0, 1], [1, 0, 0], [1, 0.1, -1], [0.05, 0, -1], [0, 0, -1]])
def test_a_way_round_a_sphere_never_enters_it(far):
    start, near = lying_on([0.0, 0.0, 1.0])
    goal, beyond = lying_on(far)
    goal = goal @ se3.pose(translation=[0.0, 0.0, -8.0])
    poses = way(start, near, goal, beyond, box_supports(BOX))
    np.testing.assert_allclose(poses[-1], goal)
    assert min(np.linalg.norm(p) for p in along([start, *poses])) > 20.0 - 1e-9
    assert min(np.linalg.norm(p[:3, 3]) for p in poses[:-1]) > 20.0 + CLEARANCE - 1e-6


def test_a_way_turns_the_pad_from_one_attitude_to_the_other():
    start, near = lying_on([0.0, 0.0, 1.0])
    goal, far = lying_on([1.0, 0.2, 0.1])
    poses = way(start, near, goal, far, box_supports(BOX))
    np.testing.assert_allclose(poses[0][:3, :3], start[:3, :3], atol=1e-12)
    np.testing.assert_allclose(poses[-2][:3, :3], goal[:3, :3], atol=1e-9)


def test_known_supports_shorten_the_way_to_the_other_side():
    start, near = lying_on([0.0, 0.0, 1.0])
    goal, far = lying_on([0.0, 0.0, -1.0])
    side = lying_on([1.0, 0.0, 0.0])[1]

    def length(poses):
        path = [start, *poses]
        return sum(np.linalg.norm(b[:3, 3] - a[:3, 3]) for a, b in itertools.pairwise(path))

    around = length(way(start, near, goal, far, box_supports(BOX)))
    assert length(way(start, near, goal, far, [side, *box_supports(BOX)])) < 0.7 * around

import numpy as np
import pytest

from primitives.segmentation.strips import apart


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.3])
def test_two_lands_of_a_face_are_told_by_the_empty_strip_between_them(turn):
    rng = np.random.default_rng(0)
    left = rng.random((30, 2)) * [5.0, 6.0]
    right = rng.random((30, 2)) * [5.0, 6.0] + [9.0, 0.0]
    cos, sin = np.cos(turn), np.sin(turn)
    found = apart(np.concatenate([left, right]) @ np.array([[cos, sin], [-sin, cos]]), 1.0)
    assert sorted(sorted(part.tolist()) for part in found) == [list(range(30)), list(range(30, 60))]


def test_a_strip_across_the_hollow_of_a_ring_parts_nothing():
    rng = np.random.default_rng(1)
    n = 200
    r, turn = np.sqrt(rng.uniform(15**2, 17**2, n)), rng.uniform(0, 2 * np.pi, n)
    assert len(apart(np.stack([r * np.cos(turn), r * np.sin(turn)], axis=1), 1.0)) == 1


def test_nothing_and_one_contact_are_left_as_they_are():
    assert [len(part) for part in apart(np.empty((0, 2)), 1.0)] == [0]
    assert [len(part) for part in apart(np.zeros((1, 2)), 1.0)] == [1]

"""Round gaps in a flat face."""

import numpy as np

from exploration.planning.open.gaps import gaps

Z = np.eye(3)[2]
GRID = np.stack(np.meshgrid(np.arange(-16.0, 17.0, 2.0), np.arange(-16.0, 17.0, 2.0)), axis=-1).reshape(-1, 2)


def face(radius, felt):
    """Places felt and found free, of a face with a hole in its middle."""
    away = np.hypot(*GRID.T)
    cells = GRID[(away > radius) & felt(GRID)]
    free = np.array([[a, b] for a in (-1.0, 0.0, 1.0) for b in (-1.0, 0.0, 1.0)])
    return np.column_stack([cells, np.zeros(len(cells))]), np.column_stack([free, np.full(len(free), -0.5)])


def test_a_gap_felt_round_is_a_circle():
    (rim,) = gaps(*face(5.0, lambda xy: np.ones(len(xy), bool)), Z, 0)
    assert np.linalg.norm(rim.center) < 0.5
    assert 4.0 < rim.radius < 7.0


def test_so_is_one_that_a_few_ways_lead_past():
    past = lambda xy: (np.abs(np.arctan2(xy[:, 1], xy[:, 0])) > 0.45) | (xy[:, 0] > 11.0)  # noqa: E731
    (rim,) = gaps(*face(5.0, past), Z, 0)
    assert np.linalg.norm(rim.center) < 1.0
    assert 4.0 < rim.radius < 7.0


def test_a_slot_is_none_nor_is_what_is_between_two_tines():
    slot = lambda xy: np.abs(xy[:, 1]) > 5.0  # noqa: E731
    assert gaps(*face(5.0, slot), Z, 0) == []
    tines = lambda xy: (np.abs(xy[:, 0]) > 11.0) & (np.abs(xy[:, 1]) < 13.0)  # noqa: E731
    assert gaps(*face(11.0, tines), Z, 0) == []

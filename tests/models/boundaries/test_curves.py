"""Edges along curves."""

import numpy as np
import pytest

from models.boundaries.curves import edge_between, refined


def around(turns):
    points = np.column_stack([5.0 * np.cos(turns), 5.0 * np.sin(turns), np.zeros(len(turns))])
    up, out = np.tile([0.0, 0.0, 1.0], (len(turns) - 1, 1)), np.tile([1.0, 0.0, 0.0], (len(turns) - 1, 1))
    return edge_between(0, (0, 1), points, None, (up, out), 1.0, 1e-6)


def test_a_circle_is_refined_on_the_circle():
    edge = around(np.linspace(0.0, 2.0 * np.pi, 9))
    assert edge.curve == "circle"
    fine = refined(edge)
    assert len(fine) == 65
    assert np.linalg.norm(fine, axis=1) == pytest.approx(5.0, abs=1e-9)


def test_a_chord_through_the_center_of_a_circle_stays_as_it_is():
    edge = around(np.array([0.0, 1.0, 2.0, np.pi, 2.0 * np.pi]))
    assert edge.curve == "circle"
    assert np.isfinite(refined(edge)).all()
    assert np.array_equal(refined(edge), edge.points)

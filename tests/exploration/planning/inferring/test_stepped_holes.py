"""Counterbores of which the two rims are all that is known."""

from dataclasses import replace

import numpy as np

from exploration.planning.inferring.stepped_holes import stepped_holes
from exploration.planning.open.round_rims import RoundRim
from primitives.evidence import NOT_FELT

UP = np.array([0.0, 0.0, 1.0])
TOP = RoundRim(np.array([3.0, 1.0, 12.0]), UP, 15.0, 0.02, 0, measured=True)
BOTTOM = RoundRim(np.array([3.1, 1.0, 0.0]), -UP, 9.0, 0.02, 1, measured=True)


def test_a_hole_that_is_wider_on_top_has_a_ledge_half_way_down():
    (step,) = stepped_holes([BOTTOM, TOP])
    assert step.rim is TOP
    assert step.hole.radius == 15.0
    assert step.hole.holds(np.array([[16.0, 1.0, 7.0]])).all()
    assert not step.hole.holds(np.array([[16.0, 1.0, 4.0]])).any()
    ledge = step.ledge
    assert np.allclose(ledge.points[:, 2], 6.0)
    assert np.allclose(ledge.normals, UP)
    assert (ledge.touch == NOT_FELT).all()
    away = np.hypot(ledge.points[:, 0] - 3.0, ledge.points[:, 1] - 1.0)
    assert 9.0 < away.min() <= away.max() < 15.0


def test_rims_alike_beside_each_other_or_only_guessed_make_no_step():
    assert stepped_holes([TOP, replace(BOTTOM, radius=14.5)]) == []
    assert stepped_holes([TOP, replace(BOTTOM, center=np.array([8.0, 1.0, 0.0]))]) == []
    assert stepped_holes([TOP, replace(BOTTOM, axis=UP)]) == []
    assert stepped_holes([replace(TOP, measured=False), replace(BOTTOM, measured=False)]) == []

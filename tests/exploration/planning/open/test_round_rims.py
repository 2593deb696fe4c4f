"""Rims of round openings."""

import numpy as np

from exploration.planning.open.round_rims import RoundRim


def test_what_was_felt_within_a_rim_at_its_level_leaves_no_opening():
    rim = RoundRim(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0, 0.1, 0)
    around, floor = (
        np.array([[9.8, 0.0, 0.0], [0.0, -9.8, 0.0]]),
        np.array([[0.0, 0.0, -5.0], [2.0, 0.0, -5.0]]),
    )
    bulge = np.array([[3.0, 0.0, 1.0], [0.0, 4.0, 0.5]])
    assert not rim.felt_over(np.concatenate([around, floor]))
    assert not rim.felt_over(bulge[:1])  # one may be a stray
    assert rim.felt_over(np.concatenate([around, bulge]))

"""A slot in a face is a dent; where a face ends, or one taxel is dead, is none."""

import numpy as np

from exploration.planning.open.dents import dented

UP = np.array([0.0, 0.0, 1.0])


def grid(*axes, step=2.0):
    flat = np.stack(np.meshgrid(*(np.arange(*axis, step) for axis in axes)), axis=-1).reshape(-1, 2)
    return np.column_stack([flat, np.zeros(len(flat))])


PLATE = grid((0.0, 60.0), (0.0, 40.0))


def test_a_face_with_a_slot_is_dented_and_one_that_ends_is_not():
    slot = np.abs(PLATE[:, 0] - 30.0) < 8.0
    free = grid((24.0, 36.0), (0.0, 40.0), step=1.0)
    assert dented(PLATE[~slot], free, UP)
    beyond = grid((61.0, 75.0), (-10.0, 50.0), step=1.0)
    assert not dented(PLATE, beyond, UP)


def test_a_dead_taxel_or_a_place_at_the_rim_is_no_dent():
    assert not dented(PLATE, np.array([[30.0, 20.0, 0.0]]), UP)
    assert not dented(PLATE, grid((0.0, 2.0), (0.0, 40.0), step=1.0), UP)

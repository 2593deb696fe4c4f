"""A plate with a slot that nothing went into, as the skin would have felt its two faces."""

import numpy as np
import pytest

from exploration.planning.inferring.slots import Slot, slots
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face
from primitives.shapes import Plane

LONG, WIDE, THICK = 50.0, 10.0, 8.0  # [mm] of the slot over its round ends
CENTER = np.array([4.0, -6.0])
BRIDGED = 1.2  # [mm] that the skin feels past a rim


def outside(x, y, less=0.0):
    """Whether a place is off the slot, less a band inside its rim."""
    past = np.maximum(np.abs(x - CENTER[0]) - 0.5 * (LONG - WIDE), 0.0)
    return np.hypot(past, y - CENTER[1]) > 0.5 * WIDE - less


def face(number, height, side, keep=outside):
    """A face of the plate, felt every 2 mm where there is any, and free where there is none."""
    grid = np.array(np.meshgrid(np.arange(-45.0, 46.0, 2.0), np.arange(-30.0, 31.0, 2.0))).reshape(2, -1)
    x, y = grid + np.random.default_rng(number).uniform(-0.5, 0.5, grid.shape)
    on = keep(x, y, BRIDGED)
    felt = np.column_stack([x[on], y[on], np.full(int(on.sum()), height)])
    off = np.column_stack([x[~on], y[~on], np.full(int((~on).sum()), height - 0.6 * side)])
    normals = np.tile([0.0, 0.0, side], (len(felt), 1))
    contacts = Contacts.of(felt, normals, 0.02, 0.02, touch=number)
    found = fit("plane", contacts)
    return KnownFace(Face(number, found, contacts), found, 1.0 if found.convex else -1.0, felt, off)


def plate(bottom=outside):
    return [face(0, 0.5 * THICK, 1.0), face(1, -0.5 * THICK, -1.0, bottom)]


def test_a_gap_in_two_faces_is_a_slot_of_its_size():
    (found,) = slots(plate())
    assert np.allclose(found.center, [*CENTER, 0.0], atol=1.0)
    assert abs(found.along[0]) == pytest.approx(1.0, abs=1e-3)
    assert (found.width, found.depth) == (pytest.approx(WIDE, abs=1.5), pytest.approx(THICK, abs=0.1))
    assert found.length == pytest.approx(LONG, abs=3.0)
    assert found.sigma >= 0.5


def test_a_gap_before_a_face_that_is_there_goes_not_through():
    assert slots(plate(lambda x, y, less: np.ones_like(x, dtype=bool))) == []


def test_a_round_gap_and_a_face_that_ends_are_no_slots():
    def hole(x, y, less):
        return np.hypot(x, y) > 10.0 - less

    def short(x, y, less):
        return x < 20.0 + less

    for keep in (hole, short):
        assert slots([face(0, 4.0, 1.0, keep), face(1, -4.0, -1.0, keep)]) == []


def test_the_walls_look_into_the_slot_and_are_where_measured_ones_say():
    slot = Slot(np.zeros(3), np.eye(3)[2], np.eye(3)[0], LONG, 8.0, THICK, 0.5)
    walls = [Plane([0, 5.0, 0], [0, -1.0, 0]), Plane([0, -4.6, 0], [0, 1.0, 0])]
    better = slot.between(walls)
    assert better.width == pytest.approx(9.6)
    assert better.center[1] == pytest.approx(0.2)
    for lot in (*better.sides(), *better.ends()):
        toward = better.center - lot.points
        toward[:, 0] -= np.clip(toward[:, 0], -0.5 * (LONG - 9.6), 0.5 * (LONG - 9.6))
        toward[:, 2] = 0.0
        assert (lot.touch < 0).all()
        assert (toward * lot.normals).sum(axis=1) == pytest.approx(4.8)


def test_a_slanting_edge_at_a_round_end_is_a_part_of_it():
    x, _, z = np.eye(3)
    slot = Slot(np.zeros(3), z, x, LONG, WIDE, THICK, 0.5)
    end = 0.5 * (LONG - WIDE) * x + 0.5 * WIDE * np.array([0.6, 0.8, 0.0]) + 0.5 * THICK * z
    assert slot.rounds(end, np.array([0.6, 0.8, 0.0]))
    assert not slot.rounds(end, x)  # of a straight end
    assert not slot.rounds(end - 20.0 * x, np.array([0.6, 0.8, 0.0]))  # beside its straight part
    assert not slot.rounds(end + 9.0 * z, np.array([0.6, 0.8, 0.0]))

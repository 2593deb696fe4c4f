"""Ends of a slot through a plate, whose faces were seen beside it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.inferring.slot_ends import as_seen, flat_ends
from exploration.planning.inferring.slots import Slot
from exploration.planning.known.mosaic import Mosaic, Picture
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face

X, _, Z = np.eye(3)
LONG, WIDE, THICK = 50.0, 10.0, 8.0  # [mm] over its round ends
CENTER = np.array([4.0, -6.0])
SLOT = Slot(np.array([*CENTER, 0.0]), Z, X, LONG, WIDE, THICK, 0.5)


def beyond(x, y):
    """Whether places are off the slot."""
    past = np.maximum(np.abs(x - CENTER[0]) - 0.5 * (LONG - WIDE), 0.0)
    return np.hypot(past, y - CENTER[1]) > 0.5 * WIDE


class Pictured:
    """A mosaic that saw both faces of the plate, with a slot whose ends are round, or square."""

    config = SimpleNamespace(step=0.5)

    def __init__(self, square=False):
        self.square = square

    def picture(self, anchor, normal, lattice):
        i, j = np.meshgrid(*(np.arange(count) for count in lattice.shape), indexing="ij")
        x, y, _ = np.moveaxis(
            (lattice.origin + lattice.step * np.stack([i, j], axis=-1)) @ lattice.along.T, -1, 0
        )
        within = (np.abs(x - CENTER[0]) < 0.5 * LONG) & (np.abs(y - CENTER[1]) < 0.5 * WIDE)
        there = ~within if self.square else beyond(x, y)
        return Picture(there.astype(float), np.ones_like(there))


def test_a_flat_end_across_a_slot_is_none_where_the_faces_round_it_show_its_corners():
    end = CENTER[0] + 0.5 * LONG - 0.8
    across = [(end, CENTER[1] + t, z) for t in (-3.0, 0.0, 3.0) for z in (-2.0, 2.0)]
    along = [(CENTER[0] + t, CENTER[1] + 0.5 * WIDE, z) for t in (-9.0, 0.0, 9.0) for z in (-2.0, 2.0)]
    felt = [(end + 0.1, y, z) for _, y, z in across]
    lots = [
        Contacts.of(np.array(across), np.tile([-1.0, 0.0, 0.0], (6, 1)), 0.1, 0.05, touch=NOT_FELT),
        Contacts.of(np.array(along), np.tile([0.0, -1.0, 0.0], (6, 1)), 0.1, 0.05, touch=NOT_FELT),
        Contacts.of(np.array(felt), np.tile([-1.0, 0.0, 0.0], (6, 1)), 0.1, 0.05, touch=3),
    ]
    faces = [Face(number, fit("plane", lot), lot) for number, lot in enumerate(lots, start=5)]
    assert flat_ends(SLOT, faces, Pictured()) == {5}
    assert flat_ends(SLOT, faces, Pictured(square=True)) == set()
    assert flat_ends(SLOT, faces, Mosaic()) == set()
    assert flat_ends(replace(SLOT, width=6.0), faces, Pictured()) == set()


def test_a_slot_ends_where_pictures_show_it():
    longer = replace(SLOT, center=SLOT.center + 1.5 * SLOT.along, length=SLOT.length + 4.0)
    seen = as_seen(longer, Pictured())
    assert seen.length == pytest.approx(LONG, abs=0.6)
    assert np.abs(seen.center[:2] - CENTER).max() < 0.4
    assert as_seen(longer, Mosaic()).length == pytest.approx(longer.length)

"""Ends of a slot through a plate, whose faces were seen beside it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import norm

from exploration.planning.inferring.slot_ends import as_seen, bounded, flat_ends
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
    """A mosaic that saw both faces of the plate, softly, with a slot whose ends are round, or square."""

    config = SimpleNamespace(step=0.5)
    soft = 1.4 * norm.ppf((np.arange(20) + 0.5) / 20)  # [mm]

    def __init__(self, square=False):
        self.square = square

    def picture(self, anchor, normal, lattice):
        share = np.mean([self.there(lattice, dx, dy) for dx in self.soft for dy in self.soft], axis=0)
        return Picture(share, np.ones_like(share, dtype=bool))

    def there(self, lattice, dx, dy):
        i, j = np.meshgrid(*(np.arange(count) for count in lattice.shape), indexing="ij")
        at = lattice.origin + lattice.step * np.stack([i, j], axis=-1) + [dx, dy]
        x, y, _ = np.moveaxis(at @ lattice.along.T, -1, 0)
        within = (np.abs(x - CENTER[0]) < 0.5 * LONG) & (np.abs(y - CENTER[1]) < 0.5 * WIDE)
        return ~within if self.square else beyond(x, y)


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


def test_of_a_narrow_slot_that_is_taken_for_round_no_end_is_put_far_past_what_was_seen():
    narrow = replace(SLOT, width=3.0)
    assert LONG - 1.5 < as_seen(narrow, Pictured()).length < LONG + 0.8


@pytest.mark.parametrize("square", [False, True])
def test_a_slot_ends_where_pictures_show_it(square):
    longer = replace(SLOT, center=SLOT.center + 1.5 * SLOT.along, length=SLOT.length + 4.0)
    seen = as_seen(longer, Pictured(square))
    assert seen.length == pytest.approx(LONG, abs=0.2)
    assert np.abs(seen.center[:2] - CENTER).max() < 0.1
    assert as_seen(longer, Mosaic()).length == pytest.approx(longer.length)


def test_a_wall_beside_a_slot_ends_where_the_round_end_begins():
    reach = np.array([-9.0, 0.0, 9.0, 0.5 * (LONG - WIDE) + 2.0, 0.5 * LONG + 1.0])
    places = np.array([(CENTER[0] + t, CENTER[1] + 0.5 * WIDE + 0.2, z) for t in reach for z in (-2.0, 2.0)])
    looks, end = np.tile([0.0, -1.0, 0.0], (len(places), 1)), CENTER[0] + 0.5 * LONG
    guessed, felt = (Contacts.of(places, looks, 0.1, 0.05, touch=touch) for touch in (NOT_FELT, 3))
    across = np.array([(end, CENTER[1] + t, z) for t in (-3.0, 0.0, 3.0) for z in (-2.0, 2.0)])
    flat = Contacts.of(across, np.tile([-1.0, 0.0, 0.0], (6, 1)), 0.1, 0.05, touch=NOT_FELT)
    lots = guessed, felt, flat, Contacts.of(flat.points, flat.normals, 0.1, 0.05, touch=3)
    wall, known, end_wall, felt_end = (
        Face(number, fit("plane", lot), lot) for number, lot in enumerate(lots)
    )
    left, same = bounded([wall, known], SLOT)
    assert left.contacts.points[:, 0].max() == pytest.approx(CENTER[0] + 9.0)
    assert len(left.contacts) == 6
    assert same is known
    assert bounded([wall, end_wall], SLOT)[0] is bounded([wall, felt_end], SLOT)[0] is wall
    past = wall.only(places[:, 0] > CENTER[0] + 0.5 * (LONG - WIDE))
    assert bounded([past], SLOT) == ()
    for lot in SLOT.sides():
        own = Face(9, fit("plane", lot), lot)
        assert bounded([own], SLOT)[0] is own


@pytest.mark.parametrize(("aside", "width"), [(0.8, WIDE - 1.7), (-0.5, WIDE + 1.0)])
def test_its_sides_are_where_they_were_seen(aside, width):
    taken = replace(SLOT, center=SLOT.center + aside * np.eye(3)[1], width=width)
    seen = as_seen(taken, Pictured())
    assert seen.width == pytest.approx(WIDE, abs=0.2)
    assert np.allclose(seen.center, SLOT.center, atol=0.2)
    assert as_seen(taken, Mosaic()).width == width


def test_one_that_would_get_wider_than_it_is_long_stays():
    assert as_seen(replace(SLOT, length=10.5, width=6.0), Pictured()).width == 6.0

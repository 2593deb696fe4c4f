"""Round holes of a body that its faces do not bound."""

import numpy as np
import pytest

from models.csg import Cube
from models.solid import Solid
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.pose import pose
from recognition.assembly.bored import BORED, bored
from recognition.assembly.made import Body
from recognition.assembly.piece import Piece
from recognition.best_body import FeltFace

BLOCK = Cube((60.0, 40.0, 30.0))
OUTSIDE = np.random.default_rng(0).uniform(-1.0, 1.0, (400, 3)) * [30.0, 20.0, 0.0] + [0.0, 0.0, 15.0]


def block():
    piece = Piece("polyhedron", "add", BLOCK, pose(np.eye(3), np.zeros(3)), None, ())
    return Body((piece,), Solid.from_csg(BLOCK), 0.01)


def wall(radius=8.0, low=-10.0, high=10.0, inward=True, touch=NOT_FELT):
    """Contacts of a round hole along z."""
    turn, height = (lot.ravel() for lot in np.meshgrid(np.arange(0.0, 6.2, 0.5), [low, 0.0, high]))
    ways = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    points = radius * ways + np.outer(height, [0.0, 0.0, 1.0])
    contacts = Contacts.of(points, -ways if inward else ways, 0.05, 0.05, touch=touch)
    return FeltFace(fit("cylinder", contacts), contacts)


def less(face, felt=OUTSIDE):
    return bored(block(), [face], [face.fit.shape], felt)


def test_an_inferred_hole_whose_contacts_stop_short_of_its_ends_goes_through():
    made = less(wall(), OUTSIDE[np.hypot(*OUTSIDE[:, :2].T) > 8.0])
    assert [piece.why for piece in made.pieces] == ["", BORED]
    assert made.solid.volume == pytest.approx(60.0 * 40.0 * 30.0 - np.pi * 64.0 * 30.0, rel=0.002)


def test_a_felt_one_ends_just_past_its_contacts():
    made = less(wall(low=0.0, high=14.9, touch=3), OUTSIDE[np.hypot(*OUTSIDE[:, :2].T) > 8.0])
    assert made.solid.volume == pytest.approx(60.0 * 40.0 * 30.0 - np.pi * 64.0 * 16.0, rel=0.002)


def test_none_is_taken_where_the_object_was_felt_nor_for_a_boss():
    assert len(less(wall()).pieces) == 1  # its top was felt across the hole
    assert len(less(wall(inward=False), OUTSIDE[:5]).pieces) == 1

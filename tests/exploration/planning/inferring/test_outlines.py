"""Straight edges of a plate, from where its two sides were felt last."""

import numpy as np
import pytest

from exploration.planning.inferring.outlines import outline_walls
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face

THICK = 2.0  # [mm]
PAST = 1.0  # [mm] of an edge that the skin feels, as it bends over it


def side(number, height, up, inside):
    """A side felt every 2 mm or so where `inside` says that there is one, and free beside it."""
    grid = np.array(np.meshgrid(np.arange(-41.0, 42.0, 2.0), np.arange(-41.0, 42.0, 2.0))).reshape(2, -1)
    x, y = grid + np.random.default_rng(number).uniform(-0.8, 0.8, grid.shape)
    on = inside(x, y)
    felt = np.column_stack([x[on], y[on], np.full(int(on.sum()), height)])
    free = np.column_stack([x[~on], y[~on], np.full(int((~on).sum()), height - 0.6 * up)])
    normals = np.tile([0.0, 0.0, up], (len(felt), 1))
    contacts = Contacts.of(felt, normals, 0.02, 0.02, touch=number)
    found = fit("plane", contacts)
    return KnownFace(Face(number, found, contacts), found, 1.0 if found.convex else -1.0, felt, free)


def walls(inside, other=None, thick=THICK, faces=()):
    """Each wall's way out and how far out along it, (k, 2) and (k,), the farthest way round first."""
    known = [side(0, 0.5 * thick, 1.0, inside), side(1, -0.5 * thick, -1.0, other or inside)]
    lots = outline_walls(known, [own.rim for own in known], [*(own.face for own in known), *faces])
    assert all((lot.touch == NOT_FELT).all() for lot in lots)
    assert all(np.abs(lot.points[:, 2]).max() < 0.5 * thick for lot in lots)
    return np.array([[*lot.normals[0, :2], (lot.points @ lot.normals[0]).mean()] for lot in lots]).reshape(
        -1, 3
    )


def rectangle(x, y):
    return (np.abs(x) < 30.0 + PAST) & (np.abs(y) < 20.0 + PAST)


def disc(x, y):
    return np.hypot(x, y) < 30.0 + PAST


def test_the_four_sides_of_a_thin_plate_are_where_both_its_faces_end():
    found = walls(rectangle)
    assert len(found) == 4
    for way, far in (([1, 0], 30.0), ([-1, 0], 30.0), ([0, 1], 20.0), ([0, -1], 20.0)):
        (own,) = [row for row in found if row[:2] @ way > 0.99]
        assert own[2] == pytest.approx(far, abs=1.0)


def test_a_notch_has_three_sides_and_what_is_straight_beside_it_stays():
    found = walls(lambda x, y: rectangle(x, y) & ~((x > 14.0 + PAST) & (np.abs(y) < 9.0 - PAST)))
    ways = found[:, :2]
    assert ((ways @ [1.0, 0.0] > 0.98) & (np.abs(found[:, 2] - 14.0) < 1.0)).any()
    for sign in (1.0, -1.0):
        assert ((ways @ [0.0, sign] > 0.98) & (np.abs(found[:, 2] + 9.0) < 1.2)).any()


def test_a_disc_has_no_straight_edge():
    assert not len(walls(disc))


def test_what_only_one_side_shows_or_a_thick_body_is_no_edge_of_a_plate():
    wide = walls(rectangle, lambda x, y: np.maximum(np.abs(x), np.abs(y)) < 38.0)
    assert not len(wide)
    assert not len(walls(rectangle, thick=30.0))


def test_an_edge_that_a_face_explains_is_not_told_twice():
    at = np.array([[30.0, y, z] for y in np.arange(-18.0, 19.0, 4.0) for z in (-0.5, 0.5)])
    felt = Contacts.of(at, np.tile([1.0, 0.0, 0.0], (len(at), 1)), 0.02, 0.02, touch=7)
    found = walls(rectangle, faces=[Face(7, fit("plane", felt), felt)])
    assert len(found) == 3
    assert not (found[:, 0] > 0.9).any()

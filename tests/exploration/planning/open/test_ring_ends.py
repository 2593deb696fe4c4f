"""Which flat faces are the ends of tubes."""

from dataclasses import replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.ring_ends import RingEndsConfig, bare_ends, ring_ends
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

TURN = np.linspace(0.0, 2.0 * np.pi, 60)
RING = np.column_stack([np.cos(TURN), np.sin(TURN), np.zeros(60)])
UP = np.array([0.0, 0.0, 1.0])
NOWHERE = np.empty((0, 3))


def known(number, points, normals, free=NOWHERE):
    face, felt = ranked_face(number, Contacts.of(points, normals), MergeOptions()), SurfaceMap()
    felt.add(points, normals)
    return KnownFace.of(face, face.fit, felt, free, 5.0)


def flat_ring(radii, free):
    points = np.concatenate([radius * RING for radius in radii])
    return known(0, points, np.tile(UP, (len(points), 1)), free)


BARREL = known(1, np.concatenate([16.0 * RING - z * UP for z in (4.0, 14.0, 24.0)]), np.tile(RING, (3, 1)))
INSIDE = 6.0 * RING[::4] - 0.5 * UP
END = flat_ring((13.5, 15.0), INSIDE)


def test_a_ring_at_the_end_of_a_barrel_is_looked_at_within_the_barrel():
    (rim,) = ring_ends([END, BARREL])
    assert np.allclose(rim.center, 0.0, atol=0.05)
    assert rim.axis @ UP > 0.999
    assert abs(rim.outer - 16.0) < 0.05
    assert abs(rim.radius - 13.5) < 0.5


def test_an_end_felt_over_its_middle_or_free_nowhere_is_none():
    full = flat_ring((1.0, 5.0, 9.0, 13.5), 20.0 * RING - 0.5 * UP)
    assert ring_ends([full, BARREL]) == []
    assert ring_ends([flat_ring((13.5, 15.0), NOWHERE), BARREL]) == []


def test_a_flange_round_the_barrel_or_a_bore_for_it_makes_no_ring():
    for radii in ((19.0, 25.0), (11.0, 15.0, 19.0, 24.0)):
        assert ring_ends([flat_ring(radii, INSIDE), BARREL]) == []
    assert ring_ends([END, replace(BARREL, side=-1.0)]) == []
    assert ring_ends([END, BARREL], RingEndsConfig(largest=15.0)) == []


def test_a_plate_beside_the_barrel_may_end_in_the_same_plane():
    plate = np.array([[x, y, 0.0] for x in (22.0, 30.0, 38.0) for y in (-12.0, 0.0, 12.0)])
    contacts = Contacts.concatenate([END.face.contacts, Contacts.of(plate, np.tile(UP, (9, 1)), 0.01, 0.01)])
    cells = np.concatenate([END.cells, plate])
    knuckle = replace(END, face=replace(END.face, contacts=contacts), cells=cells)
    (rim,) = ring_ends([knuckle, BARREL])
    assert abs(rim.outer - 16.0) < 0.05
    assert abs(rim.radius - 13.5) < 0.5


def outer_rim(up, way=UP, face=1):
    """The rim of the barrel as seen from its side at a height."""
    x, y, _ = np.eye(3)
    return Sighting(16.0 * x + up * UP, y, way, x, 0.05, 14.0), face


def test_a_tube_of_whose_end_only_the_outer_rim_was_seen_has_a_bore_as_wide_as_was_free():
    free = np.concatenate([radius * RING for radius in (3.0, 8.0, 13.0)]) - UP
    (rim,) = bare_ends([BARREL], [outer_rim(0.0)], lambda: free)
    assert np.allclose(rim.center, 0.0, atol=0.05)
    assert rim.axis @ UP > 0.999
    assert 12.0 < rim.radius < 14.0
    assert abs(rim.outer - 16.0) < 0.05
    assert rim.face == 1


def test_no_bore_is_looked_for_where_nothing_is_free_or_the_end_is_known_or_no_end():
    free = 8.0 * RING - UP
    assert bare_ends([BARREL], [outer_rim(0.0)], lambda: NOWHERE) == []
    assert bare_ends([BARREL], [outer_rim(0.0)], lambda: 15.9 * RING - UP) == []
    assert bare_ends([BARREL, END], [outer_rim(0.0)], lambda: free) == []
    assert bare_ends([BARREL], [outer_rim(-12.0)], lambda: free - 12.0 * UP) == []
    assert bare_ends([BARREL], [outer_rim(0.0, face=2)], lambda: free) == []
    assert bare_ends([BARREL], [outer_rim(0.0, np.eye(3)[1])], lambda: free) == []

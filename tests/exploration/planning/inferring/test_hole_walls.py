"""Round holes between the rims at their ends, and what is no end of one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.hole_walls import _ended, _holes, _part_of, _told_by, add_holes
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.holes import Hole
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Bore, Findings
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]


@pytest.mark.parametrize(("aside", "depth"), [(0.0, 6.0), (60.0, 40.0)])
def test_a_hole_ends_at_the_face_that_it_comes_out_of(aside, depth):
    """An array that went through a plate of 6 mm went on below it; a face beside that is no end of the hole."""
    places = np.array([[x + aside, y, 0.0] for x in (-15.0, 0.0, 15.0) for y in (-15.0, 0.0, 15.0)])
    below = ranked_face(1, Contacts.of(places, np.tile(-Z, (9, 1))), MergeOptions())
    hole = _ended(Hole(-14.0 * Z, Z, 5.0, 40.0, 0.05), [below])
    assert hole.depth == pytest.approx(depth)
    assert hole.middle[2] + 0.5 * hole.depth == pytest.approx(6.0)


def test_a_hole_between_two_rims_goes_on_past_a_floor_beside_it():
    """Through the island in a pocket, whose floor is nearer than its far rim."""
    turn = np.linspace(0.0, 6.0, 12)
    floor = np.column_stack([14.0 * np.cos(turn), 14.0 * np.sin(turn), np.full(12, -3.0)])
    found = Findings()
    found.graph, own = found.graph.add_stroke(Contacts.of(floor, np.tile(Z, (12, 1))))
    rims = [RoundRim(8.0 * side * Z, side * Z, 5.9, 0.02, own, True) for side in (-1.0, 1.0)]
    assert not _holes(found, rims, [], np.empty((0, 3)), [])
    wall = found.graph.faces[-1].contacts.points[:, 2]
    assert wall.min() < -5.0
    assert wall.max() > 5.0


@pytest.mark.parametrize(("felt", "radius"), [(7.2, 7.2), (7.93, 8.0)])
def test_a_hole_whose_rims_are_chamfered_is_as_narrow_as_it_was_felt(felt, radius):
    turn = np.linspace(0.0, 6.0, 12)
    face = np.column_stack([14.0 * np.cos(turn), 14.0 * np.sin(turn), np.full(12, 8.0)])
    found = Findings(bores=[Bore(np.array([0.1, 0.0, 8.0]), Z, felt, 9.0)])
    found.graph, own = found.graph.add_stroke(Contacts.of(face, np.tile(Z, (12, 1))))
    rims = [RoundRim(8.0 * side * Z, side * Z, 8.0, 0.02, own, True) for side in (-1.0, 1.0)]
    assert not _holes(found, rims, [], np.empty((0, 3)), [])
    wall = found.graph.faces[-1].fit.shape
    assert wall.radius == pytest.approx(radius, abs=0.02)
    assert wall.anchor[0] == pytest.approx(0.1 if felt == radius else 0.0, abs=0.02)


def test_a_hole_that_narrows_ends_at_the_rim_that_was_looked_at():
    """And not at a narrower one, guessed where the face round it was felt."""
    found, turn = Findings(), np.linspace(0.0, 2.0 * np.pi, 25)
    ways = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    ring = np.concatenate([radius * ways for radius in (4.0, 14.0, 16.0)])
    for height, side in ((10.0, 1.0), (0.0, -1.0)):
        places = ring[25:] + height * Z
        found.graph, _ = found.graph.add_stroke(Contacts.of(places, np.tile(side * Z, (50, 1))))
    top, bottom = (face.id for face in found.graph.faces)
    found.rims = [
        RoundRim(10.0 * Z, Z, 8.0, 0.02, top, True),
        RoundRim(-0.02 * Z, -Z, 5.0, 0.02, bottom, True),
    ]
    below = found.graph.faces[1]
    known = KnownFace(below, below.fit, 1.0, ring, np.empty((0, 3)))
    now = SimpleNamespace(openings=[], narrow=[], round_gaps=[], known=[known])
    add_holes(found, lambda: now, np.array([[0.5, 0.0, z] for z in (8.0, 2.0, -6.0)]), Mosaic())
    radii = sorted(face.fit.shape.radius for face in found.graph.faces if face.fit.kind == "cylinder")
    assert np.allclose(radii, [5.0, 8.0], atol=0.01)


@pytest.mark.parametrize("above", [True, False])
def test_a_straight_edge_at_a_hole_is_a_part_of_its_rim_on_either_face(above):
    rim = Sighting(np.array([5.5, 1.0, 6.0]), np.eye(3)[1], -np.eye(3)[0], Z, 0.05, 5.0)
    hole = RoundRim(6.0 * Z, Z, 5.0, 0.05, 0) if above else RoundRim(0.0 * Z, -Z, 5.0, 0.05, 1)
    assert _part_of(rim, hole)
    assert not _part_of(replace(rim, point=np.array([9.0, 1.0, 6.0])), hole)
    assert not _part_of(replace(rim, normal=np.eye(3)[1]), hole)


def test_what_is_missing_of_a_round_face_at_a_mouth_whose_rim_was_looked_at_is_that_mouth():
    rim = RoundRim(np.array([0.0, 0.0, 45.0]), Z, 10.0, 0.02, 3, True)
    gap = RoundRim(np.array([0.2, -0.2, 42.3]), Z, 14.9, 0.3, 0, True)  # in a ball that two edges passed for
    assert _told_by(gap, rim)
    assert not _told_by(replace(gap, axis=-Z), rim)
    assert not _told_by(replace(gap, center=gap.center + 6.0 * np.eye(3)[0]), rim)
    assert not _told_by(replace(gap, center=gap.center - 30.0 * Z), rim)

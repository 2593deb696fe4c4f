"""Rims of pockets in a plate, and of its outline, over the face behind."""

from dataclasses import replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.inferring.dead_ends import dead_end
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

X, Y, Z = np.eye(3)
RIM = Sighting(np.array([0.0, 0.0, 10.0]), Y, X, Z, 0.05, 8.0)  # open to +x


def face(number, height, up, low, high):
    """Touched from `low` to `high` along x."""
    x, y = (g.ravel() for g in np.meshgrid(np.arange(low, high + 1.0), np.arange(-10.0, 11.0, 2.0)))
    points = np.column_stack([x, y, np.full(len(x), height)])
    made = ranked_face(number, Contacts.of(points, np.tile(up * Z, (len(points), 1))), MergeOptions())
    return KnownFace(made, made.fit, 1.0 if made.fit.convex else -1.0, points, np.empty((0, 3)))


def test_a_face_behind_that_goes_on_past_the_rim_ends_what_is_open_there():
    assert dead_end(RIM, 0, [face(1, 0.0, -1.0, -20.0, 20.0)])


def test_a_face_behind_that_ends_with_the_rim_lets_a_wall_come_down_to_it():
    assert not dead_end(RIM, 0, [face(1, 0.0, -1.0, -20.0, 0.0)])
    assert not dead_end(RIM, 1, [face(1, 0.0, -1.0, -20.0, 20.0)])
    assert not dead_end(RIM, 0, [])


def test_a_floor_before_it_takes_the_wall():
    assert not dead_end(RIM, 0, [face(1, 0.0, -1.0, -20.0, 20.0), face(2, 6.0, 1.0, 3.0, 20.0)])


def test_what_lies_behind_the_ends_of_a_rim_tells_nothing_of_its_middle():
    """As of a neck between a base and a barrel, both wider than it."""
    behind = face(1, 0.0, -1.0, -20.0, 20.0)
    beside = behind.cells[(behind.cells[:, 0] < 0.5) | (np.abs(behind.cells[:, 1]) > 3.5)]
    assert not dead_end(RIM, 0, [replace(behind, cells=beside)])

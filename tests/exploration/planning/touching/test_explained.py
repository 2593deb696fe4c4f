"""Which stops of strokes a known face explains."""

import numpy as np

from exploration.planning.touching.explained import unexplained_stops
from exploration.planning.touching.study import Wall
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face
from primitives.shapes import Cylinder, Plane


def stop(point, heading):
    return Wall(np.array(point), np.array(heading), np.array([0.0, 0.0, 1.0]), np.eye(4), np.ones(2))


def face(shape, points):
    contacts = Contacts.of(points, shape.normals(points), touch=np.arange(len(points)))
    return Face(0, fit(shape.kind, contacts), contacts)


def test_a_flat_face_explains_what_was_stopped_by_its_outside_anywhere_on_it():
    places = np.random.default_rng(0).uniform(-9.0, 9.0, (20, 3)) * [0.0, 1.0, 1.0]
    wall = face(Plane([0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), places)
    into, out, far = (
        stop([-1.0, 60.0, 0.0], [1.0, 0, 0]),
        stop([1.0, 0, 0], [-1.0, 0, 0]),
        stop([-9.0, 0, 0], [1.0, 0, 0]),
    )
    assert unexplained_stops([into, out, far], [wall]) == [out, far]


def test_a_round_face_explains_only_what_was_stopped_near_its_contacts():
    shape = Cylinder([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 12.0)
    turn = np.linspace(0.0, 5.0, 30)
    post = face(shape, np.column_stack([12 * np.cos(turn), 12 * np.sin(turn), np.linspace(0.0, 9.0, 30)]))
    near, far = stop([13.0, 0.0, 5.0], [-1.0, 0, 0]), stop([13.0, 0.0, 60.0], [-1.0, 0, 0])
    assert unexplained_stops([near, far], [post]) == [far]

import numpy as np

from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import MergeOptions, ranked_face

UP = np.array([0.0, 0.0, 1.0])
NOWHERE = np.empty((0, 3))


def floor(x, y=(0.0, 30.0)):
    flat = np.stack(np.meshgrid(np.arange(*x, 2.0), np.arange(*y, 2.0), indexing="ij"), axis=-1).reshape(
        -1, 2
    )
    return np.column_stack([flat, np.zeros(len(flat))])


def felt_at(points):
    felt = SurfaceMap()
    felt.add(points, np.tile(UP, (len(points), 1)))
    return felt


def face_of(points):
    return ranked_face(0, Contacts.of(points, np.tile(UP, (len(points), 1))), MergeOptions())


def known(points, free):
    face = face_of(points)
    assert isinstance(face.fit, Fit)
    return KnownFace.of(face, face.fit, felt_at(points), free, 5.0)


def test_a_face_of_which_nothing_new_is_known_is_the_one_it_was():
    points, beside = floor((0.0, 30.0)), np.array([[32.0, 10.0, -0.5]])
    first = known(points, beside)
    elsewhere = np.array([[10.0, 10.0, -40.0]])  # says nothing of this face
    assert first.grown(felt_at(points), np.concatenate([beside, elsewhere]), (len(points), 1)) is first


def test_a_face_that_grew_is_as_one_that_is_known_at_once():
    points, free = floor((0.0, 40.0)), np.array([[42.0, 10.0, -0.5], [45.0, 10.0, -0.5]])
    felt = felt_at(points[:200])
    first = KnownFace.of((face := face_of(points)), face.fit, felt, free[:1], 5.0)
    felt.add(points[200:], np.tile(UP, (len(points) - 200, 1)))
    grown = first.grown(felt, free, (200, 1))
    at_once = KnownFace.of(face, face.fit, felt, free, 5.0)
    assert grown is not first
    assert np.array_equal(grown.cells, at_once.cells)
    assert np.array_equal(grown.free, at_once.free)


def test_a_face_goes_no_further_past_its_rim():
    points = floor((0.0, 30.0))
    x, y = np.meshgrid(np.arange(31.0, 36.0), np.arange(-6.0, 36.0))
    free = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -0.5)])
    on, _ = known(points, free).further
    assert (on[:, 0] < -1.0).any()
    assert on[:, 0].max() < 30.0
    at, out = known(points, free).rim
    assert len(at) > 5
    assert (out @ [1.0, 0.0, 0.0] > 0.6).all()

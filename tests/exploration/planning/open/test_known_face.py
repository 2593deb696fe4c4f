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


def known(face, points, free, before=None):
    felt = SurfaceMap()
    felt.add(points, np.tile(UP, (len(points), 1)))
    assert isinstance(face.fit, Fit)
    return KnownFace.of(face, face.fit, felt, free, 5.0, before)


def face_of(points):
    return ranked_face(0, Contacts.of(points, np.tile(UP, (len(points), 1))), MergeOptions())


def test_a_face_of_which_nothing_new_is_known_is_the_one_it_was():
    points = floor((0.0, 30.0))
    face, beside = face_of(points), np.array([[32.0, 10.0, -0.5]])
    first = known(face, points, beside)
    elsewhere = np.array([[10.0, 10.0, -40.0]])  # says nothing of this face
    assert known(face, points, np.concatenate([beside, elsewhere]), first) is first


def test_a_face_is_another_once_it_is_fitted_again_or_touched_or_found_free_elsewhere():
    points = floor((0.0, 30.0))
    face = face_of(points)
    first = known(face, points, NOWHERE)
    assert known(face_of(points), points, NOWHERE, first) is not first
    assert known(face, floor((0.0, 40.0)), NOWHERE, first) is not first
    assert known(face, points, np.array([[32.0, 10.0, -0.5]]), first) is not first


def test_a_face_goes_no_further_past_its_rim():
    points = floor((0.0, 30.0))
    x, y = np.meshgrid(np.arange(31.0, 36.0), np.arange(-6.0, 36.0))
    free = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -0.5)])
    on, _ = known(face_of(points), points, free).further
    assert (on[:, 0] < -1.0).any()
    assert on[:, 0].max() < 30.0
    at, out = known(face_of(points), points, free).rim
    assert len(at) > 5
    assert (out @ [1.0, 0.0, 0.0] > 0.6).all()

"""Which way an object lies, for looking at it from afar."""

import numpy as np
import pytest

from exploration.planning.moves.looking import own_axes
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face
from primitives.shapes import Plane, Sphere, Torus

RING = Torus([5.0, 0, 0], [0.0, 0.6, 0.8], 22.0, 6.0)
FLOOR = Plane([0, 0, -6.0], [0.6, 0, -0.8])


def face(shape, count):
    """Contacts all over a shape, as a face."""
    points = shape.project(np.random.default_rng(0).uniform(-30, 30, (count, 3)))
    contacts = Contacts.of(points, shape.normals(points), touch=np.arange(count))
    return Face(0, fit(shape.kind, contacts), contacts)


@pytest.mark.parametrize(
    ("shapes", "along"),
    [([(RING, 60)], RING.axis), ([(RING, 60), (FLOOR, 20)], FLOOR.normal), ([(Sphere([0, 0, 0], 9.0), 30)], None)],
)  # fmt: skip
def test_the_first_is_that_of_a_flat_face_or_else_of_a_round_one(shapes, along):
    axes = own_axes([face(*shape) for shape in shapes])
    assert np.allclose(axes.T @ axes, np.eye(3))
    if along is not None:
        assert np.abs(axes.T @ along).max() == pytest.approx(1.0, abs=1e-3)

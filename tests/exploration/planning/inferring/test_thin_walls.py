"""The inner sides of an open box, whose floor and outer sides were felt."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.inferring.thin_walls import thin_walls
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.stops import Stop
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face

UP, X = np.eye(3)[2], np.eye(3)[0]
LENGTH, WIDTH, FLOOR = 100.0, 60.0, 3.0


def flat(number, points, normal):
    contacts = Contacts.of(points, np.tile(normal, (len(points), 1)), 0.01, 0.01, touch=number)
    found = fit("plane", contacts)
    side = 1.0 if found.convex else -1.0
    return KnownFace(Face(number, found, contacts), found, side, np.asarray(points), np.empty((0, 3)))


def stop(at, y=30.0, z=FLOOR):
    wall = SimpleNamespace(normal=UP, pose=np.eye(4).copy())
    wall.pose[:3, 3] = [at - 9.0, y, z]
    return Stop(wall, -X, -at)


def grid(*axes):
    return np.stack([g.ravel() for g in np.meshgrid(*axes)], axis=1)


FLAT = np.array([FLOOR])
INSIDE = flat(0, grid(np.arange(8.0, 93.0, 4.0), np.arange(8.0, 53.0, 4.0), FLAT), UP)
OUTER = flat(1, grid(np.array([LENGTH]), np.arange(3.0, 58.0, 4.0), np.arange(2.0, 29.0, 4.0)), X)


def test_the_inner_side_stands_half_way_between_floor_and_outer_side():
    (lot,) = thin_walls([INSIDE, OUTER])
    assert (lot.touch == NOT_FELT).all()
    assert lot.normals == pytest.approx(np.tile(-X, (len(lot), 1)))
    assert lot.points[:, 0] == pytest.approx(0.5 * (92.0 + LENGTH))
    assert lot.sigma.min() > 1.0
    assert lot.points[:, 2].min() > FLOOR
    assert lot.points[:, 2].max() < 28.0


def test_a_stroke_that_was_stopped_there_tells_where_it_stands():
    (lot,) = thin_walls([INSIDE, OUTER], [stop(97.0)])
    assert lot.points[:, 0] == pytest.approx(97.0)


@pytest.mark.parametrize("other", [{"at": 60.0}, {"at": 97.0, "y": 200.0}, {"at": 97.0, "z": 40.0}])
def test_a_stroke_that_was_stopped_elsewhere_does_not(other):
    (lot,) = thin_walls([INSIDE, OUTER], [stop(**other)])
    assert lot.points[:, 0] == pytest.approx(96.0)


def test_nothing_is_inferred_where_a_side_is_known_or_the_outer_side_is_low_or_far():
    inner = flat(2, grid(np.array([97.0]), np.arange(3.0, 58.0, 4.0), np.arange(5.0, 29.0, 4.0)), -X)
    assert not list(thin_walls([INSIDE, OUTER, inner]))
    low = flat(1, grid(np.array([LENGTH]), np.arange(3.0, 58.0, 4.0), np.arange(-5.0, 4.0, 2.0)), X)
    assert not list(thin_walls([INSIDE, low]))
    far = flat(1, OUTER.cells + 20.0 * X, X)
    assert not list(thin_walls([INSIDE, far]))
    aside = flat(1, OUTER.cells + 80.0 * np.eye(3)[1], X)
    assert not list(thin_walls([INSIDE, aside]))

"""A floor with a divider on it, at which one stroke was stopped."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.inferring.adding import once
from exploration.planning.inferring.dividers import DividerConfig, dividers
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.stops import Stop
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face

X, Y, UP = np.eye(3)
NEAR, FAR, CLEAR = 30.0, 33.0, 1.8  # [mm] sides of the divider, and how near to them the floor was felt


def flat(number, points, normal):
    contacts = Contacts.of(points, np.tile(normal, (len(points), 1)), 0.01, 0.01, touch=number)
    found = fit("plane", contacts)
    return KnownFace(Face(number, found, contacts), found, 1.0 if found.convex else -1.0, points, points[:0])


def floor(keep=lambda x, y: (x < NEAR - CLEAR) | (x > FAR + CLEAR)):
    x, y = (g.ravel() for g in np.meshgrid(np.arange(2.0, 60.0, 1.4), np.arange(4.0, 56.0, 4.0)))
    kept = keep(x, y)
    return flat(0, np.column_stack([x[kept], y[kept], np.zeros(kept.sum())]), UP)


def stop(at, normal, y=30.0, z=0.0, up=UP):
    wall = SimpleNamespace(normal=up, pose=np.eye(4).copy())
    wall.pose[:3, 3] = at * X + y * Y + z * UP + 9.0 * normal
    return Stop(wall, normal, float(at * normal @ X))


def test_one_stop_and_the_floor_behind_it_make_both_sides():
    near, far = dividers([floor()], [stop(NEAR, -X)])
    assert (near.touch == NOT_FELT).all()
    assert near.points[:, 0] == pytest.approx(NEAR)
    assert near.normals == pytest.approx(np.tile(-X, (len(near), 1)))
    assert far.points[:, 0] == pytest.approx(FAR, abs=1.2)
    assert far.normals == pytest.approx(np.tile(X, (len(far), 1)))
    assert far.sigma.min() > near.sigma.max()


def test_a_stroke_from_behind_tells_the_far_side():
    stops = [stop(NEAR, -X), stop(FAR, X)]
    sides = {tuple(lot.normals[0].round()): lot.points[:, 0] for lot in dividers([floor()], stops)}
    assert sides[1.0, 0.0, 0.0] == pytest.approx(FAR)
    assert sides[-1.0, 0.0, 0.0] == pytest.approx(NEAR)


@pytest.mark.parametrize("other", [stop(31.0, X, y=400.0), stop(31.0, X, z=80.0), stop(31.0, Y)])
def test_what_was_stopped_elsewhere_tells_no_far_side(other):
    (far,) = (lot for lot in dividers([floor()], [stop(NEAR, -X), other]) if lot.normals[0] @ X > 0.9)
    assert far.points[:, 0] == pytest.approx(NEAR + 0.5 * (FAR + CLEAR - NEAR), abs=0.8)
    assert far.sigma.min() > 1.0


@pytest.mark.parametrize("lay", [{"z": 6.0}, {"up": -UP}, {"y": 90.0}])
def test_a_pad_that_lay_elsewhere_was_stopped_by_something_else(lay):
    assert not list(dividers([floor()], [stop(NEAR, -X, **lay)]))


def test_a_floor_that_was_felt_in_one_corner_behind_says_nothing_of_the_whole_width():
    corner = floor(lambda x, y: (x < NEAR - CLEAR) | ((x > FAR + CLEAR) & ((y < 18.0) | (y > 50.0))))
    assert not list(dividers([corner], [stop(NEAR, -X)]))
    assert not list(dividers([floor()], [stop(NEAR, -X)], DividerConfig(wide=80.0)))


def test_a_side_that_two_strokes_tell_is_said_once():
    stops = [stop(NEAR, -X, y) for y in (20.0, 40.0)] + [stop(FAR, X)]
    lots = once(dividers([floor()], stops))
    assert sorted(tuple(lot.normals[0].round()) for lot in lots) == [(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
    (far,) = (lot for lot in lots if lot.normals[0] @ X > 0.9)
    assert far.points[:, 0] == pytest.approx(FAR)


def test_a_post_beside_which_the_floor_goes_on_is_no_divider():
    post = floor(lambda x, y: (np.abs(x - 31.5) > 3.3) | (np.abs(y - 30.0) > 8.0))
    assert not list(dividers([post], [stop(NEAR, -X)]))


def test_a_wall_behind_which_there_is_no_floor_is_no_divider():
    assert not list(dividers([floor(lambda x, y: x < NEAR - CLEAR)], [stop(NEAR, -X)]))


def test_a_side_that_is_known_is_not_inferred_again():
    y, z = (g.ravel() for g in np.meshgrid(np.arange(4.0, 56.0, 4.0), np.arange(1.0, 12.0, 3.0)))
    side = flat(1, np.column_stack([np.full(len(y), NEAR), y, z]), -X)
    (far,) = dividers([floor(), side], [stop(NEAR, -X)])
    assert far.normals[0] == pytest.approx(X)

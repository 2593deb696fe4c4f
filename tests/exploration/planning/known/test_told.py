"""A table that is told beforehand."""

import numpy as np
import pytest

from exploration.planning.known.told import Told
from exploration.planning.ways.routes import Tool
from models.csg import Cube
from models.scene import table_under
from models.solid import Solid
from primitives.evidence import NOT_FELT, Contacts
from primitives.pose import frame_along, pose

BLOCK = Solid.from_csg(Cube((60.0, 40.0, 20.0)))
TABLE = table_under(BLOCK)


@pytest.fixture
def told():
    x, y = np.meshgrid(np.arange(-150.0, 151.0, 10.0), np.arange(-150.0, 151.0, 10.0))
    top = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -10.0)])
    return Told(TABLE, top, Tool.of_size((18.0, 28.8)), -10.0)


def test_contacts_on_the_table_are_left_out_and_the_objects_are_kept(told):
    points = [[0.0, 0.0, 10.0], [50.0, 0.0, -10.0], [30.0, 0.0, -9.9]]
    normals = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    own = told.without(Contacts.of(points, normals))
    assert own.points == pytest.approx(np.array([points[0], points[2]]))


def test_a_sharp_contact_on_the_table_is_not_the_objects_and_one_above_it_is(told):
    own = told.without(Contacts.of([[50.0, 0.0, -10.1], [30.0, 0.0, 4.0]], None))
    assert own.points == pytest.approx(np.array([[30.0, 0.0, 4.0]]))


def test_a_stroke_down_a_side_is_stopped_by_the_table_and_one_across_is_not(told):
    low, high = np.array([[32.0, 0.0, -8.0]]), np.array([[0.0, 0.0, 10.0], [0.0, 20.0, 8.0]])
    assert told.stopped(low)
    assert told.stopped(np.concatenate([high, low]))  # by one corner of the array
    assert not told.stopped(high)


def test_a_pad_lies_on_the_table_where_its_skin_gave_and_not_on_a_sheet_of_a_millimeter(told):
    assert told.holds(np.array([60.0, 0.0, -10.6]))
    assert not told.holds(np.array([60.0, 0.0, -9.5]))
    assert not told.holds(np.array([0.0, 0.0, 9.5]))


def test_a_pad_has_no_room_low_on_a_side(told):
    points = np.array([[30.0, 0.0, -8.0], [30.0, 0.0, 9.5], [0.0, 0.0, 10.0]])
    normals = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 0, 1.0]])
    assert told.leaves_room(points, normals).tolist() == [False, True, True]


def test_the_resting_face_is_on_the_tables_top_and_was_not_felt(told):
    resting = told.resting(np.array([5.0, 6.0, 10.0]))
    assert (resting.points[:, 2] == -10.0).all()
    assert (resting.touch == NOT_FELT).all()


def test_taxels_that_the_table_pressed_are_of_no_face_and_those_low_on_a_side_are(told):
    assert told.beside(np.array([[50.0, 0.0, -9.3], [30.0, 0.0, -8.5]])).tolist() == [False, True]


def test_what_stopped_an_array_well_above_the_table_or_on_its_way_along_it_was_not_the_table(told):
    down, aside = frame_along(np.array([0.0, 0.0, -1.0])), frame_along(np.array([1.0, 0.0, 0.0]))
    low, high = [60.0, 0.0, -7.0], [60.0, 0.0, 3.0]
    assert told.may_have_stopped(pose(down, low), [pose(down, high)])
    assert told.may_have_stopped(pose(down, low), [])
    assert not told.may_have_stopped(pose(down, high), [pose(down, [60.0, 0.0, 20.0])])
    assert not told.may_have_stopped(pose(aside, [45.0, 0.0, 5.0]), [pose(aside, [40.0, 0.0, 4.9])])
    came = [pose(down, [x, 0.0, -7.0]) for x in np.arange(60.0, 50.0, -0.5)]
    assert not told.may_have_stopped(came[0], [*came, pose(down, [50.0, 0.0, 3.0])])  # down, and then along

"""Where flat faces go on past what their pictures show."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.land_ends import land_ends
from exploration.sensing.frame import TaxelArray
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.pose import pose, rotation_exp, transform_points

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
DOWN = rotation_exp([np.pi, 0.0, 0.0])
SIGMA = 0.03


def pictured(there, places):
    """A mosaic of pads pressed flush at (2,) places, turned by an angle each."""
    mosaic = Mosaic()
    for at, turn in places:
        where = pose(rotation_exp([0.0, 0.0, turn]) @ DOWN, [*at, -0.8])
        x, y = np.meshgrid(ARRAY.x, ARRAY.y)
        on = transform_points(where, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
        depth = 0.8 * there(on).reshape(ARRAY.shape)
        image = SimpleNamespace(array=ARRAY, depth=depth, sigma=np.full(ARRAY.shape, SIGMA), spread=1.2)
        mosaic.look(SimpleNamespace(image=image, world_from_sensor=where))
    return mosaic


def face(points):
    """A flat face in z = 0 that was felt at (n, 2) points."""
    felt = Contacts.of(np.column_stack([points, np.zeros(len(points))]), [0.0, 0.0, 1.0], 0.02, 0.01)
    return ranked_face(0, felt, MergeOptions())


@pytest.fixture
def bar():
    """A land 8 mm wide along x, felt round its middle."""
    rng = np.random.default_rng(0)
    return lambda places: (np.abs(places[:, 1]) < 4.0).astype(float), face(rng.uniform(-3.0, 3.0, (12, 2)))


def test_a_land_goes_on_at_both_ends_of_its_picture_and_nowhere_beside(bar):
    there, felt = bar
    ends = land_ends([felt], pictured(there, [((0.0, 0.0), 0.0)]))
    assert len(ends) == 2
    for end in ends:
        side = np.sign(end.point[0])
        assert end.point == pytest.approx([side * 14.4, 0.0, 0.0], abs=1.5)
        assert end.way == pytest.approx([side, 0.0, 0.0], abs=0.1)
        assert end.normal == pytest.approx([0.0, 0.0, 1.0], abs=0.01)


def test_it_goes_on_all_the_same_wherever_the_land_lies(bar):
    there, felt = bar
    mosaic = pictured(there, [((0.0, 0.0), 0.0)])
    move = pose(rotation_exp([0.4, -0.7, 1.1]), [50.0, -20.0, 80.0])
    moved = Mosaic()
    moved._images = [
        replace(image, pose=move @ image.pose, places=transform_points(move, image.places))
        for image in mosaic._images
    ]
    contacts = felt.contacts
    turned = replace(
        contacts, points=transform_points(move, contacts.points), normals=contacts.normals @ move[:3, :3].T
    )
    ends = land_ends([ranked_face(0, turned, MergeOptions())], moved)
    assert len(ends) == 2
    back = np.array([transform_points(np.linalg.inv(move), end.point[None])[0] for end in ends])
    assert np.sort(back[:, 0]) == pytest.approx([-14.4, 14.4], abs=1.5)
    assert np.abs(back[:, 1:]).max() < 1.0
    ways = np.array([move[:3, :3].T @ end.way for end in ends])
    assert (ways[:, 0] * back[:, 0] > 14.0).all()


def test_a_land_that_is_pictured_far_from_its_contacts_goes_on_there(bar):
    there, felt = bar
    ends = land_ends([felt], pictured(there, [((x, 0.0), 0.0) for x in (0.0, 21.0, 42.0)]))
    assert max(end.point[0] for end in ends) == pytest.approx(56.4, abs=1.5)


def test_it_does_not_where_the_picture_shows_its_end(bar):
    there, felt = bar
    mosaic = pictured(lambda at: there(at) * (np.abs(at[:, 0]) < 9.0), [((0.0, 0.0), 0.0)])
    assert land_ends([felt], mosaic) == []


def test_a_gap_in_the_picture_of_a_land_is_an_end_and_a_wide_face_has_none(bar):
    there, felt = bar
    beside = [((-17.5, 0.0), 0.0), ((17.5, 0.0), 0.0)]
    inner = [end for end in land_ends([felt], pictured(there, beside)) if abs(end.point[0]) < 10.0]
    assert len(inner) == 2
    strokes = [((x, y), 0.0) for x in np.arange(-60.0, 1.0, 6.0) for y in (-12.0, 12.0)]
    wide = land_ends([felt], pictured(lambda at: (at[:, 0] > -60.0).astype(float), strokes))
    assert wide == []


def test_a_face_of_few_contacts_or_none_flat_has_no_ends(bar):
    there, _ = bar
    mosaic = pictured(there, [((0.0, 0.0), 0.0)])
    few = face(np.array([[0.0, 0.0], [3.0, 1.0], [-2.0, 2.0]]))
    assert land_ends([few], mosaic) == []
    assert land_ends([], mosaic) == []

"""A picture of a flat face, from images of a pad that lay on it in several places."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import erf

from exploration.planning.known.face_pictures import face_pictures
from exploration.planning.known.mosaic import Lattice, Mosaic
from exploration.sensing.frame import TaxelArray
from primitives.cylinder import Cylinder
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.pose import pose, rotation_exp, transform_points

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
DOWN = rotation_exp([np.pi, 0.0, 0.0])
NORMAL, ORIGIN = np.array([0.0, 0.0, 1.0]), np.zeros(3)
ALONG = np.eye(3)[:, :2]
SIGMA, SPREAD = 0.03, 1.0


def image(at, there, turn=0.0, press=0.8, rng=None):
    """Of a pad pressed into a plane that is `there`, a function of places in the world that gives 0 to 1."""
    where = pose(rotation_exp([0.0, 0.0, turn]) @ DOWN, [*at, -press])
    x, y = np.meshgrid(ARRAY.x, ARRAY.y)
    places = transform_points(where, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    depth = press * there(places).reshape(ARRAY.shape)
    if rng is not None:
        depth = depth + SIGMA * rng.normal(size=depth.shape)
    seen = SimpleNamespace(array=ARRAY, depth=depth, sigma=np.full(ARRAY.shape, SIGMA), spread=1.2)
    return SimpleNamespace(image=seen, world_from_sensor=where)


def half(places):
    """The face where x < 3.3, as rubber shows its rim."""
    return 0.5 * (1.0 - erf((places[:, 0] - 3.3) / (np.sqrt(2.0) * SPREAD)))


def test_a_rim_is_where_the_share_is_one_half_however_the_pad_lay():
    rng, mosaic = np.random.default_rng(0), Mosaic()
    for k in range(12):
        mosaic.look(image(rng.uniform(-8.0, 8.0, 2), half, 0.3 * k, rng.uniform(0.4, 1.2), rng))
    lattice = Lattice.over(np.array([[-6.0, -6.0, 0.0], [8.0, 6.0, 0.0]]), ALONG, mosaic.config.step, 0.0)
    picture = mosaic.picture(ORIGIN, NORMAL, lattice)
    assert picture.known.all()
    x = lattice.origin[0] + lattice.step * np.arange(lattice.shape[0])
    crossing = [np.interp(-0.5, -row, x) for row in picture.share.T]
    assert np.abs(np.array(crossing) - 3.3).max() < 0.35
    assert abs(np.mean(crossing) - 3.3) < 0.1


def test_images_of_other_planes_and_of_pads_that_lean_tell_nothing():
    mosaic = Mosaic()
    mosaic.look(image((0.0, 0.0), half))
    lattice = Lattice.over(np.zeros((1, 3)), ALONG, mosaic.config.step, 4.0)
    assert mosaic.picture(ORIGIN, NORMAL, lattice).known.any()
    assert not mosaic.picture(ORIGIN - 4.0 * NORMAL, NORMAL, lattice).known.any()
    assert not mosaic.picture(ORIGIN, -NORMAL, lattice).known.any()
    lean = np.array([np.sin(0.1), 0.0, np.cos(0.1)])
    assert not mosaic.picture(ORIGIN, lean, lattice).known.any()


def test_where_nobody_pressed_nothing_is_known_and_dead_taxels_say_nothing():
    mosaic, seen = Mosaic(), image((0.0, 0.0), half)
    seen.image.sigma[:, :8] = np.inf
    mosaic.look(seen)
    lattice = Lattice.over(np.array([[-30.0, 0.0, 0.0], [12.0, 0.0, 0.0]]), ALONG, mosaic.config.step, 3.0)
    known = mosaic.picture(ORIGIN, NORMAL, lattice).known[:, 6]
    x = lattice.origin[0] + lattice.step * np.arange(lattice.shape[0])
    assert not known[x < -3.0].any()
    assert known[(x > 1.0) & (x < 11.0)].all()


def test_the_picture_of_a_face_lies_along_its_longer_side_and_knows_where_nobody_looked():
    way = np.array([np.cos(0.4), np.sin(0.4), 0.0])
    across = np.cross(NORMAL, way)
    points = np.array([a * way + b * across for a in (-14.0, -5.0, 5.0, 14.0) for b in (-4.0, 0.0, 4.0)])
    face = ranked_face(0, Contacts.of(points, np.tile(NORMAL, (12, 1))), MergeOptions())
    mosaic = Mosaic()
    mosaic.look(image((0.0, 0.0), lambda places: (np.abs(places @ across) < 5.0).astype(float), 0.4))
    (picture,) = face_pictures([face], mosaic)
    wide, high = (count * picture.step for count in picture.share.shape)
    assert abs(wide - (28.0 + 16.0)) < 2.0
    assert abs(high - (8.0 + 16.0)) < 2.0
    assert np.isnan(picture.share[0, 0])
    middle = picture.share[picture.share.shape[0] // 2]
    assert middle[len(middle) // 2] > 0.8
    assert middle[np.flatnonzero(~np.isnan(middle))[0]] < 0.2


@pytest.mark.parametrize(("turn", "lean"), [(0.3, 0.0), (2.0, 0.0), (5.5, 0.0), (2.0, 0.1)])
def test_a_cylinder_is_seen_along_the_line_on_which_the_pad_lies_and_nowhere_else(turn, lean):
    """At its height and in its sector, up to a rim at 3.3 mm; not by a pad that leans along it."""
    shape = Cylinder([0.0, 0.0, 5.0], NORMAL, 20.0)
    out = np.array([np.cos(turn), np.sin(turn), 0.0])
    turned = np.column_stack([NORMAL, np.cross(-out, NORMAL), -out]) @ rotation_exp([0.0, lean, 0.0])
    where = pose(turned, 19.2 * out)
    x, y = np.meshgrid(ARRAY.x, ARRAY.y)
    places = transform_points(where, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    depth = np.maximum(20.0 - np.hypot(places[:, 0], places[:, 1]), 0.0) * half(places[:, [2, 0, 1]])
    seen = SimpleNamespace(
        array=ARRAY, depth=depth.reshape(ARRAY.shape), sigma=np.full(ARRAY.shape, SIGMA), spread=1.2
    )
    mosaic = Mosaic()
    mosaic.look(SimpleNamespace(image=seen, world_from_sensor=where))
    band = mosaic.band(shape, -12.0, 4.0)
    assert np.allclose(band.heights, np.arange(-12.0, 4.1, mosaic.config.step))
    if lean:
        assert not band.known.any()
        return
    way = shape.frame.T @ out
    sector = int(np.arctan2(way[1], way[0]) % (2.0 * np.pi) / (2.0 * np.pi) * 12)
    assert band.known.any(axis=1).nonzero()[0].tolist() == [sector]
    assert np.interp(-0.5, -band.share[sector], band.heights) + 5.0 == pytest.approx(3.3, abs=0.3)

"""Narrow holes in the picture of a flat face."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.pictured_pits import pictured_pits
from exploration.sensing.frame import TaxelArray
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.pose import pose, rotation_exp, transform_points

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
DOWN, UP = rotation_exp([np.pi, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
SIGMA, SPREAD, FINE = 0.02, 1.2, 0.1
WIDE, HIGH = 30.0, 20.0  # [mm] of the face, which begins at the origin


def face_with(missing, seed=0):
    """A flat face as pads showed it, 24 of them, less where `missing` says so of (n, m) x and y."""
    x, y = np.meshgrid(*(np.arange(-15.0, end + 15.0, FINE) for end in (WIDE, HIGH)), indexing="ij")
    there = (x > 0.0) & (x < WIDE) & (y > 0.0) & (y < HIGH) & ~missing(x, y)
    share = gaussian_filter(there.astype(float), SPREAD / FINE)
    rng, mosaic = np.random.default_rng(seed), Mosaic()
    for k in range(24):
        at = rng.uniform((4.0, 3.0), (WIDE - 4.0, HIGH - 3.0))
        where = pose(rotation_exp([0.0, 0.0, 0.4 * k]) @ DOWN, [*at, -0.6])
        u, v = np.meshgrid(ARRAY.x, ARRAY.y)
        places = transform_points(where, np.column_stack([u.ravel(), v.ravel(), np.zeros(u.size)]))
        cell = np.clip(np.round((places[:, :2] + 15.0) / FINE).astype(int), 0, np.array(share.shape) - 1)
        depth = 0.6 * share[tuple(cell.T)].reshape(ARRAY.shape) + SIGMA * rng.normal(size=ARRAY.shape)
        seen = SimpleNamespace(array=ARRAY, depth=depth, sigma=np.full(ARRAY.shape, SIGMA), spread=SPREAD)
        mosaic.look(SimpleNamespace(image=seen, world_from_sensor=where))
    a, b = np.meshgrid(np.arange(1.0, WIDE, 2.0), np.arange(1.0, HIGH, 2.0))
    flat = ~missing(a, b)
    points = np.column_stack([a[flat], b[flat], np.zeros(flat.sum())])
    contacts = Contacts.of(points, np.tile(UP, (len(points), 1)))
    face = ranked_face(3, contacts, MergeOptions())
    felt = SurfaceMap()
    felt.add(contacts.points, contacts.normals)
    return KnownFace.of(face, face.fit, felt, np.empty((0, 3)), 5.0), mosaic


def discs(*holes):
    return lambda x, y: sum((np.hypot(x - a, y - b) < r for a, b, r in holes), np.zeros_like(x, dtype=bool))


@pytest.mark.parametrize("radius", [1.5, 2.0, 3.0, 4.5])
def test_holes_are_where_they_are_and_about_as_wide_close_beside_an_edge_too(radius):
    own, mosaic = face_with(discs((8.0, 10.0, radius), (21.0, radius + 2.0, radius)))
    rims = sorted(pictured_pits([own], mosaic), key=lambda rim: rim.center[0])
    assert [rim.face for rim in rims] == [3, 3]
    for rim, at in zip(rims, [(8.0, 10.0, 0.0), (21.0, radius + 2.0, 0.0)], strict=True):
        assert np.abs(rim.center - at).max() < 0.6
        assert abs(rim.radius - radius) < 2.0 * rim.sigma
        np.testing.assert_allclose(rim.axis, UP, atol=1e-6)


def test_a_face_without_holes_has_none_nor_is_a_notch_or_a_slot_one():
    assert pictured_pits([face_with(discs())[0]], face_with(discs())[1]) == []
    notch = face_with(discs((15.0, 0.0, 3.0)))
    assert pictured_pits([notch[0]], notch[1]) == []
    slot = face_with(lambda x, y: (np.abs(x - 15.0) < 7.0) & (np.abs(y - 10.0) < 1.5))
    assert pictured_pits([slot[0]], slot[1]) == []


def test_nothing_is_told_of_what_nobody_lay_on():
    own, _ = face_with(discs((8.0, 10.0, 2.0)))
    assert pictured_pits([own], Mosaic()) == []

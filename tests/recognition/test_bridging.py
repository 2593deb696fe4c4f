"""Where what joins the pieces of a draft may be."""

import numpy as np

from models.csg import Cube, Cylinder
from models.solid import Solid
from recognition.bridging import bridging


def test_between_the_rim_and_the_hub_of_a_wheel_are_the_places_of_its_spokes():
    wheel = (Cylinder(50.0, 14.0) - Cylinder(42.0, 99.0)) | Cylinder(12.0, 30.0)
    found = bridging(Solid.from_csg(wheel))
    away = np.linalg.norm(found.points[:, :2], axis=1)
    assert away.min() > 12.0
    assert away.max() < 42.0
    assert np.abs(found.points[:, 2]).max() < 1.0
    assert np.abs(found.normals[:, 2]).min() > 0.99
    assert {*np.sign(found.normals[:, 2])} == {1.0, -1.0}
    turns = np.sort(np.arctan2(found.points[:, 1], found.points[:, 0]))
    assert np.diff(turns).max() < 0.3  # all round
    first = found.points[:10]
    assert np.linalg.norm(first[:, None] - first[None], axis=2).max() > 40.0  # spread, whoever stops early


def test_what_joins_two_flanges_is_come_at_from_all_round_and_never_through_them():
    flanges = Cylinder(30.0, 6.0).at(0.0, 0.0, -20.0) | Cylinder(30.0, 6.0).at(0.0, 0.0, 20.0)
    found = bridging(Solid.from_csg(flanges))
    assert np.abs(found.points[:, 2]).max() < 17.0
    assert np.abs(found.normals[:, 2]).max() < 0.1
    axis = found.normals[0]
    along = found.normals @ axis
    assert {*np.round(along)} == {-1.0, 0.0, 1.0}
    assert np.abs((found.points * found.normals).sum(axis=1)).max() < 2.0  # on planes through its middle


def test_a_rim_as_deep_as_wide_is_come_at_along_its_axis():
    drum = (Cylinder(40.0, 80.0) - Cylinder(32.0, 99.0)) | Cylinder(10.0, 80.0)
    assert np.abs(bridging(Solid.from_csg(drum)).normals[:, 2]).min() > 0.99


def test_one_piece_and_pieces_far_apart_ask_for_nothing():
    assert len(bridging(Solid.from_csg(Cube((40.0, 30.0, 20.0)))).points) == 0
    far = Cube((20.0, 20.0, 20.0)).at(-60.0, 0.0, 0.0) | Cube((20.0, 20.0, 20.0)).at(60.0, 0.0, 0.0)
    assert len(bridging(Solid.from_csg(far)).points) == 0

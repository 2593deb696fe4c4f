"""Outlines are put along the sides of a body that they nearly run along, and keep their shape else."""

import numpy as np
import pytest

from models.meshing.flat_regions import Region
from recognition.assembly.squared import sides_of, squared

BLOCK = Region.of([np.array([[0.0, 0.0], [60.0, 0.0], [60.0, 40.0], [0.0, 40.0]])])


def turned(corners, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(corners) @ np.array([[c, s], [-s, c]])


def corners_of(region):
    (rim,) = region.rims
    return rim[np.lexsort(np.round(rim, 3).T)]


@pytest.mark.parametrize("angle", [0.0, 0.4, -2.0])
def test_a_slot_that_leans_and_is_rounded_gets_square(angle):
    sides = sides_of(Region.of([turned(rim, angle) for rim in BLOCK.rims]))
    seen = np.array(
        [
            [20.1, 10.9],
            [21.0, 10.05],
            [39.2, 9.9],
            [40.1, 10.6],
            [39.9, 25.2],
            [39.0, 26.0],
            [20.9, 25.9],
            [19.9, 25.1],
        ]
    )
    made = squared(Region.of([turned(seen, angle)]), sides)
    square = np.array([[20.0, 10.0], [40.0, 10.0], [40.0, 26.0], [20.0, 26.0]])
    off = np.linalg.norm(corners_of(made)[:, None] - turned(square, angle)[None], axis=2)
    assert off.shape == (4, 4)
    assert off.min(axis=0).max() < 0.2
    edges = np.roll(made.rims[0], -1, axis=0) - made.rims[0]
    across = turned(np.eye(2), angle)
    assert np.abs(edges @ across.T).min(axis=1).max() < 1e-6


def test_an_edge_near_a_side_lies_on_it_and_one_farther_does_not():
    sides = sides_of(BLOCK)
    part = Region.of([np.array([[10.0, 0.2], [30.0, 0.1], [30.1, 8.0], [10.1, 8.1]])])
    assert corners_of(squared(part, sides))[:, 1].min() == pytest.approx(0.0, abs=1e-6)
    part = Region.of([np.array([[10.0, 1.2], [30.0, 1.1], [30.1, 8.0], [10.1, 8.1]])])
    assert corners_of(squared(part, sides))[:, 1].min() == pytest.approx(1.15, abs=0.02)


@pytest.mark.parametrize("radius", [8.0, 25.0, 40.0])
def test_what_is_round_stays(radius):
    disk = Region.disks(np.array([[30.0, 20.0]]), radius, 64)
    made = squared(disk, sides_of(BLOCK))
    assert made.rims[0].shape == disk.rims[0].shape
    assert made.area == pytest.approx(disk.area, rel=1e-9)


def test_an_edge_in_two_parts_lies_on_one_line():
    part = Region.of([np.array([[10.0, 10.0], [20.0, 10.1], [30.0, 10.15], [30.0, 18.0], [10.0, 18.0]])])
    heights = corners_of(squared(part, sides_of(BLOCK)))[:, 1]
    assert len(heights) == 4
    assert np.ptp(np.sort(heights)[:2]) < 1e-6


def test_nothing_vanishes():
    film = Region.of([np.array([[10.0, 0.0], [30.0, 0.0], [30.0, 0.2], [10.0, 0.2]])])
    assert squared(film, sides_of(BLOCK)).area == pytest.approx(film.area)
    assert not squared(Region(), sides_of(BLOCK))


def test_what_is_slanted_stays_and_holes_do():
    sides = sides_of(BLOCK)
    disk = Region.disks(np.array([[30.0, 20.0]]), 8.0, 64)
    slanted = Region.of([turned([[0.0, 0.0], [20.0, 0.0], [20.0, 8.0], [0.0, 8.0]], 0.3)])
    assert squared(slanted, sides).area == pytest.approx(slanted.area)
    ring = Region.of([np.array([[5.0, 5.0], [55.0, 5.2], [55.0, 35.0], [5.0, 35.0]])]) - disk
    made = squared(ring, sides)
    assert len(made.rims) == 2
    assert made.area == pytest.approx(ring.area, rel=0.01)
    assert squared(ring, []) is ring


def test_a_side_that_is_bent_once_is_one_and_its_corners_are_square():
    pocket = [[10.0, 10.1], [17.0, 9.9], [17.2, 21.8], [12.0, 22.4], [10.0, 22.2]]
    corners = corners_of(squared(Region.of([np.array(pocket)]), sides_of(BLOCK)))
    assert len(corners) == 4
    assert np.allclose(corners, [[10.0, 10.0], [17.1, 10.0], [10.0, 22.1], [17.1, 22.1]], atol=0.25)


def test_a_short_side_may_lean_by_what_its_rounded_corners_make_of_it():
    pocket = [[10.0, 10.0], [17.0, 10.0], [17.0, 22.3], [11.5, 21.65], [10.0, 21.65]]
    heights = corners_of(squared(Region.of([np.array(pocket)]), sides_of(BLOCK)))[:, 1]
    assert np.allclose(heights[2:], heights[2])
    slanted = [[10.0, 10.0], [17.0, 10.0], [17.0, 22.3], [10.0, 21.2]]
    heights = corners_of(squared(Region.of([np.array(slanted)]), sides_of(BLOCK)))[:, 1]
    assert heights[-1] - heights[-2] > 1.0

"""Which cells are solid, where contacts say little of some."""

from dataclasses import replace

import numpy as np
import pytest

from recognition.assembly.arrangement import Arrangement
from recognition.assembly.labels import _densities, solid_cells


def parted(solid, swept, share):
    """A cell between two that are free, with contacts that say solid, and places that were gone through."""
    none = np.zeros(3)
    return Arrangement(
        outside=np.array([[True, False], [False, False], [False, True]]),
        volume=np.array([1e4, 1e4, 1e4]),
        beyond=none,
        solid_votes=np.array([0.0, solid, 0.0]),
        free_votes=np.array([20.0, 0.0, 20.0]),
        swept_votes=np.array([0.0, swept, 0.0]),
        swept_share=np.array([0.0, share, 0.0]),
        pairs=np.array([[1, 0], [1, 2]]),
        area=np.array([500.0, 500.0]),
        touched=np.array([20.0, 20.0]),
        facing=np.array([[20.0, 20.0], [0.0, 0.0]]),
        inferred=np.zeros(2, dtype=bool),
        stops=np.zeros(2, dtype=bool),
    )


def test_a_corner_that_nobody_felt_is_no_notch_whose_sides_would_look_the_wrong_way():
    """A floor and a wall of few contacts: between their undersides and their outer sides lies a cell untold."""
    corner = replace(
        parted(0.0, 0.0, 0.0),
        outside=np.concatenate(
            [np.zeros((1, 4), dtype=bool), np.eye(4, dtype=bool)]
        ),  # corner, and beyond each
        pairs=np.array([[0, 1], [0, 2], [0, 3], [0, 4], [3, 1], [4, 2]]),
        area=np.array([200.0, 200.0, 200.0, 200.0, 2e3, 2e3]),
        volume=np.full(5, 1e3),
        solid_votes=np.array([0.0, 0.0, 0.0, 60.0, 60.0]),
        free_votes=np.array([0.0, 60.0, 60.0, 0.0, 0.0]),
        touched=np.array([60.0, 60.0, 6.0, 6.0]),
        facing=np.array([[60.0, 60.0, 6.0, 6.0], np.zeros(4)]),
        inferred=np.array([False, False, True, True]),
        stops=np.zeros(4, dtype=bool),
        **{name: np.zeros(5) for name in ("beyond", "swept_votes", "swept_share")},
    )
    assert solid_cells(corner).tolist() == [True, False, False, True, True]
    both = replace(corner, facing=corner.facing + corner.facing[::-1])
    assert solid_cells(both).tolist() == [False, False, False, True, True]


def test_no_more_contacts_are_missed_on_a_wall_that_is_inferred():
    """Of which 100 mm^2 lie between cells that contacts tell of, and 860 do not."""
    whole = parted(40.0, 0.0, 0.0)
    wall = replace(whole, area=np.array([100.0, 860.0]), pairs=np.array([[1, 0], [1, 0]]))
    beside, mean = np.array([True, False]), 0.15
    felt = _densities(wall, beside, mean, 1.5)
    nobody = _densities(replace(wall, inferred=np.array([True, False])), beside, mean, 1.5)
    assert felt.tolist() == pytest.approx([mean, mean])
    assert nobody.max() < 0.25 * mean
    assert nobody.min() > 1.0 * 20.0 / 960.0


def test_a_cell_that_a_missing_surface_parts_is_what_its_greater_part_is():
    assert solid_cells(parted(40.0, 0.0, 0.0)).tolist() == [False, True, False]
    assert solid_cells(parted(40.0, 400.0, 0.2)).tolist() == [False, True, False]
    assert not solid_cells(parted(40.0, 400.0, 0.9)).any()
    assert not solid_cells(parted(2.0, 400.0, 0.2)).any()  # strays


def test_a_body_goes_on_past_a_plane_that_is_no_face_s_where_its_own_surface_may():
    """A cone was felt up to a plane, of 200 mm^2; beyond it lie 300 mm^2 of its surface that nobody felt."""
    cone = replace(
        parted(60.0, 0.0, 0.0),
        outside=np.array(
            [[False, False], [True, False], [True, True], [False, True]]
        ),  # of the plane, the cone
        pairs=np.array([[0, 1], [1, 2], [0, 3]]),
        area=np.array([200.0, 300.0, 1000.0]),
        volume=np.full(4, 1e3),
        solid_votes=np.array([60.0, 0.0, 0.0, 0.0]),
        free_votes=np.array([0.0, 0.0, 5.0, 60.0]),
        touched=np.array([0.0, 60.0]),
        facing=np.array([[0.0, 60.0], [0.0, 0.0]]),
        **{name: np.zeros(4) for name in ("beyond", "swept_votes", "swept_share")},
    )
    assert solid_cells(cone).tolist() == [True, False, False, False]
    assert solid_cells(replace(cone, stops=np.array([True, False]))).tolist() == [True, True, False, False]

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.leaves.polygons import cleaned, crosses_itself, polygon_distance, triangulated
from primitives.outlines import signed_area

SQUARE = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
COMB = np.array(
    [[0.0, 0], [9, 0], [9, 6], [7, 6], [7, 1], [5, 1], [5, 6], [3, 6], [3, 1], [1, 1], [1, 6], [0, 6]]
)
stars = st.lists(st.floats(1, 20), min_size=3, max_size=14).map(
    lambda radii: np.stack(
        [
            np.array(radii) * np.cos(2 * np.pi / len(radii) * np.arange(len(radii))),
            np.array(radii) * np.sin(2 * np.pi / len(radii) * np.arange(len(radii))),
        ],
        axis=1,
    )
)


@given(stars)
def test_triangles_of_a_star_cover_its_area_and_all_turn_left(outline: np.ndarray) -> None:
    triangles = triangulated(outline)
    areas = [signed_area(outline[list(t)]) for t in triangles]
    assert len(triangles) == len(outline) - 2
    assert min(areas) > -1e-9
    assert sum(areas) == pytest.approx(signed_area(outline), rel=1e-9)


def test_triangles_of_a_comb_stay_inside_it() -> None:
    middles = COMB[triangulated(COMB)].mean(axis=1)
    assert (polygon_distance(middles, COMB) < 0).all()


def test_cleaning_drops_straight_and_repeated_corners_and_turns_left() -> None:
    messy = np.array([[0.0, 4], [0, 4], [2, 4], [4, 4], [4, 0], [0, 0], [0, 2]])
    assert signed_area(messy) < 0
    assert sorted(cleaned(messy).tolist()) == sorted(SQUARE.tolist())
    assert signed_area(cleaned(messy)) == pytest.approx(16)


def test_a_spike_of_no_width_is_cleaned_away() -> None:
    spiked = np.array([[0.0, 0], [4, 0], [4, 2], [9, 2], [4, 2], [4, 4], [0, 4]])
    assert len(cleaned(spiked)) == 4


@pytest.mark.parametrize(
    ("outline", "crossing"),
    [
        (SQUARE, False),
        (COMB, False),
        (SQUARE[[0, 2, 1, 3]], True),
        (np.array([[0.0, 0], [4, 0], [4, 4], [2, 0], [0, 4]]), True),  # a corner on another side
    ],
)
def test_outlines_that_cross_or_touch_themselves_are_found(outline: np.ndarray, crossing: bool) -> None:
    assert crosses_itself(outline) == crossing


def test_distance_agrees_with_finely_sampled_sides() -> None:
    points = np.random.default_rng(0).uniform(-3, 12, (200, 2))
    share = np.linspace(0, 1, 401)[:, None]
    rim = np.concatenate([a + share * (b - a) for a, b in zip(COMB, np.roll(COMB, -1, axis=0), strict=True)])
    brute = np.linalg.norm(points[:, None] - rim[None], axis=2).min(axis=1)
    np.testing.assert_allclose(np.abs(polygon_distance(points, COMB)), brute, atol=2e-2)


def test_inside_agrees_with_winding_numbers() -> None:
    points = np.random.default_rng(1).uniform(-3, 12, (400, 2))
    away = COMB[None] - points[:, None]
    angle = np.arctan2(away[..., 1], away[..., 0])
    turns = np.angle(np.exp(1j * (np.roll(angle, -1, axis=1) - angle))).sum(axis=1) / (2 * np.pi)
    np.testing.assert_array_equal(polygon_distance(points, COMB) < 0, turns > 0.5)

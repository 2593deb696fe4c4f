import numpy as np
import pytest

from exploration.sensing.lines.edge_rounding import half_height, pressed, rounding_of, spread
from exploration.sensing.lines.rounding import rounded_edge_shift
from exploration.sensing.response import rubber

RESPONSE = rubber(1.2, (1.8, 1.8))
WIDTH = RESPONSE.width([0.0, 1.0])
PLACES = np.arange(-5.0, 8.0, 0.3)


@pytest.mark.parametrize("dihedral", [60.0, 90.0, 120.0])
@pytest.mark.parametrize("radius", [1.0, 2.0, 5.0])
def test_the_rounding_of_a_profile_is_found_wherever_the_edge_was_fitted(radius, dihedral):
    angle = np.radians(dihedral)
    place = PLACES + half_height(radius, 0.5, np.pi - angle) + 0.2
    shown = spread(place, radius, 0.5, 0.002, WIDTH, RESPONSE, angle)
    noisy = shown + 3e-4 * np.random.default_rng(5).standard_normal(len(PLACES))
    found = rounding_of(PLACES, noisy, np.full(len(PLACES), 3e-4), WIDTH, RESPONSE, angle, 0.0)
    assert found.radius == pytest.approx(radius, abs=0.4)
    assert 0.0 < found.sigma < 0.5
    assert found.misfit < 2.0


def test_a_sharp_edge_has_hardly_a_rounding():
    shown = spread(PLACES, 0.0, 0.5, 0.0, WIDTH, RESPONSE, 0.5 * np.pi)
    noisy = shown + 1e-4 * np.random.default_rng(1).standard_normal(len(PLACES))
    found = rounding_of(PLACES, noisy, np.full(len(PLACES), 1e-4), WIDTH, RESPONSE, 0.5 * np.pi, 0.0)
    assert found.radius < 0.4


@pytest.mark.parametrize("wide", [8.5, 10.0, 12.0])
@pytest.mark.parametrize("radius", [0.0, 2.0])
def test_where_a_narrow_face_ends_opposite_is_no_part_of_the_rounding(radius, wide):
    shown = spread(PLACES, radius, 0.5, 0.0, WIDTH, RESPONSE, 0.5 * np.pi)
    shown = shown - 0.5 * RESPONSE.edge(PLACES - wide, WIDTH)
    noisy = shown + 3e-4 * np.random.default_rng(2).standard_normal(len(PLACES))
    found = rounding_of(PLACES, noisy, np.full(len(PLACES), 3e-4), WIDTH, RESPONSE, 0.5 * np.pi, 0.0)
    assert found
    assert found.radius == pytest.approx(radius, abs=0.7)


def test_what_no_arc_explains_is_no_rounding():
    shown = spread(PLACES, 0.0, 0.5, 0.0, WIDTH, RESPONSE, 0.5 * np.pi) * (1.0 + 0.03 * np.sin(3.0 * PLACES))
    assert not rounding_of(PLACES, shown, np.full(len(PLACES), 3e-4), WIDTH, RESPONSE, 0.5 * np.pi, 0.0)


def test_a_response_that_is_less_well_known_leaves_the_rounding_less_well_known():
    shown = spread(PLACES, 1.0, 0.5, 0.0, WIDTH, RESPONSE, 0.5 * np.pi)
    sure, doubtful = (
        rounding_of(PLACES, shown, np.full(len(PLACES), 1e-3), WIDTH, RESPONSE, 0.5 * np.pi, known).sigma
        for known in (0.0, 0.05)
    )
    assert doubtful > 2.0 * sure


@pytest.mark.parametrize("radius", [0.3, 1.0, 4.0])
def test_a_rounding_takes_the_volume_that_its_circle_leaves_out(radius):
    s = np.linspace(0.0, 8.0, 200_001)
    missing = np.trapezoid(0.5 - pressed(s, radius, 0.5, 0.0, 0.5 * np.pi), s)
    assert missing == pytest.approx(0.5 * rounded_edge_shift(radius, 0.5), rel=1e-3)


def test_two_blunt_faces_fall_away_behind_the_rounding():
    s, turn = np.array([-1.0, -0.5, 3.0]), np.radians(30.0)
    assert pressed(s, 0.0, 0.5, 0.0, turn) == pytest.approx(
        np.maximum(0.0, 0.5 + np.minimum(s, 0) * np.tan(turn))
    )

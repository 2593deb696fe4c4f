"""The middle and the width of what is touched, bent or straight."""

import numpy as np
import pytest

from exploration.sensing.frame import TaxelArray
from exploration.sensing.surfaces.midline import Midline

ARRAY = TaxelArray("fine", 60, 90, (0.4, 0.4))


def strip(radius: float, width: float):
    """(rows, columns) taxels within a strip about a circle that passes through the pad's center."""
    x, y = np.meshgrid(ARRAY.x, ARRAY.y)
    return np.abs(np.hypot(x, y - radius) - radius) < 0.5 * width


@pytest.mark.parametrize("width", [3.0, 5.0])
@pytest.mark.parametrize("radius", [40.0, 60.0, 1e5])
def test_a_bent_strip_is_as_wide_as_a_straight_one(radius, width):
    middle = Midline.of(strip(radius, width), ARRAY)
    assert middle.width == pytest.approx(width, rel=0.06)


def test_places_come_to_lie_on_the_strip():
    radius, width = 40.0, 4.0
    middle = Midline.of(strip(radius, width), ARRAY)
    at = middle.bent(middle.center + np.array([[-14.0, 0.0], [0.0, 1.5], [9.0, -1.5]]))
    assert np.abs(np.hypot(at[:, 0], at[:, 1] - radius) - radius).max() < 0.5 * width


def test_a_straight_strip_leaves_places_as_they_are():
    places = np.array([[-14.0, 1.0], [0.0, 9.0], [9.0, -5.0]])
    assert Midline.of(strip(1e6, 4.0), ARRAY).bent(places) == pytest.approx(places, abs=0.01)


@pytest.mark.parametrize("columns", [[4], [4, 5]])
def test_a_taxel_or_two_are_enough(columns):
    mask = np.zeros(ARRAY.shape, dtype=bool)
    mask[3, columns] = True
    assert Midline.of(mask, ARRAY).width == pytest.approx(0.0, abs=1e-9)

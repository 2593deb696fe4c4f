import numpy as np
import pytest

from exploration.sensing.lines.outline import UNMISTAKABLE, find_outline
from exploration.sensing.lines.outline_evidence import log_weight
from exploration.sensing.lines.region import ONE, Region
from exploration.sensing.lines.region_fit import RegionFit


def wall(frames, width):
    first, second = frames.half(0.4, -width / 2), frames.half(0.4, width / 2, -1)
    return lambda x, y: 0.5 * first(x, y) * second(x, y)


def counts(frames, field, config=None, count=12):
    rng = np.random.default_rng(5)
    found = [find_outline(frames(field, rng), config=config) for _ in range(count)]
    return [len(outline.lines) for outline in found], sum(len(outline.arcs) for outline in found)


def test_a_wall_of_ten_millimeters_is_told_from_every_cylinder(frames):
    lines, arcs = counts(frames, wall(frames, 10.0), UNMISTAKABLE)
    assert lines.count(2) >= 11
    assert arcs == 0


@pytest.mark.parametrize("width", [4.5, 6.0])
def test_a_wall_as_narrow_as_the_blur_is_given_only_to_who_takes_a_cylinder_for_one(frames, width):
    assert counts(frames, wall(frames, width))[0].count(2) >= 11
    assert sum(counts(frames, wall(frames, width), UNMISTAKABLE)[0]) == 0


@pytest.mark.parametrize(("radius", "lines"), [(8.0, 2), (15.0, 2), (45.0, 0), (90.0, 0)])
def test_a_cylinder_has_two_lines_only_where_it_is_narrower_than_the_pad(frames, radius, lines):
    found = counts(frames, frames.cylinder(radius, 0.7))[0]
    assert found.count(lines) >= (11 if lines else 12)
    assert sum(counts(frames, frames.cylinder(radius, 0.7), UNMISTAKABLE)[0]) == 0


def fitted(covariance):
    """A line and a circle with (8, 8) covariance."""
    region = Region((1.0,), ONE[0], (-1.0,))
    parameters = np.array([0.5, 0.0, 0.0, 0.3, 2.0, 1.0, -1.0, 4.0])
    return RegionFit(region, parameters, covariance, 100.0, 150, True, 3.0)


def test_what_a_frame_leaves_open_is_counted_as_a_volume():
    rng, size = np.random.default_rng(6), 30.0
    root = 0.02 * rng.standard_normal((8, 8))
    tight = 1e-4 * np.eye(8) + root @ root.T
    tighter = log_weight(fitted(tight / 4.0), size) - log_weight(fitted(tight), size)
    assert tighter == pytest.approx(-8.0 * np.log(2.0), abs=0.05)  # each unknown half as wide
    wide = np.diag([1e8, 1e-2, 1e-2, *([1e8] * 5)])  # the fit itself expects something of the slopes
    twice = np.diag([2e8, 1e-2, 1e-2, *([2e8] * 5)])
    open_ = log_weight(fitted(wide), size)
    assert log_weight(fitted(twice), size) == pytest.approx(open_, abs=1e-2)  # no more than before touch
    assert log_weight(fitted(-tight), size) == -np.inf

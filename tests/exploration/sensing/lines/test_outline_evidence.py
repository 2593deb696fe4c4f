import numpy as np
import pytest

from exploration.sensing.lines.outline import UNMISTAKABLE, find_outline


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

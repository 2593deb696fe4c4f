import numpy as np
import pytest

from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.outline import find_outline
from exploration.sensing.lines.rounding import cylinder_width, rounded_edge_shift

PRESS = 0.5


def rounded(angle, offset, radius):
    """An edge whose side face is at a line, rounded into the top face."""

    def field(x, y):
        t = y * np.cos(angle) - x * np.sin(angle) - offset
        u = np.clip(radius - t, 0.0, radius)
        return np.where(t > 0.0, np.maximum(0.0, PRESS - radius + np.sqrt(radius**2 - u**2)), 0.0)

    return field


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0, 3.0, 5.0])
def test_a_rounded_edge_is_found_as_far_inside_as_is_stated(frames, radius):
    rng = np.random.default_rng(1)
    off = []
    for _ in range(20):
        angle, offset = rng.uniform(0.0, np.pi), rng.uniform(-3.0, 3.0)
        lines = find_lines(frames(rounded(angle, offset, radius), rng))
        off += [
            line.material_side * line.offset - offset * np.sign(line.inward @ _normal(angle))
            for line in lines
        ]
    assert 17 <= len(off) <= 20
    assert np.mean(off) == pytest.approx(rounded_edge_shift(radius, PRESS), abs=0.12)


@pytest.mark.parametrize("radius", [5.0, 8.0, 12.0])
def test_a_narrow_cylinder_is_found_as_two_lines_about_its_axis(frames, radius):
    rng = np.random.default_rng(2)
    width, middle, missed = [], [], 0
    for _ in range(20):
        angle, offset = rng.uniform(0.0, np.pi), rng.uniform(-2.0, 2.0)
        lines = find_outline(frames(frames.cylinder(radius, angle, offset), rng)).lines
        if len(lines) != 2:
            missed += 1
            continue
        low, high = (line.offset * np.sign(line.normal @ _normal(angle)) for line in lines)
        width.append(abs(high - low))
        middle.append((low + high) / 2 - offset)
    assert missed <= 4
    assert np.mean(width) == pytest.approx(cylinder_width(radius, PRESS), rel=0.07)
    assert np.mean(middle) == pytest.approx(0.0, abs=0.2)


def _normal(angle):
    return np.array([-np.sin(angle), np.cos(angle)])

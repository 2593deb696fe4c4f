import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.csg import Cube, Cylinder, Sphere, Torus
from models.solid import Solid
from primitives.outlines import simplified, traced
from recognition.report.drawing import COLORS, DrawingConfig, drawing_svg


def _shoelace(loop: np.ndarray) -> float:
    x, y = loop.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 2**32 - 1))
def test_the_rims_of_a_mask_hold_its_area_holes_left_out(rows: int, columns: int, seed: int) -> None:
    mask = np.random.default_rng(seed).random((rows, columns)) < 0.6
    assert sum(map(_shoelace, traced(mask))) == mask.sum()


def test_a_mask_with_a_hole_has_two_rims() -> None:
    mask = np.ones((5, 6), dtype=bool)
    mask[2, 2:4] = False
    assert sorted(map(_shoelace, traced(mask))) == [-2, 30]


def test_pixels_that_touch_at_a_corner_are_rimmed_apart() -> None:
    assert sorted(map(_shoelace, traced(np.eye(2, dtype=bool)))) == [1, 1]


def test_points_left_out_of_a_line_lie_near_it() -> None:
    t = np.linspace(0, 3, 400)
    line = np.stack([20 * t, 9 * np.sin(4 * t)], axis=1)
    kept = simplified(line, 0.2)
    assert len(kept) < 60
    np.testing.assert_array_equal(kept[[0, -1]], line[[0, -1]])
    between = np.interp(line[:, 0], kept[:, 0], kept[:, 1])
    assert np.abs(between - line[:, 1]).max() < 0.5


def _lines(svg: str) -> str:
    return re.findall(r'<path d="([^"]*)" fill="none"', svg)[0]


def test_three_sides_of_a_cube_are_seen_in_three_lights_and_nine_of_its_edges() -> None:
    svg = drawing_svg(Solid.from_csg(Cube((40, 40, 40))))
    assert len(set(re.findall(r'<path d="[^"]*" fill="(#\w+)" stroke', svg))) == 3
    assert _lines(svg).count("M") == 9


def test_a_ball_is_drawn_as_one_closed_outline_of_its_radius() -> None:
    config = DrawingConfig()
    svg = drawing_svg(Solid.from_csg(Sphere(30), 0.01), config)
    path = _lines(svg)
    assert path.count("M") == 1
    start, moves = path[1:].split("l")
    steps = np.array(re.findall(r"[+-]\d+", moves), dtype=float).reshape(-1, 2)
    points = (
        np.cumsum(np.vstack([np.array(start.split(), dtype=float), steps]), axis=0) / 10
    ) - config.size / 2
    radius = np.hypot(*points.T)
    np.testing.assert_allclose(radius, config.size / 2 - config.margin, atol=0.5)
    turn = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    assert abs(turn[-1] - turn[0]) == pytest.approx(2 * np.pi, abs=0.1)


def test_what_lies_behind_is_not_drawn() -> None:
    config = DrawingConfig()
    back = np.array([np.cos(config.azimuth), np.sin(config.azimuth), 0.5]) * -30
    wall = Cube((60, 60, 60))
    hidden = wall | Cube((8, 8, 8)).at(*(back * 0.9))
    assert _lines(drawing_svg(Solid.from_csg(hidden))).count("M") >= 9
    assert len(_lines(drawing_svg(Solid.from_csg(wall - Cylinder(4, 30).at(0, 0, -30))))) == len(
        _lines(drawing_svg(Solid.from_csg(wall)))
    )


def test_every_shape_has_the_color_of_the_pages_light_theme() -> None:
    from importlib.resources import files

    css = (files("recognition.report") / "style.css").read_text(encoding="utf-8")
    for shape, color in COLORS.items():
        assert re.search(rf"--{shape}: (#\w+)", css)[1] == color


def test_a_ring_shows_its_hole() -> None:
    svg = drawing_svg(Solid.from_csg(Torus(30, 8), 0.02))
    assert _lines(svg).count("M") >= 2

"""Hulls of circles and polygons, and of what stands upright, against the hull of many points on them."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from models.formats import openscad
from models.solid import Solid
from primitives.errors import PalpateError

TURN = 2.0 * np.pi * np.arange(720) / 720


def solid(text, tmp_path):
    path = tmp_path / "hull.scad"
    path.write_text(text)
    return Solid.from_csg(openscad.read(path).tree, 1e-3)


def circle(x, y, r):
    return np.column_stack([x + r * np.cos(TURN), y + r * np.sin(TURN)])


@pytest.mark.parametrize("seed", range(8))
def test_circles_and_polygons_of_any_size(seed, tmp_path):
    rng = np.random.default_rng(seed)
    discs = np.column_stack([rng.uniform(-30, 30, (4, 2)), rng.uniform(0.5, 12.0, 4)])
    corners = rng.uniform(-30, 30, (3, 2))
    drawn = "".join(f"translate([{x},{y}]) circle({r});" for x, y, r in discs)
    drawn += f"polygon({corners.tolist()});"
    points = np.concatenate([*(circle(*disc) for disc in discs), corners])
    made = solid(f"linear_extrude(10) hull() {{ {drawn} }}", tmp_path)
    assert made.volume == pytest.approx(10.0 * ConvexHull(points).volume, rel=2e-4)
    inside = np.column_stack([points.mean(axis=0)[None], [[5.0]]])
    assert made.signed_distance(inside)[0] < 0.0


@pytest.mark.parametrize(
    ("drawn", "area"),
    [
        ("circle(10); translate([3,0]) circle(4);", np.pi * 100),
        ("circle(5); translate([20,0]) circle(5); translate([40,0]) circle(5);", np.pi * 25 + 400),
        ("circle(5); circle(5);", np.pi * 25),
        ("translate([-5,0]) square(10); translate([0,10]) circle(5);", 100 + np.pi * 12.5),
    ],
)
def test_what_holds_another_or_stands_in_a_row_or_flush(drawn, area, tmp_path):
    made = solid(f"linear_extrude(4) hull() {{ {drawn} }}", tmp_path)
    assert made.volume == pytest.approx(4.0 * area, rel=5e-4)


@pytest.mark.parametrize("turned", ["", "rotate([90,0,0])", "rotate([20,50,10])"])
def test_a_box_and_a_bar_of_one_height(turned, tmp_path):
    """As a servo's arm is drawn: a foot, and the round end above it."""
    arm = "cube([30,10,5]); translate([15,37,0]) cylinder(h=5,r=12);"
    foot = np.array([(0, 0), (30, 0), (30, 10), (0, 10)], dtype=float)
    made = solid(f"{turned} hull() {{ {arm} }}", tmp_path)
    area = ConvexHull(np.concatenate([foot, circle(15.0, 37.0, 12.0)])).volume
    assert made.volume == pytest.approx(5.0 * area, rel=2e-4)
    assert {surface.shape.kind for surface in made.surfaces} == {"plane", "cylinder"}


def test_bars_of_other_heights_are_refused(tmp_path):
    with pytest.raises(PalpateError, match="no exact form"):
        solid("hull() { cube([30,10,5]); translate([15,37,0]) cylinder(h=8,r=12); }", tmp_path)

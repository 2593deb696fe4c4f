"""Flat regions: sections of solids, what they share, and polygons without holes that make them up."""

import numpy as np

from models.csg import Cube, Cylinder
from models.meshing.flat_regions import Region, section
from models.solid import Solid
from primitives.pose import pose, rotation_exp

PLATE = Solid.from_csg(Cube((40, 30, 10)) - Cylinder(5, 20))


def square(side, at=(0.0, 0.0)):
    half = 0.5 * side
    return np.array([[-half, -half], [half, -half], [half, half], [-half, half]]) + at


def signed_area(corners):
    x, y = corners.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_a_section_is_what_the_plane_cuts_of_a_solid_at_any_attitude():
    middle = section(PLATE.body.mesh, pose(translation=[0.0, 0.0, 2.0]))
    assert abs(middle.area - (1200.0 - 25.0 * np.pi)) < 0.1
    across = section(PLATE.body.mesh, pose(rotation_exp([0.5 * np.pi, 0.0, 0.0]), [0.0, 12.0, 0.0]))
    assert abs(across.area - 400.0) < 1e-6
    assert not section(PLATE.body.mesh, pose(translation=[0.0, 0.0, 6.0]))


def test_polygons_without_holes_make_up_a_region_with_holes():
    region = Region.of(
        [square(20.0), square(4.0, (-5.0, 0.0)), square(4.0, (5.0, 2.0)), square(6.0, (40.0, 0.0))]
    )
    polygons = region.polygons
    assert abs(sum(map(signed_area, polygons)) - region.area) < 1e-6
    assert all(signed_area(corners) > 0.0 for corners in polygons)
    assert abs(region.area - (400.0 - 32.0 + 36.0)) < 1e-9
    assert len(region.pieces) == 2


def test_what_is_narrow_goes_when_a_region_is_opened_and_corners_stay():
    lean = Region.of([square(20.0)]) | Region.of([square(1.0, (10.5, 0.0))])
    assert abs(lean.opened(0.8).area - 400.0) < 1e-6


def test_depth_is_positive_inside():
    region = Region.of([square(20.0)]) - Region.disks(np.array([[4.0, 0.0]]), 2.0)
    depth = region.depth(np.array([[-8.0, 0.0], [4.0, 0.0], [13.0, 0.0]]))
    np.testing.assert_allclose(depth, [2.0, -2.0, -3.0], atol=0.05)
    assert (Region().depth(np.zeros((2, 2))) == -np.inf).all()


def test_a_region_with_a_hole_that_touches_its_outermost_corner_shrinks_as_others_do():
    """A library that takes that hole for the outline leaves nothing."""
    outer = np.array([[40.9, 60.0], [62.13570805, 78.32317711], [65.6, 79.46444751], [72.3, 60.0]])
    hole = outer[2] - [1e-8, 0.0] + [
        [0.0, 0.0], [1.0971, -3.3293], [-4.0, -4.2], [-6.6343, -3.3379], [-6.6305, -2.1844],
        [-4.98474705, -1.64222354], [-0.69285839, -0.22825408],
    ]  # fmt: skip
    region = Region.of([outer, hole])
    for by in (0.05, 0.3, 0.8):
        assert 0.0 < region.area - region.grown(-by).area < 110.0 * by
        assert 0.0 < region.grown(by).area - region.area < 200.0 * by
        assert region.opened(by).area > region.area - 20.0 * by
    assert not Region().grown(1.0)

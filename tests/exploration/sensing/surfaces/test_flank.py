"""Flanks of cylinders and cones, cut by edges across them."""

import numpy as np
import pytest

from exploration.sensing.surfaces.flank import flank_of
from exploration.sensing.surfaces.local_surface import fit_surface
from exploration.sensing.touch import perceive

RADIUS, ANGLE = 35.0, 0.3


@pytest.fixture
def sharp(frames):
    """Of a rubber that spreads less than the others' do."""
    return type(frames)(spread=1.2)


def flank(sharp, low=-6.0, high=6.0):
    """A cylinder across the pad, cut square at two places along its ridge [mm]."""
    across = np.arctan2(-np.cos(ANGLE), np.sin(ANGLE))
    round_ = sharp.cylinder(RADIUS, ANGLE, 0.0)
    below, above = sharp.half(across, low, 1), sharp.half(across, high, -1)
    return lambda x, y: round_(x, y) * below(x, y) * above(x, y)


def top(surface):
    return float(surface.depth_at(np.zeros((1, 2)))[0])


def test_ends_in_the_model_take_the_lift_out_of_a_low_cylinder(sharp):
    rng = np.random.default_rng(0)
    images = [sharp(flank(sharp), rng) for _ in range(20)]
    smooth = [fit_surface(image) for image in images]
    ended = [flank_of(image, surface, surface.chi2) for image, surface in zip(images, smooth, strict=True)]
    assert np.mean([s.chi2 / s.dof for s in smooth]) > 1.5
    assert np.mean([s.chi2 / s.dof for s in ended]) < 1.2
    assert abs(np.mean([top(s) for s in ended]) - 0.5) < 0.5 * abs(np.mean([top(s) for s in smooth]) - 0.5)
    assert np.mean([s.principal[0][0] for s in ended]) == pytest.approx(1 / RADIUS, rel=0.15)


def test_one_end_is_enough_where_the_pad_sees_one(sharp):
    image = sharp(flank(sharp, high=40.0), np.random.default_rng(1))
    ended = flank_of(image, fit_surface(image), np.inf)
    assert ended.chi2 < 1.3 * ended.dof
    assert top(ended) == pytest.approx(0.5, abs=0.03)


def test_a_cylinder_that_goes_on_keeps_its_place_and_curvature(sharp):
    rng = np.random.default_rng(2)
    for _ in range(10):
        image = sharp(sharp.cylinder(RADIUS, ANGLE, 0.0), rng)
        smooth = fit_surface(image)
        surface = flank_of(image, smooth, np.inf)
        assert top(surface) == pytest.approx(top(smooth), abs=0.02)
        assert surface.principal[0][0] == pytest.approx(1 / RADIUS, rel=0.1)


def test_a_ball_has_no_flank(sharp):
    image = sharp(sharp.sphere(20.0), np.random.default_rng(4))
    assert flank_of(image, fit_surface(image), np.inf) is None


def test_a_touch_on_a_low_cylinder_is_read_with_its_ends(sharp):
    image = sharp(flank(sharp), np.random.default_rng(3))
    assert perceive(image).surface.chi2 < 1.3 * perceive(image).surface.dof

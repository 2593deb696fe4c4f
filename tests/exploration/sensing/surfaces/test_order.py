"""The order of a surface from one frame, and the radius that goes with it."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.surfaces.local_surface import fit_surface
from exploration.sensing.surfaces.smooth_fit import fit_dome, fit_shape, smooth_contact
from exploration.sensing.surfaces.smooth_shapes import BALL, RIDGE
from primitives.curvature import ORDERS


@pytest.mark.parametrize(
    ("order", "radius"),
    [
        ("plane", 0.0),
        ("cylinder or cone", 20.0),
        ("cylinder or cone", 500.0),
        ("sphere", 20.0),
        ("sphere", 200.0),
    ],
)
def test_order_and_radius_are_told_from_one_frame(frames, order, radius):
    rng = np.random.default_rng(0)
    z = []
    for _ in range(30):
        x, y, angle = *rng.uniform(-2, 2, 2), rng.uniform(0, np.pi)
        field = {
            "plane": frames.plane(0.5, (0.005, 0.01)),
            "cylinder or cone": frames.cylinder(radius, angle, x),
            "sphere": frames.sphere(radius, x, y),
        }[order]
        surface = fit_surface(frames(field, rng))
        assert surface.order == order
        assert surface.orders.sum() == pytest.approx(1.0)
        assert len(surface.orders) == len(ORDERS)
        found, sigma = surface.radius
        if radius:
            z.append((1 / found - 1 / radius) / (sigma / found**2))
        else:
            assert found == np.inf
    assert not z or 0.5 < np.mean(np.square(z)) < 1.9


def test_the_order_of_what_hardly_bends_is_left_open(frames):
    """Sagging by a tenth of the noise, a cylinder may be a plane, and the probabilities say so."""
    rng = np.random.default_rng(1)
    chances = [fit_surface(frames(frames.cylinder(4000.0, 1.5), rng)).orders[0] for _ in range(20)]
    assert 0.3 < np.mean(chances) < 0.999


@pytest.mark.parametrize(("shape", "radius"), [(RIDGE, 6.0), (BALL, 12.0)])
def test_a_round_section_is_a_circle_and_not_a_parabola(frames, shape, radius):
    field = frames.cylinder(radius, 0.4, 0.5) if shape == RIDGE else frames.sphere(radius, 0.5, -0.3)
    contact = smooth_contact(replace(frames(field), sigma=np.full((10, 16), 0.005)))
    fit = fit_shape(contact, fit_dome(contact), shape)
    greatest = np.linalg.eigvalsh(np.array([[fit.parameters[3], fit.parameters[4]], fit.parameters[4:6]]))[1]
    assert 1 / greatest == pytest.approx(radius, rel=0.03)


def test_gain_spread_does_not_lift_a_plane(frames):
    """A taxel that reads low is not trusted more for it."""
    rng = np.random.default_rng(2)
    gain_sigma, off = 0.1, []
    for _ in range(60):
        image = frames(frames.plane(0.5), rng)
        depth = image.depth * (1 + gain_sigma * rng.standard_normal(image.depth.shape))
        sigma = np.hypot(image.sigma, gain_sigma * depth)
        surface = fit_surface(replace(image, depth=depth, sigma=sigma, gain_sigma=gain_sigma))
        off.append(
            (surface.depth_at(np.zeros((1, 2)))[0] - 0.5) / surface.depth_sigma_at(np.zeros((1, 2)))[0]
        )
    assert abs(np.mean(off)) < 0.6

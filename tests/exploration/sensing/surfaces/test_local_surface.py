from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibration import CLIPPED
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.surfaces.footprint import PLANE, fit_footprint
from exploration.sensing.surfaces.local_surface import NoSurface, fit_surface


@pytest.mark.parametrize("radius", [10.0, 20.0, 60.0])
def test_blur_does_not_blunt_a_cylinder(frames, radius):
    rng = np.random.default_rng(0)
    found = [fit_surface(frames(frames.cylinder(radius, 0.4, 0.8), rng)) for _ in range(25)]
    curvature = np.mean([s.principal[0] for s in found], axis=0)
    assert curvature[0] == pytest.approx(1 / radius, rel=0.1)
    assert curvature[1] == pytest.approx(0.0, abs=1e-3)
    depth = np.mean([s.depth_at(np.array([[-0.8 * np.sin(0.4), 0.8 * np.cos(0.4)]]))[0] for s in found])
    assert depth == pytest.approx(0.5, abs=0.02)


def test_the_normal_of_a_flat_face_is_its_tilt_to_a_tenth_of_a_degree(frames):
    rng = np.random.default_rng(1)
    for _ in range(25):
        g = rng.normal(0.0, 0.01, 2)
        surface = fit_surface(frames(frames.plane(0.5, tuple(g)), rng))
        normal = np.array([-g[0], -g[1], -1.0]) / np.sqrt(1 + g @ g)
        assert not surface.curved
        assert np.degrees(np.arccos(min(1.0, surface.normal @ normal))) < 0.1
        assert surface.point[2] == pytest.approx(-(0.5 + g @ surface.point[:2]), abs=0.015)


def test_what_saturated_taxels_leave_open_they_leave_open_together(frames):
    rng = np.random.default_rng(3)
    image = frames(frames.plane(0.8), rng)
    full = replace(image, sigma=CLIPPED * image.depth, saturated=np.ones(image.depth.shape, dtype=bool))
    middle = np.zeros((1, 2))
    assert fit_surface(image).depth_sigma_at(middle)[0] < 0.01
    assert fit_surface(full).depth_sigma_at(middle)[0] == pytest.approx(0.8 * CLIPPED, rel=0.05)


def test_covariance_is_the_scatter_on_a_sphere(frames):
    rng = np.random.default_rng(2)
    truth = np.array([0.5 - 0.5 * 5 / 60, 1 / 60, 2 / 60])
    z = []
    for _ in range(60):
        surface = fit_surface(frames(frames.sphere(60.0, 1.0, 2.0), rng))
        z.append((surface.coefficients[:3] - truth) / np.sqrt(np.diag(surface.covariance)[:3]))
    assert np.sqrt(np.mean(np.square(z), axis=0)) == pytest.approx(np.ones(3), abs=0.4)


def test_the_deepest_point_of_a_sphere_is_its_pole(frames):
    surface = fit_surface(frames(frames.sphere(40.0, 2.0, -1.0), np.random.default_rng(3)))
    assert surface.point == pytest.approx([2.0, -1.0, -0.5], abs=0.4)
    assert surface.point[2] == pytest.approx(-0.5, abs=0.05)
    assert surface.normal @ [0, 0, -1] > 0.9999


def test_an_edge_does_not_tilt_the_face_beside_it(frames):
    rng = np.random.default_rng(4)
    for _ in range(20):
        image = frames(frames.edge(0.9, 1.0), rng)
        surface = fit_surface(image, find_lines(image))
        assert not surface.curved
        gradient, sigma = surface.coefficients[1:3], np.sqrt(np.diag(surface.covariance)[1:3])
        assert (np.abs(gradient) < 4.5 * sigma).all()
        assert (sigma < 0.01).all()


def test_the_model_matches_finely_sampled_frames(frames):
    """The cells of the model are a taxel wide; those of the frames an eighth of it."""
    cases = [
        (frames.cylinder(20.0, 0.0, 0.45), [0.5 - 0.45**2 / 40, 0.0, 0.45 / 20, 0.0, 0.0, 0.05], ()),
        (frames.plane(0.2, (0.04, 0.03)), [0.2, 0.04, 0.03, 0.0, 0.0, 0.0], ()),
        (frames.edge(0.7, 1.0, slope=(0.01, 0.0)), [0.5, 0.01, 0.0, 0.0, 0.0, 0.0, 0.7, 1.0], (1.0,)),
    ]
    for field, parameters, sides in cases:
        image = frames(field)
        fit = fit_footprint(image, np.array(parameters), np.array(sides), steps=0)
        assert np.abs(fit.residual * image.sigma).max() < 0.012


def test_a_noiseless_fit_finds_its_parameters_from_afar(frames):
    image = frames(frames.edge(0.7, 1.0, slope=(0.01, -0.005)))
    fit = fit_footprint(image, np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.8, 0.2]), np.ones(1), shape=PLANE)
    assert fit.converged
    assert fit.parameters[[0, 1, 2, 6, 7]] == pytest.approx([0.5, 0.01, -0.005, 0.7, 1.0], abs=0.01)


def test_nothing_and_broken_frames_say_why(frames):
    rng = np.random.default_rng(5)
    empty = fit_surface(frames(frames.plane(0.0), rng))
    assert isinstance(empty, NoSurface)
    assert not empty
    assert "noise" in empty.reason

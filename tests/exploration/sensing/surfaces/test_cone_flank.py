"""What a pad on the flank of a cone feels, beside the cone itself."""

import numpy as np
import pytest

from exploration.sensing.surfaces.cone_flank import fit_cone_flank, paraboloid
from exploration.sensing.touch import perceive

ANGLE, DEPTH = 0.5, 0.5


def cone(half_angle, apex, rim=np.inf):
    """Depth under a cone that touches along a ruling, `apex` [mm] from its apex, cut at a circle `rim` mm away.

    The height comes by bisection, between the ruling and the axis, of the angle to the axis.
    """
    cosine, sine = np.cos(half_angle), np.sin(half_angle)

    def field(x, y):
        u = np.cos(ANGLE) * x + np.sin(ANGLE) * y + apex
        v = np.cos(ANGLE) * y - np.sin(ANGLE) * x
        low, high = np.zeros_like(u), np.maximum(0.0, u) * sine / cosine + DEPTH * (u <= 0.0)
        for _ in range(40):
            drop = 0.5 * (low + high)
            inside = (u * cosine + drop * sine) > cosine * np.sqrt(u**2 + v**2 + drop**2)
            low, high = np.where(inside, low, drop), np.where(inside, drop, high)
        return np.where(u * cosine + high * sine < rim * cosine, np.maximum(DEPTH - high, 0.0), 0.0)

    return field


@pytest.mark.parametrize(("half_angle", "apex"), [(0.4, 25.0), (0.2, 60.0), (0.7, 40.0)])
def test_a_clean_frame_tells_the_cone(make_frames, half_angle, apex):
    frames = make_frames(noise=0.001)
    start = [0.4, 0.01, 0.8 / (apex * np.tan(half_angle)), ANGLE + 0.1, 0.0, 0.3]
    flank = fit_cone_flank(frames(cone(half_angle, apex)), np.array(start), np.empty(0))
    depth, slope, k, angle, b, middle = flank.parameters
    assert flank.converged
    assert 1 / b == pytest.approx(apex, rel=0.02)
    assert np.arctan(b / k) == pytest.approx(half_angle, rel=0.03)
    assert angle == pytest.approx(ANGLE, abs=0.003)
    assert [depth, slope, middle] == pytest.approx([DEPTH, 0.0, 0.0], abs=0.003)


def test_parameters_miss_by_what_is_stated(frames):
    rng, truth = np.random.default_rng(0), np.array([DEPTH, 0.0, 1 / (50 * np.tan(0.3)), ANGLE, 1 / 50, 0.0])
    field = cone(0.3, 50.0)
    pulls = []
    for _ in range(60):
        flank = fit_cone_flank(frames(field, rng), truth * 0.9, np.empty(0))
        pulls.append((flank.parameters - truth) / np.sqrt(np.diag(flank.covariance)))
    assert np.std(pulls, axis=0) == pytest.approx(np.ones(6), abs=0.35)
    assert np.abs(np.mean(pulls, axis=0)).max() < 0.6


def test_its_own_circles_cut_it(make_frames):
    frames = make_frames(noise=0.001)
    start = np.array([0.5, 0.0, 0.08, ANGLE, 0.02, 0.0, 6.0, 0.1])
    flank = fit_cone_flank(frames(cone(0.4, 25.0, rim=30.0)), start, np.array([-1.0]))
    assert flank.parameters[6] == pytest.approx(5.0, abs=0.02)
    assert flank.parameters[7] == pytest.approx(0.0, abs=0.02)


def test_the_paraboloid_touches_it_wherever_asked(frames):
    truth = np.array([DEPTH, 0.01, 0.08, ANGLE, 0.03, 0.5])
    flank = fit_cone_flank(frames(cone(0.4, 30.0)), truth, np.empty(0))
    for at in (-5.0, 0.0, 8.0):
        hessian = paraboloid(flank, at).parameters[[3, 4, 5]]
        assert hessian[0] + hessian[2] == pytest.approx(flank.parameters[2] / (1 + flank.parameters[4] * at))


@pytest.mark.parametrize("rim", [np.inf, 32.0])
def test_a_pad_on_a_cone_feels_no_flat_strip(frames, rim):
    rng, field = np.random.default_rng(1), cone(0.4, 25.0, rim)
    surfaces = [perceive(frames(field, rng)).surface for _ in range(10)]
    assert np.mean([surface.curved for surface in surfaces]) >= 0.7
    assert np.median([surface.chi2 / surface.dof for surface in surfaces]) < 1.2
    assert np.mean([surface.point[2] for surface in surfaces]) == pytest.approx(-DEPTH, abs=0.02)

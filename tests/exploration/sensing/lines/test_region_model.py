import numpy as np
import pytest
from scipy.stats import multivariate_normal, ncx2

from exploration.sensing.lines.blurred_disc import of_disc
from exploration.sensing.lines.normal_pair import NODES, both, chance, prepare
from exploration.sensing.lines.region import NO_TERMS, ONE, THREE, TWO, WHOLE, Region
from exploration.sensing.lines.region_model import evaluate
from exploration.sensing.response import rubber

PLANE = (0.5, 0.02, -0.015)  # depth and slopes of the face
LINES = ((0.3, 1.0), (1.6, -2.0), (2.5, -1.0))
SHAPES = {
    "corner": (Region((1.0, 1.0), TWO[0]), [*LINES[0], *LINES[1]]),
    "inside corner": (Region((1.0, 1.0), TWO[1]), [*LINES[0], *LINES[1]]),
    "wall": (Region((1.0, -1.0), TWO[0]), [0.3, -1.5, 0.35, 2.5]),
    "slot": (Region((-1.0, 1.0), TWO[1]), [0.3, -1.5, 0.3, 1.5]),
    "triangle's corner": (Region((1.0, 1.0, -1.0), THREE[0]), [*LINES[0], *LINES[1], *LINES[2]]),
    "other corner": (Region((-1.0, 1.0, 1.0), THREE[0]), [*LINES[0], *LINES[1], *LINES[2]]),
    "blind slot": (Region((1.0, -1.0, 1.0), THREE[1]), [*LINES[0], *LINES[1], *LINES[2]]),
    "step": (Region((1.0, 1.0, 1.0), THREE[2]), [*LINES[0], *LINES[1], *LINES[2]]),
    "pin": (Region((), NO_TERMS, (1.0,)), [1.0, 0.5, 2.0]),
    "rim": (Region((), NO_TERMS, (1.0,)), [-18.0, 5.0, 20.0]),
    "hole": (Region((), WHOLE, (-1.0,)), [-3.0, 2.0, 4.0]),
    "tube": (Region((), NO_TERMS, (1.0, -1.0)), [0.0, 0.0, 7.0, 0.5, 0.0, 3.0]),
    "hole by an edge": (Region((1.0,), ONE[0], (-1.0,)), [0.3, -4.0, 3.0, 3.0, 1.5]),
}


def modeled(array, spread, region, p):
    out = np.zeros((1 + len(p), *array.shape))
    evaluate(array.x, array.y, rubber(spread, array.pitch).variance, p, *region.arrays, out)
    return out


@pytest.mark.parametrize("name", SHAPES)
def test_the_closed_form_is_the_sampled_and_blurred_field(frames, name):
    region, shape = SHAPES[name]
    p = np.array([*PLANE, *shape])

    def field(x, y):
        shift = (np.arange(5) - 2) / 5 * 0.225
        points = [np.stack([x + a, y + b], axis=-1).reshape(-1, 2) for a in shift for b in shift]
        cover = np.mean([region.holds(at, p) for at in points], axis=0).reshape(x.shape)
        return cover * (p[0] + p[1] * x + p[2] * y)

    assert modeled(frames.array, frames.spread, region, p)[0] == pytest.approx(
        frames(field).depth, abs=1.5e-3
    )


@pytest.mark.parametrize("name", SHAPES)
def test_derivatives_are_those_of_differences(frames, name):
    region, shape = SHAPES[name]
    p = np.array([*PLANE, *shape])
    found = modeled(frames.array, frames.spread, region, p)[1:]
    for k in range(len(p)):
        step = np.zeros(len(p))
        step[k] = 5e-3
        up, down = (modeled(frames.array, frames.spread, region, p + s)[0] for s in (step, -step))
        slope = (up - down) / 1e-2
        assert found[k] == pytest.approx(slope, abs=2e-3 * np.abs(slope).max() + 1e-5)


@pytest.mark.parametrize("c", [-0.9999, -0.9, -0.6, -0.1, 0.0, 0.4, 0.74, 0.76, 0.99])
def test_a_blurred_wedge_is_the_bivariate_normal(c):
    rng = np.random.default_rng(0)
    nodes = np.zeros((NODES, 3))
    prepare(c, nodes)
    for h, k in rng.normal(0.0, 2.0, (20, 2)):
        exact = multivariate_normal.cdf([h, k], [0.0, 0.0], [[1.0, c], [c, 1.0]])
        assert both(h, k, chance(h), chance(k), c, nodes) == pytest.approx(exact, abs=3e-6)


@pytest.mark.parametrize("b", [0.3, 1.07, 3.0, 8.0, 30.0])
def test_a_blurred_disc_is_the_noncentral_chi_square(b):
    a = np.linspace(max(0.0, b - 7.0), b + 7.0, 60)
    assert of_disc(a, b) == pytest.approx(ncx2.cdf(b * b, 2, a * a), abs=1e-5)

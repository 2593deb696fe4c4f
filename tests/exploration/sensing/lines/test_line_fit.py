import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.sensing.lines.line import clipped, normalized
from exploration.sensing.lines.line_fit import fit_line
from exploration.sensing.response import response_of


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2, 2.9])
@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.01, -0.008)])
def test_a_noiseless_edge_is_found_to_a_hundredth_of_a_taxel_tilted_or_not(frames, angle, slope):
    image = frames(frames.edge(angle, 1.3, slope=slope))
    fit = fit_line(image, response_of(image), angle + 0.08, 0.6, 1)
    assert fit.converged
    assert fit.parameters[0] == pytest.approx(angle, abs=1e-3)
    assert fit.parameters[1] == pytest.approx(1.3, abs=0.02)


def test_covariance_is_the_scatter(frames):
    rng = np.random.default_rng(2)
    field = frames.edge(0.5, -1.0)
    fits = [
        fit_line(image, response_of(image), 0.5, -1.0, 1)
        for image in (frames(field, rng) for _ in range(150))
    ]
    found = np.array([fit.parameters[:2] for fit in fits])
    z = (found - [0.5, -1.0]) / np.sqrt([np.diag(fit.covariance)[:2] for fit in fits])
    assert np.mean(z**2, axis=0) == pytest.approx([1.0, 1.0], abs=0.35)


@given(angle=st.floats(-9.0, 9.0), offset=st.floats(-9.0, 9.0), side=st.sampled_from([-1, 1]))
def test_normalizing_keeps_the_line_and_its_material(angle, offset, side):
    a, r, s = normalized(angle, offset, side)
    assert 0.0 <= a < np.pi
    before = side * np.array([-np.sin(angle), np.cos(angle)])
    assert s * np.array([-np.sin(a), np.cos(a)]) == pytest.approx(before, abs=1e-9)
    assert s * r == pytest.approx(side * offset)


@settings(max_examples=50)
@given(angle=st.floats(0.0, 3.14), offset=st.floats(-20.0, 20.0))
def test_clipped_ends_lie_on_the_rim_of_the_pad(angle, offset):
    low, high = clipped(angle, offset, (14.4, 9.0))
    if high > low:
        for v in (low, high):
            x, y = v * np.cos(angle) - offset * np.sin(angle), v * np.sin(angle) + offset * np.cos(angle)
            assert max(abs(x) - 14.4, abs(y) - 9.0) == pytest.approx(0.0, abs=1e-6)

"""Broken edges from taxels beside them: kinds and sizes, by profiles that are integrated here in another way."""

import numpy as np
import pytest

from exploration.sensing.lines.edge_profiles import Taxels, pressed, size_of_edge

SPREAD, SIGMA = 1.1, 0.03


def height(kind, size, u):
    """[mm] under the face, of what is left of it at distances inside of an edge; it ends at the edge."""
    if kind == "sharp":
        return np.where(u < 0.0, -np.inf, 0.0)
    if kind == "chamfer":
        return np.where(u < 0.0, -np.inf, np.minimum(0.0, u - size))
    under = np.sqrt(np.maximum(size**2 - np.clip(size - u, 0.0, size) ** 2, 0.0)) - size
    return np.where(u < 0.0, -np.inf, under)


def blurred(kind, size, u, before):
    """The mean of 20,000 places under each taxel, drawn as rubber spreads what presses on it."""
    drawn = u[:, None] + SPREAD * np.random.default_rng(0).standard_normal(20_000)
    return np.maximum(0.0, before[:, None] + height(kind, size, drawn)).mean(axis=1)


def looked(kind, size, rng, pads=6, count=60):
    lots = []
    for _ in range(pads):
        u = rng.uniform(-2.5, 5.5, count)
        before = np.full(count, rng.uniform(0.4, 1.4))
        depth = blurred(kind, size, u, before) + SIGMA * rng.standard_normal(count)
        lots.append(Taxels(u, before, depth, np.full(count, SIGMA), SPREAD))
    return lots


@pytest.mark.parametrize(
    ("kind", "size"), [("chamfer", 0.8), ("chamfer", 2.0), ("rounding", 1.0), ("rounding", 3.0)]
)
def test_a_profile_is_what_rubber_makes_of_the_edge(kind, size):
    u, before = np.linspace(-2.5, 6.0, 18), np.full(18, 0.9)
    assert pressed(kind, size, SPREAD, u, before) == pytest.approx(blurred(kind, size, u, before), abs=0.02)
    assert pressed(kind, 0.0, SPREAD, u, before) == pytest.approx(blurred("sharp", 0.0, u, before), abs=0.02)


@pytest.mark.parametrize(
    ("kind", "size"), [(kind, size) for kind in ("chamfer", "rounding") for size in (1.2, 2.0, 3.0)]
)
def test_two_faces_tell_the_size_of_their_edge_and_large_ones_its_kind(kind, size):
    rng = np.random.default_rng(int(10 * size))
    told = size_of_edge([looked(kind, size, rng), looked(kind, size, rng)])
    assert told is not None
    sizes, by = told
    number = ("chamfer", "rounding").index(kind)
    assert sizes[number] == pytest.approx(size, abs=0.15)
    if size >= 2.0:
        assert (by > 0.0) == (kind == "chamfer")


def test_a_sharp_edge_one_off_by_what_faces_err_and_too_few_taxels_are_not_broken():
    rng = np.random.default_rng(3)
    sharp = [looked("sharp", 0.0, rng), looked("sharp", 0.0, rng)]
    assert size_of_edge(sharp) is None
    moved = [[Taxels(t.inside + 0.15, t.before, t.depth, t.sigma, t.spread) for t in lot] for lot in sharp]
    assert size_of_edge(moved) is None
    assert size_of_edge([looked("chamfer", 1.5, rng, pads=1, count=8)]) is None

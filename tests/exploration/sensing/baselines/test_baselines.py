"""Baselines behind our interface: an easy edge is found, an empty frame is silent, imports stay optional."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.baselines.muthukrishnan import outlines, settled
from exploration.sensing.baselines.table import baselines


@pytest.mark.parametrize("name", baselines())
@pytest.mark.parametrize("angle", [0.03, 0.7, 1.6, 2.5])
def test_every_baseline_finds_an_easy_edge_and_its_material_side(name, angle, frames):
    for offset, side in ((2.0, 1), (-1.0, -1)):
        image = frames(frames.edge(angle, offset, side), np.random.default_rng(1))
        lines = baselines()[name](image)
        assert lines
        turn = (lines[0].angle - angle + np.pi / 2) % np.pi - np.pi / 2
        point = offset * np.array([-np.sin(angle), np.cos(angle)])
        assert abs(turn) < np.radians(15)
        assert abs(lines[0].distance(point[None])[0]) < 1.5 * 1.8
        assert lines[0].distance((point + 4 * side * np.array([-np.sin(angle), np.cos(angle)]))[None])[0] > 0


@pytest.mark.parametrize("name", baselines())
def test_every_baseline_says_nothing_on_empty_frames(name, frames):
    for seed in range(20):
        assert baselines()[name](frames(lambda x, y: 0.0 * x, np.random.default_rng(seed))) == ()


@pytest.mark.parametrize("name", baselines())
def test_every_baseline_bears_frames_that_cannot_be_read(name, frames):
    image = frames(frames.edge(0.3, 0.0))
    depth = image.depth.copy()
    depth[3, 4] = np.nan
    assert baselines()[name](replace(image, depth=depth)) == ()


MANY = [name for name in baselines() if "erf" not in name and "fitLine" not in name]


@pytest.mark.parametrize("name", MANY)
def test_those_that_seek_several_lines_find_both_edges_of_a_wall(name, frames):
    above, below = frames.half(0.4, -4.0, 1), frames.half(0.4, 4.0, -1)
    image = frames(lambda x, y: 0.5 * above(x, y) * below(x, y), np.random.default_rng(2))
    offsets = sorted(line.offset for line in baselines()[name](image) if abs(line.angle - 0.4) < 0.3)
    assert offsets[0] == pytest.approx(-4.0, abs=2.0)
    assert offsets[-1] == pytest.approx(4.0, abs=2.0)


def test_the_median_settles_and_keeps_a_straight_edge():
    depth = np.zeros((8, 8))
    depth[:, 4:] = 1.0
    spoiled = depth.copy()
    spoiled[2, 1], spoiled[5, 6] = 1.0, 0.0
    np.testing.assert_array_equal(settled(spoiled), depth)


def test_outlines_of_a_square_inside_the_pad_are_one_closed_chain():
    on = np.zeros((8, 9), dtype=bool)
    on[2:6, 3:7] = True
    (chain,) = outlines(on)
    assert len(chain) == 16
    assert np.all(np.hypot(*np.diff(chain, axis=0).T) <= 1.0 + 1e-9)


def test_outlines_stop_at_the_rim_of_the_pad():
    on = np.zeros((6, 7), dtype=bool)
    on[:, 3:] = True
    (chain,) = outlines(on)
    np.testing.assert_array_equal(np.sort(chain[:, 1]), np.arange(6))
    np.testing.assert_array_equal(chain[:, 0], 2.5)


def test_sensing_imports_neither_opencv_nor_skimage():
    code = (
        "import sys, exploration.sensing.baselines.table as t; t.baselines();"
        "sys.exit(any(m in sys.modules for m in ('cv2', 'skimage')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

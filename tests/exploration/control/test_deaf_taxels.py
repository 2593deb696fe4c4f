"""A track's own frames tell which taxels are dead."""

import numpy as np
import pytest

from exploration.control.deaf_taxels import hearing
from exploration.control.edge_ticks import EdgeTick
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.followed import Followed
from exploration.sensing.response import rubber
from exploration.sensing.spec import load_sensor

SPEC = load_sensor("lts210")
RESPONSE = rubber(SPEC.elastomer.spread, SPEC.array.pitch)
DEAD = [(5, 3), (7, 9), (4, 12), (0, 0)]  # inside, further inside, on the edge, outside


def track(seed, dead=(), count=100):
    """Ticks along the middle of the pad, its far half on the material, with 5 % noise."""
    rng, py = np.random.default_rng(seed), SPEC.array.pitch[1]
    y = (np.arange(SPEC.array.rows) - 0.5 * (SPEC.array.rows - 1)) * py
    width = float(np.sqrt(RESPONSE.variance[1]))
    ticks = []
    for offset in rng.uniform(-0.6, 0.6, count) - 0.3 * py:
        depth = np.repeat(0.5 * RESPONSE.edge(y - offset, width)[:, None], SPEC.array.columns, axis=1)
        depth = depth + 0.025 * rng.standard_normal(depth.shape)
        for place in dead:
            depth[place] = 0.0
        image = TactileImage(SPEC.array, depth, np.full(depth.shape, 0.025), SPEC.elastomer.spread, 0.1, 0.0)
        line = np.array([0.0, offset, 0.5, 0.0, 0.0, 0.0])
        ends = np.full(5, np.inf)
        edge = Followed(line, np.eye(6), 1, 1.0, ends, np.zeros(3), True)
        ticks.append(EdgeTick(edge, image, np.eye(4), 1.0))
    return ticks


def deaf(ticks):
    """Places of the taxels that were left out."""
    return {tuple(p) for p in np.argwhere(np.isinf(ticks[0].image.sigma)).tolist()}


def test_dead_taxels_in_the_face_are_found_and_one_outside_does_no_harm():
    assert deaf(hearing(track(0, DEAD), RESPONSE, list)) == set(DEAD[:3])


@pytest.mark.parametrize("seed", range(3))
def test_living_taxels_are_left_alone(seed):
    assert deaf(hearing(track(seed), RESPONSE, list)) == set()


def test_a_few_frames_accuse_nobody():
    assert deaf(hearing(track(0, DEAD, count=20), RESPONSE, list)) == set()

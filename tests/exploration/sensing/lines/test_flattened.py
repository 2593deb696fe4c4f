"""A curved face beside an edge, seen as a flat one."""

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.flattened import MOST, flattened
from exploration.sensing.lines.followed import Expected
from exploration.sensing.spec import load_sensor

ARRAY = load_sensor("lts210").array
DEPTH, ALONG, ACROSS = 0.6, 0.02, 0.03


def test_what_curves_away_is_given_back_and_what_is_hardly_felt_is_left_out():
    x, y = np.meshgrid(ARRAY.x, ARRAY.y)
    edge = Expected(np.pi / 2, -1.0, -1)  # along y, through x = 1, the material on the side of +x
    left = DEPTH - 0.5 * ALONG * y**2 - 0.5 * ACROSS * np.maximum(x - 1.0, 0.0) ** 2
    depth = np.maximum(left, 0.0) * (x > 1.0)
    sigma = np.full(ARRAY.shape, 0.01)
    image = TactileImage(ARRAY, depth, sigma, 1.8, 0.1, 0.0)
    flat = flattened(image, edge, DEPTH, (ALONG, ACROSS))
    known = np.isfinite(flat.sigma)
    assert np.allclose(flat.depth[known & (x > 1.0)], DEPTH)
    assert (flat.depth[known & (x <= 1.0)] == 0.0).all()
    assert (known == (left > DEPTH / MOST)).all()
    assert np.allclose(flat.sigma[known], 0.01 * DEPTH / left[known])
    assert flattened(image, edge, DEPTH, (0.0, 0.0)) is image

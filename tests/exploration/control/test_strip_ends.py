"""The ends of bars under a pad that lies along them."""

import numpy as np
import pytest

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.sighting import strip_ends
from models.csg import Cube, Cylinder
from primitives.pose import pose, turn_about

X, Y, Z = np.eye(3)
ROD = Cylinder(3.0, 60.0).turned("y", np.pi / 2)  # along x, from -30 to 30 mm
BAR = Cube((60.0, 5.0, 5.0))


def lain(over, part, top, middle, turned, seed=0):
    """What a pad sees that is pressed 0.5 mm deep onto a bar, its middle at x, turned by an angle about z."""
    down = pose(np.diag([1.0, -1.0, -1.0]), [middle, 0.0, top - 0.5])
    guard, _ = over(part, turn_about(down[:3, 3], Z, turned) @ down, seed=seed)
    seen = dwell(guard, 8)
    return strip_ends(seen, feel(seen.image))


@pytest.mark.parametrize(("part", "top"), [(ROD, 3.0), (BAR, 2.5)])
@pytest.mark.parametrize("turned", [0.0, 0.3, np.pi / 2])
def test_the_end_of_a_bar_is_seen_by_a_pad_that_lies_along_it(over, part, top, turned):
    off = []
    for seed, middle in enumerate([26.0, 27.0, 28.0, -27.0]):
        (end,) = lain(over, part, top, middle, turned, seed)
        way = np.sign(middle) * X
        assert end.outward @ way > 0.995
        assert abs(end.tangent @ X) < 0.1
        assert end.normal @ Z > 0.999
        off.append((end.point @ way - 30.0) / end.sigma)
    assert np.abs(off).max() < 4.0
    assert end.sigma < 0.3


def test_no_end_is_seen_of_a_bar_that_goes_on(over):
    assert lain(over, ROD, 3.0, 0.0, 0.1) == []

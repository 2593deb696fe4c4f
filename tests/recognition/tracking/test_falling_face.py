"""The tracker's own fit, on frames of two faces that are spread by quadrature, says where their edge is."""

import numpy as np
import pytest
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.follow_line import follow_line
from exploration.sensing.lines.followed import Expected
from exploration.sensing.response import rubber
from primitives.arrays import frozen
from primitives.evidence import EdgeTrace
from recognition.tracking.falling_face import seeming, set_back

SPREAD, PITCH, PLACE = 1.2, 1.8, -1.0  # [mm]; the material lies above y = PLACE
ARRAY = TaxelArray("pad", 10, 16, (PITCH, PITCH))
RESPONSE = rubber(SPREAD, (PITCH, PITCH))


def frame_of(dihedral, depth):
    """What the pad shows of an edge along x: faces cut into slivers, each blurred, and averaged over a taxel."""
    slope = np.tan(np.pi - dihedral)
    slivers = np.arange(-depth / slope, 14.0, 0.01) + 0.005
    heights = np.minimum(depth, depth + slope * slivers)
    within = (np.arange(40) + 0.5) / 40 * PITCH - 0.5 * PITCH
    rows = []
    for y in ARRAY.y:
        t = (y + within - PLACE)[:, None] - slivers
        share = ndtr((t + 0.005) / SPREAD) - ndtr((t - 0.005) / SPREAD)
        rows.append(float((share @ heights).mean()))
    image = np.repeat(np.array(rows)[:, None], 16, axis=1)
    return TactileImage(ARRAY, frozen(image), frozen(np.full(ARRAY.shape, 0.01)), SPREAD, 0.1, 0.0)


@pytest.mark.parametrize("degrees", [100.0, 120.0, 135.0, 150.0])
@pytest.mark.parametrize("depth", [0.35, 0.6])
def test_rubber_on_the_falling_face_is_taken_off(degrees, depth):
    dihedral = np.radians(degrees)
    seen = follow_line(frame_of(dihedral, depth), RESPONSE, Expected(0.0, PLACE, 1))
    off = seeming(dihedral, seen.plateau, RESPONSE, RESPONSE.mean_width)
    assert off.aside == pytest.approx(0.5 * depth / np.tan(np.pi - dihedral), rel=0.1)
    assert seen.offset + off.aside == pytest.approx(PLACE, abs=0.002 + 0.015 * off.aside)
    assert seen.plateau + off.shallow == pytest.approx(depth, abs=0.002)


def test_a_trace_is_moved_inward_and_sharp_edges_are_left_where_they_are():
    points = np.column_stack([np.full(5, 0.45), np.arange(5.0), np.zeros(5)])
    along, up, outward = (np.tile(axis, (5, 1)) for axis in np.eye(3)[[1, 2, 0]])
    trace = EdgeTrace(
        frozen(points), frozen(along), frozen(up), frozen(np.full(5, 0.02)), False, touch=0, stroke=0
    )
    assert set_back(trace, outward, np.radians(60.0), 0.5, RESPONSE, 1.3) is trace
    moved = set_back(trace, outward, np.radians(150.0), 0.5, RESPONSE, 1.3).points - points
    assert np.allclose(moved[:, 0], -0.44, atol=0.02)
    assert np.allclose(moved[:, 1], 0.0)
    assert np.all((moved[:, 2] > 0.0) & (moved[:, 2] < 0.01))

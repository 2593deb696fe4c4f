"""Where to touch a known object, so that its surface is least in doubt."""

import numpy as np
import pytest

from exploration.planning.ways.round_ball import Ball
from models import parts
from models.library import Entry, Library
from models.solid import Solid
from primitives.pose import pose, random_rotation
from recognition.matching import Hypothesis
from recognition.matching.next_touch.placing import doubt, placing

PAD = (28.8, 18.0)
SURE, LOOSE = 1e-4, 0.25  # [mm^2], [rad^2]


@pytest.fixture(scope="module")
def block() -> Entry:
    return Library.of({"block": Solid.from_csg(parts.build("block"))})["block"]


def _believed(variances: list[float]) -> Hypothesis:
    turn = random_rotation(np.random.default_rng(3))
    return Hypothesis("block", pose(turn, [10.0, -5.0, 20.0]), 0.0, np.diag(variances), 0.0, np.zeros(0))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_place_in_doubt_along_one_axis_is_touched_along_it(block: Entry, axis: int) -> None:
    variances = [SURE] * 3 + [1e-8] * 3
    variances[axis] = LOOSE
    h = _believed(variances)
    assert doubt(h, block) == pytest.approx(np.sqrt(LOOSE + 2 * SURE), rel=0.01)
    chosen = placing(h, block, Ball(h.pose[:3, 3], 80.0), PAD, (0.1, 0.01), np.random.default_rng(0))
    assert chosen is not None
    assert abs(float(chosen.direction @ h.pose[:3, axis])) > 0.99


def test_a_turn_in_doubt_is_felt_far_from_its_axis(block: Entry) -> None:
    h = _believed([SURE] * 3 + [1e-8, 1e-8, 1e-3])
    chosen = placing(h, block, Ball(h.pose[:3, 3], 80.0), PAD, (0.1, 0.05), np.random.default_rng(0))
    assert chosen is not None
    along = np.cross(chosen.start[:3, 3] - h.pose[:3, 3], chosen.direction) @ h.pose[:3, 2]
    longest = float(block.solid.extent.max()) / 2
    assert abs(float(along)) > 0.6 * longest


def test_nothing_is_touched_where_nothing_can_be_reached(block: Entry) -> None:
    h, nowhere = _believed([LOOSE] * 3 + [1e-4] * 3), lambda approach: False
    ball = Ball(h.pose[:3, 3], 80.0)
    assert placing(h, block, ball, PAD, (0.1, 0.01), np.random.default_rng(0), nowhere) is None

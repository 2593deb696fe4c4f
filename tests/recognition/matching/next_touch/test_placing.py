"""Where to touch a known object, so that its surface is least in doubt."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.ways.round_ball import Ball
from models import parts
from models.library import Entry, Library
from models.solid import Solid
from primitives.evidence import Imprint
from primitives.pose import pose, random_rotation
from recognition.matching import Hypothesis
from recognition.matching.next_touch.placing import doubt, placing
from recognition.matching.sharpened import known_by

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


def _skin() -> Imprint:
    x, y = 1.8 * (np.arange(16) - 7.5), 1.8 * (np.arange(10) - 4.5)
    flat = np.zeros((10, 16))
    return Imprint(np.eye(4), x, y, flat, flat + 0.01, 1.2, 0.0, 1)


def test_where_the_skin_is_matched_too_a_place_in_doubt_along_a_face_is_felt_at_its_edge(
    block: Entry,
) -> None:
    h = _believed([LOOSE, 1e-6, 1e-6] + [1e-8] * 3)
    end = float(block.samples.points[:, 0].max())
    from_above, rng = (lambda a: abs(float(a.direction @ h.pose[:3, 2])) > 0.99), np.random.default_rng(0)
    ball = Ball(h.pose[:3, 3], 80.0)
    chosen = placing(h, block, ball, PAD, (0.1, 0.01), rng, from_above, skin=_skin())
    assert chosen is not None
    place = (chosen.start[:3, 3] - h.pose[:3, 3]) @ h.pose[:3, :3]
    assert end - abs(float(place[0])) < 0.5 * PAD[0]


def test_an_imprint_tells_along_the_skin_what_lies_across_an_edge_and_no_more(block: Entry) -> None:
    solid, high = block.solid.placed(np.eye(4)), block.samples.points.max(axis=0)
    facing = np.diag([1.0, -1.0, -1.0])
    on_face, on_edge = ([0.0, 0.0, high[2] - 0.6], [high[0], 0.0, high[2] - 0.6])
    face, edge = (known_by(replace(_skin(), pose=pose(facing, np.array(p))), solid, np.zeros(3))
                  for p in (on_face, on_edge))  # fmt: skip
    assert face[0, 0] < 1e-3
    assert edge[0, 0] > 1.0 / 0.4**2
    assert edge[1, 1] < 0.05 * edge[0, 0]

"""What is left to be told beside touches that were made."""

import numpy as np
import pytest

from primitives.pose import pose, rotation_exp
from recognition.matching.next_touch.novelty import NoveltyConfig, novelty

PAD = (28.8, 18.0)


def test_a_touch_made_again_tells_little_and_one_elsewhere_all() -> None:
    made = [pose(translation=[1.0, 2.0, 3.0])]
    far = pose(translation=[60.0, 2.0, 3.0])
    other_side = pose(rotation_exp([np.pi / 2.0, 0.0, 0.0]), [1.0, 2.0, 3.0])
    left = novelty(np.stack([made[0], far, other_side]), made, PAD)
    assert left[0] == pytest.approx(1.0 - NoveltyConfig().again)
    assert left[1:].min() > 0.99


def test_touches_at_one_place_add_up() -> None:
    here = pose()
    assert novelty(here[None], [here, here], PAD)[0] == pytest.approx((1.0 - NoveltyConfig().again) ** 2)
    assert novelty(here[None], [], PAD)[0] == 1.0

import numpy as np
import pytest

from exploration.sensing.spec import load_sensor
from primitives.pose import random_rotation
from recognition.running.smallness import small_for

PADS = [load_sensor("lts210"), load_sensor("fingertip")]


def box(x: float, y: float, z: float):
    """Places all over a box, anywhere and turned."""
    rng = np.random.default_rng(1)
    return rng.uniform(-0.5, 0.5, (400, 3)) * [x, y, z] @ random_rotation(rng).T + 200.0


def test_an_object_under_one_pad_is_small_for_it() -> None:
    (told,) = small_for(box(12, 9, 6), PADS)
    assert "lts210" in told
    assert "--sensor" in told


@pytest.mark.parametrize("size", [(60, 6, 6), (30, 20, 14), (20, 20, 5)])
def test_one_that_is_longer_is_not(size: tuple[float, ...]) -> None:
    assert small_for(box(*size), PADS) == []


def test_finer_taxels_are_enough_and_nothing_felt_says_nothing() -> None:
    assert small_for(box(14, 9, 6), [load_sensor("optical")]) == []
    assert small_for(np.zeros((0, 3)), PADS) == []
    assert small_for(box(12, 9, 6)[:8], PADS) == []

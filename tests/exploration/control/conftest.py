"""A simulated array over a solid, behind a guard."""

from collections.abc import Callable

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Csg
from models.solid import Solid
from primitives.arrays import Floats


@pytest.fixture
def over() -> Callable[..., tuple[Guard, Solid]]:
    """A guard whose array starts at a pose over a solid."""

    def build(tree: Csg, start: Floats, noise: float = 0.05, seed: int = 0) -> tuple[Guard, Solid]:
        solid = Solid.from_csg(tree)
        stage, arrays = simulate(
            solid, [load_sensor("lts210")], np.random.default_rng(seed), noise=noise, start_pose=start
        )
        return Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)]), solid

    return build

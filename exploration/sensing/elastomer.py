"""The rubber: indentation to pressure (Winkler, p = k depth), spread onto the taxels; and the net load.

F = k sum(depth A); the moment on the pad about its center is
sum r x (0, 0, -p A) = (-sum y p A, sum x p A, 0).
"""

import numpy as np

from exploration.sensing.gap import Indentation
from exploration.sensing.skin import MODES, skin_of
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats


def pressure(felt: Indentation, spec: SensorSpec) -> Floats:
    """(..., rows, columns) [N/mm^2] mean over each taxel, after the rubber's spread."""
    skin = skin_of(spec)
    total = sum(
        skin.spread_y[j] @ felt.modes[..., m, :, :] @ skin.spread_x[i].T for m, (i, j) in enumerate(MODES)
    )
    return np.asarray(spec.elastomer.stiffness * total)


def wrench(felt: Indentation, spec: SensorSpec, whole_skin: bool = False) -> Floats:
    """(..., 6) force [N] and moment [N mm] on the pad about its center, in the sensor frame.

    Over the cells under the taxels, or over the whole skin, which is what the stage feels.
    """
    skin = skin_of(spec)
    rows, columns = (slice(None), slice(None)) if whole_skin else (skin.rows, skin.columns)
    width, height = np.diff(skin.x_edges)[columns], np.diff(skin.y_edges)[rows]
    x = (skin.x_edges[:-1] + skin.x_edges[1:])[columns] / 2
    y = (skin.y_edges[:-1] + skin.y_edges[1:])[rows] / 2
    load = spec.elastomer.stiffness * np.outer(height, width) * felt.modes[..., rows, columns]
    mean, tilt_x, tilt_y = (load[..., m, :, :] for m in range(3))
    along_x = (x * mean + width / 6 * tilt_x).sum(axis=(-2, -1))
    along_y = (y[:, None] * mean + height[:, None] / 6 * tilt_y).sum(axis=(-2, -1))
    force = mean.sum(axis=(-2, -1))
    zero = np.zeros_like(force)
    return np.stack([zero, zero, -force, -along_y, along_x, zero], axis=-1)

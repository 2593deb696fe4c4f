"""What a taxel must read, from its neighbors: the best linear prediction from the 5 x 5 around it.

A field that the rubber has blurred changes slowly from taxel to taxel, so the one in the middle is known from
those around it.  The prediction sum_k w_k z_k has the least mean square error over presses that a taxel may see at
random (edges, corners both ways, thin walls, slots, pins, domes and tilted faces, blurred by the response's width)
in noise of `NOISE` of their height (our derivation; Wiener's normal equations, K w = k).  Near the rim of the pad
fewer neighbors predict: weights stand for every number of taxels from 0 to 2 on each of the four sides.

`slack` is the greatest error that any of those presses causes, as a share of the deepest taxel of the 5 x 5; and
the greatest where the middle reads next to nothing, which is less: pressure never pulls, so what reads nothing has
no deep neighbor.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from primitives.arrays import Bools, Floats, Ints, frozen

NOISE = 0.03  # of the press, for which the weights are best
PRESSES = 1600  # of each kind, to learn from
FAINT = 0.2  # of the press; where none of the 5 x 5 is deeper, errors count as if one were
NOTHING = 0.05  # of the deepest of the 5 x 5: what a taxel at most reads that feels next to nothing
SLOPE = 0.06  # of the press, by which its face at most rises from taxel to taxel
UNSEEN = 1.1  # slack over the greatest error of the presses that were tried
LEAST_SLACK = 0.03  # of the deepest
ROOM = 4.0  # [taxels and widths] from the taxel, within which they lie


@dataclass(frozen=True)
class Neighbors:
    """Weights by how many taxels, 0 to 2, there are on each side."""

    weights: Floats  # (9, 9, 25); first index 3 below + above, second 3 left + right; 0 in the middle
    slack: Floats  # (9, 9, 2) share of the deepest; for any reading, for one of next to nothing
    gain: Floats  # (9, 9) standard deviation of the difference where each taxel's noise is 1

    @staticmethod
    def classes(count: int) -> Ints:
        """(count,) 3 before + after for each place in a row of `count` taxels."""
        before = np.minimum(np.arange(count), 2)
        return frozen(3 * before + before[::-1], np.int64)


@lru_cache(maxsize=32)
def neighbors(width: float, pitch: tuple[float, float]) -> Neighbors:
    """The weights for a response of standard deviation `width` [mm]."""
    seen = _presses(width, pitch)
    weights, slack = np.zeros((9, 9, 25)), np.ones((9, 9, 2))
    for rows in range(9):
        for columns in range(9):
            there = (_there(rows)[:, None] & _there(columns)[None, :]).ravel()
            there[12] = False
            if there.sum() >= 3:
                weights[rows, columns, there], slack[rows, columns] = _predict(seen, there)
    gain = np.sqrt(1.0 + np.sum(weights**2, axis=2))
    return Neighbors(frozen(weights), frozen(slack), frozen(gain))


def _there(side: int) -> Bools:
    before, after = divmod(side, 3)
    return np.array([before > 1, before > 0, True, after > 0, after > 1])


def _predict(seen: Floats, there: Bools) -> tuple[Floats, tuple[float, float]]:
    around, middle = seen[:, there], seen[:, 12]
    normal = around.T @ around / len(seen) + NOISE**2 * np.eye(around.shape[1])
    weights = np.asarray(np.linalg.solve(normal, around.T @ middle / len(seen)), dtype=np.float64)
    deepest = np.maximum(np.abs(around).max(axis=1), np.abs(middle))
    error = (middle - around @ weights) / np.maximum(deepest, FAINT)
    pressed = slice(None, -2 * PRESSES)
    error, nothing = error[pressed], np.abs(middle[pressed]) < NOTHING * deepest[pressed]
    return weights, (
        LEAST_SLACK + UNSEEN * float(np.abs(error).max()),
        LEAST_SLACK + UNSEEN * float(-error[nothing].min(initial=0.0)),
    )


def _presses(width: float, pitch: tuple[float, float]) -> Floats:
    """(n, 25) presses of height 1 as the taxels feel them, then planes of any height and tilt."""
    rng = np.random.default_rng(0)
    n = PRESSES
    lattice = np.arange(-2, 3)
    x, y = lattice[None, None, :] * pitch[0], lattice[None, :, None] * pitch[1]
    reach = ROOM * 0.5 * (width + max(pitch))

    def half(turn: Floats, offset: Floats) -> Floats:
        t = y * np.cos(turn)[:, None, None] - x * np.sin(turn)[:, None, None] - offset[:, None, None]
        return np.asarray(ndtr(t / width))

    turn, offset = rng.uniform(-np.pi, np.pi, n), rng.uniform(-reach, reach, n)
    edge, across = half(turn, offset), half(turn + np.pi / 2, rng.uniform(-reach, reach, n))
    corner = edge * across
    far = half(turn, offset + rng.uniform(0.3, 3.0, n) * width)
    beside = half(turn + np.pi / 2, rng.uniform(-reach, reach, n))
    at = rng.uniform(-reach, reach, (2, n, 1, 1))
    wide = width * rng.uniform(1.0, 4.0, (n, 1, 1))
    dome = np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2 * wide**2))
    kinds = (
        dome,
        edge,
        corner,
        1.0 - corner,
        edge - far,
        (edge - far) * (across - across * beside),
        1.0 - edge + far,
    )
    tilt = rng.normal(0.0, 0.1, (2, 2 * n, 1, 1)) / np.array(pitch)[:, None, None, None]
    planes = rng.normal(0.0, 5.0, (2 * n, 1, 1)) + tilt[0] * x + tilt[1] * y
    tilted = 1.0 + SLOPE * (
        rng.uniform(-1, 1, (n, 1, 1)) * x / pitch[0] + rng.uniform(-1, 1, (n, 1, 1)) * y / pitch[1]
    )
    return np.concatenate([*(kind * tilted for kind in kinds), planes]).reshape(-1, 25)

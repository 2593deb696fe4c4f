"""When a tracked edge has come round: it runs by its own start again.

Where the start lies in a corner, the first few ticks turn quickly and the edge never comes by there in the same
direction; so a second start, some way on, does as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numba

from exploration.control.edge_ticks import EdgeTick, placed
from primitives.arrays import Floats


@dataclass(frozen=True)
class ClosingConfig:
    """What it is to come by."""

    aside: float = 2.0  # [mm] at most
    overlap: float = 3.0  # [mm] past its start that a closed edge is followed
    least_loop: float = 25.0  # [mm]
    second: float = 12.0  # [mm] from the first start to the second
    same_way: float = 0.8  # least cosine between the directions


@dataclass(frozen=True)
class Home:
    """Where an outline, or one of its edges, began."""

    point: Floats  # (3,) [mm]
    tangent: Floats  # (3,) unit direction of travel
    after: float = 0.0  # [mm] along the edge that may come by there, from which it does


def comes_by(homes: Sequence[Home], tick: EdgeTick, travel: float, config: ClosingConfig) -> int | None:
    """Which of some places the edge, followed for `travel` [mm], runs by now, a little way past it; or None."""
    for k, home in enumerate(homes):
        if travel >= home.after and _runs_by(home.point, home.tangent, tick, config):
            return k
    return None


def came_round(ticks: Sequence[EdgeTick], second: int, travel: float, config: ClosingConfig) -> int | None:
    """The tick that the edge has come back to after `travel` [mm]: the first, the `second` start's, or None."""
    for start, gone in ((0, 0.0), (second, config.second)):
        if travel - gone > config.least_loop:
            begun = ticks[start]
            if _runs_by(begun.point, begun.tangent, ticks[-1], config):
                return start
    return None


def _runs_by(point: Floats, tangent: Floats, tick: EdgeTick, config: ClosingConfig) -> bool:
    return bool(
        _past(
            tick.edge.parameters,
            tick.world_from_sensor,
            point,
            tangent,
            config.overlap,
            config.aside,
            config.same_way,
        )
    )


@numba.njit(cache=True, error_model="numpy")
def _past(
    parameters: Floats,
    pose: Floats,
    point: Floats,
    tangent: Floats,
    overlap: float,
    aside: float,
    same_way: float,
) -> bool:
    """Whether a tick lies `overlap` to three times as far past a point, beside it by less than `aside`."""
    now, way = placed(parameters, pose)
    square = past = cosine = 0.0
    for i in range(3):
        gap = now[i] - point[i]
        square += gap * gap
        past += gap * tangent[i]
        cosine += way[i] * tangent[i]
    beside = square - past * past
    return overlap < past < 3.0 * overlap and beside < aside * aside and cosine > same_way

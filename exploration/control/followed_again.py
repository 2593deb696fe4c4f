"""A track's frames followed once more, from the first to the last, as while it was tracked.

What its images no longer show (`deaf_taxels`) had moved every edge, and through the filtered bend those after it.
"""

from collections.abc import Sequence
from dataclasses import replace

from exploration.control.edge_servo import EdgeServoConfig, expected_next
from exploration.control.edge_ticks import EdgeTick
from exploration.sensing.lines.follow_line import follow_line
from exploration.sensing.lines.followed import Expected
from exploration.sensing.response import Response

BEND_SIGMA = 0.02  # [1/mm] to which the first frame's bend is expected


def followed_again(
    ticks: Sequence[EdgeTick], response: Response, config: EdgeServoConfig, period: float
) -> list[EdgeTick]:
    """The ticks whose edge is found again, one every `period` [s]; where their faces end is not asked again."""
    out: list[EdgeTick] = []
    for tick in ticks:
        was = tick.edge
        expected = Expected(was.angle, was.offset, was.side, was.bend, BEND_SIGMA, config.reach)
        if out:
            last = out[-1]
            expected = expected_next(
                last.edge, last.world_from_sensor, tick.world_from_sensor, config, period
            )
        edge = follow_line(tick.image, response, expected)
        if edge:
            out.append(replace(tick, edge=replace(edge, ends=was.ends)))
    return out

"""The edge that a tracker takes up: of the lines and arcs that a frame shows, the one that runs its way."""

import numpy as np

from exploration.control.edge_servo import EdgeServoConfig
from exploration.control.feel import feel
from exploration.devices.guard import Observation
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.followed import Expected
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.outline import find_outline
from primitives.arrays import Floats


def first_expected(seen: Observation, along: Floats, config: EdgeServoConfig) -> Expected | None:
    """The line or arc that runs most nearly along a (3,) world direction and under the pad's middle.

    Where a curved face ends by itself and where by its edge is hard to tell in a frame: such an edge is expected
    where the pad was laid beside it.
    """
    heading = seen.world_from_sensor[:3, :2].T @ along
    heading = heading / max(float(np.linalg.norm(heading)), 1e-9)
    outline = find_outline(seen.image, 3)
    found = [expected_of(line, heading, config) for line in (*outline.lines, *sure_lines(seen.image, 3))]
    found += [expected_on(arc, heading, config) for arc in outline.arcs]
    fitting = [e for e in found if np.cos(e.angle) * heading[0] + np.sin(e.angle) * heading[1] > 0.7]
    if not fitting and any(config.curvatures):
        return expected_beside(seen, heading, config)
    return min(fitting, key=lambda e: abs(e.offset), default=None)


def expected_beside(seen: Observation, heading: Floats, config: EdgeServoConfig) -> Expected | None:
    """The edge of a pad that lies beside it, the way of a (2,) heading; its material where contact is."""
    felt = feel(seen.image)
    if not felt:
        return None
    side = 1 if float(felt.centroid @ np.array([-heading[1], heading[0]])) > 0.0 else -1
    angle = float(np.arctan2(heading[1], heading[0]))
    return Expected(angle, -side * config.inside, side, bend_sigma=0.02, reach=config.reach)


def expected_on(arc: Arc, heading: Floats, config: EdgeServoConfig) -> Expected:
    """An arc beside the pad's center, directed the way of a (2,) heading."""
    away = -arc.center / max(
        float(np.linalg.norm(arc.center)), 1e-9
    )  # from the center of the arc to the pad's
    foot = arc.center + arc.radius * away
    direction = np.array([-away[1], away[0]])
    direction = direction * (1.0 if direction @ heading > 0 else -1.0)
    normal = np.array([-direction[1], direction[0]])
    inward = -away if arc.material_inside else away
    return Expected(
        float(np.arctan2(direction[1], direction[0])),
        float(foot @ normal),
        1 if float(inward @ normal) > 0 else -1,
        bend=(1.0 if arc.material_inside else -1.0) / arc.radius,
        bend_sigma=0.02,
        reach=min(config.reach, config.sharpest * arc.radius),
    )


def expected_of(line: Line, heading: Floats, config: EdgeServoConfig) -> Expected:
    """A line, directed the way of a (2,) heading, as what the next frame should show."""
    ahead = bool(line.direction @ heading > 0)
    return Expected(
        line.angle if ahead else line.angle + np.pi,
        line.offset if ahead else -line.offset,
        line.material_side if ahead else -line.material_side,
        bend_sigma=0.02,
        reach=config.reach,
    )

"""Edge tracking: servo on one line of the tactile image.

With e the pad center's distance inside the material and a the line's angle from the pad's long axis,
``v = speed * t + gain_e (e0 - e) n`` and ``w_z = gain_a a`` keep the edge under the pad's middle and along its
long side; force and tilt are the hybrid law's.  Tracking ends at a corner, where the line ends ahead of the
center; where it comes back to its start; or where it is lost.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from exploration.control.feel import feel
from exploration.control.servo import ServoGains, hybrid_twist
from exploration.devices.guard import Guard, Observation
from exploration.sensing.edges import edge_points
from exploration.sensing.hough import find_lines
from exploration.sensing.line import Line
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

Ended = Literal["corner", "closed", "lost", "length"]


@dataclass(frozen=True)
class EdgeConfig:
    """How an edge is tracked."""

    speed: float = 20.0  # [mm/s]
    inside: float = 1.0  # [mm] of the pad's center within the material
    gain_offset: float = 6.0  # [1/s]
    gain_angle: float = 6.0  # [1/s]
    spacing: float = 1.5  # [mm] between trace points
    window: float = 4.0  # [mm] along the edge, of the crossings that make a trace point
    corner: float = 2.5  # [mm] of line ahead of the center, below which it has ended
    closing: float = 2.0  # [mm]
    least_loop: float = 25.0  # [mm]
    patience: int = 10  # frames without the line
    every: int = 3  # ticks between looks for the line; between them it is held in place


@dataclass(frozen=True)
class Tracked:
    """What a tracked edge yielded; false where nothing was."""

    trace: EdgeTrace | None
    ended: Ended
    travel: float  # [mm]

    def __bool__(self) -> bool:
        return self.trace is not None


def follow_edge(
    guard: Guard,
    along: Floats,
    length: float,
    touch: int,
    stroke: int,
    gains: ServoGains = ServoGains(),
    config: EdgeConfig = EdgeConfig(),
) -> Tracked:
    """Track the edge under the pad, the way of the (3,) world direction `along`, up to `length` [mm]."""
    points: list[Floats] = []
    tangents: list[Floats] = []
    normals: list[Floats] = []
    heading = guard.world_from_sensor[:3, :2].T @ along
    rest = 0.0 if heading[0] >= 0 else np.pi
    travel, since, missing, age = 0.0, np.inf, 0, 0
    line: Line | None = None
    ended: Ended = "length"
    seen = guard.hold()
    at = seen.world_from_sensor
    while travel < length:
        felt = feel(seen.image)
        if age == 0 and felt:
            line = _expected(find_lines(seen.image, 2), heading)
        age = (age + 1) % config.every
        if line is None or not felt:
            missing += 1
            if missing > config.patience:
                ended = "lost"
                break
            age = 0
            seen = guard.hold()
            continue
        missing = 0
        heading = line.direction if line.direction @ heading > 0 else -line.direction
        if since >= config.spacing:
            since = 0.0
            found = _trace_point(line, heading, seen, config)
            if found is not None:
                turn = seen.world_from_sensor[:3, :3]
                points.append(found)
                tangents.append(turn[:, :2] @ heading)
                normals.append(-turn[:, 2])
        if max(float(line.start @ heading), float(line.end @ heading)) < config.corner:
            ended = "corner"
            break
        if travel > config.least_loop and points and _returned(points, tangents, config):
            ended = "closed"
            break
        inside = float(line.distance(np.zeros((1, 2)))[0])
        aside = np.clip(config.gain_offset * (config.inside - inside), -config.speed, config.speed)
        angle = (np.arctan2(heading[1], heading[0]) - rest + np.pi) % (2.0 * np.pi) - np.pi
        seen = guard.move(
            hybrid_twist(
                felt.depth,
                felt.slope,
                felt.centroid,
                config.speed * heading + aside * line.inward,
                turn=float(np.clip(config.gain_angle * angle, -1.5, 1.5)),
                gains=gains,
            )
        )
        moved = seen.world_from_sensor
        heading = moved[:3, :2].T @ (at[:3, :2] @ heading)
        step = float(np.linalg.norm(moved[:3, 3] - at[:3, 3]))
        at, travel, since = moved, travel + step, since + step
    return Tracked(_trace(points, tangents, normals, ended == "closed", touch, stroke), ended, travel)


def _expected(lines: tuple[Line, ...], heading: Floats) -> Line | None:
    """The line that runs on most nearly along `heading` and under the pad's middle."""
    fitting = [line for line in lines if abs(float(line.direction @ heading)) > 0.8]
    return min(fitting, key=lambda line: abs(line.offset), default=None)


def _trace_point(line: Line, heading: Floats, seen: Observation, config: EdgeConfig) -> Floats | None:
    """The edge beside the pad's center, from the crossings there rather than from the whole line.

    A straight line fitted across the pad cuts a curved edge short; crossings within a few mm do not.
    """
    found = edge_points(seen.image)
    foot = line.offset * line.normal
    if len(found):
        along = (found.points - foot) @ heading
        off = line.distance(found.points)
        near = (np.abs(along) < config.window) & (np.abs(off) < 1.5)
        if near.any():
            weight = 1.0 / found.sigma[near] ** 2
            foot = foot + line.inward * float(np.average(off[near], weights=weight))
    turn, origin = seen.world_from_sensor[:3, :3], seen.world_from_sensor[:3, 3]
    point: Floats = turn @ np.array([foot[0], foot[1], -line.plateau]) + origin
    return point


def _returned(points: list[Floats], tangents: list[Floats], config: EdgeConfig) -> bool:
    near = float(np.linalg.norm(points[-1] - points[0])) < config.closing
    return near and float(tangents[-1] @ tangents[0]) > 0.8


def _trace(
    points: list[Floats], tangents: list[Floats], normals: list[Floats], closed: bool, touch: int, stroke: int
) -> EdgeTrace | None:
    if len(points) < 2:
        return None
    return EdgeTrace(
        frozen(points),
        frozen(tangents),
        frozen(normals),
        frozen(np.full(len(points), 0.1)),
        closed,
        touch,
        stroke,
    )

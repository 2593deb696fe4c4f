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
from exploration.devices.guard import Guard
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import edge_points
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.line import Line
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
    window: float = 6.0  # [mm] along the edge, of the crossings that make a trace point
    ahead: float = 3.5  # [mm] ahead and inside, where material must go on
    share: float = 0.4  # of the plateau, below which it does not
    beside: float = 3.0  # [mm] across the line, within which a crossing is the edge's
    crossings: int = 4  # least number of crossings for a direction of their own
    closing: float = 2.0  # [mm]
    least_loop: float = 25.0  # [mm]
    confirm: int = 6  # ticks in a row that must show the corner
    patience: int = 10  # frames without the line
    every: int = 12  # ticks between looks for the line; between them it is held in place


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
    travel, since, missing, age, ended_ahead = 0.0, np.inf, 0, 0, 0
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
        heading, foot = _beside_center(line, heading, seen.image, config)
        if since >= config.spacing:
            since = 0.0
            turn = seen.world_from_sensor[:3, :3]
            points.append(turn @ np.array([*foot, -line.plateau]) + seen.world_from_sensor[:3, 3])
            tangents.append(turn[:, :2] @ heading)
            normals.append(-turn[:, 2])
        ended_ahead = ended_ahead + 1 if _ends_ahead(line, heading, foot, seen.image, config) else 0
        if ended_ahead > config.confirm:
            ended = "corner"
            break
        if travel > config.least_loop and points and _returned(points, tangents, config):
            ended = "closed"
            break
        inside = -float(foot @ line.inward)
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


def _beside_center(
    line: Line, heading: Floats, image: TactileImage, config: EdgeConfig
) -> tuple[Floats, Floats]:
    """The edge's direction and its (2,) point beside the pad's center, from the crossings there.

    A straight line fitted across the pad cuts a curved edge short; crossings within a few mm do not.
    """
    direction = line.direction if line.direction @ heading > 0 else -line.direction
    foot = line.offset * line.normal
    found = edge_points(image)
    if len(found):
        near = (np.abs((found.points - foot) @ direction) < config.window) & (
            np.abs(line.distance(found.points)) < config.beside
        )
        if int(near.sum()) >= config.crossings:
            points = found.points[near]
            foot = np.average(points, axis=0, weights=found.sigma[near] ** -2.0)
            along = np.linalg.eigh(np.cov(points.T))[1][:, 1]
            along = along if along @ heading > 0 else -along
            direction = along if along @ direction > 0.7 else direction
            foot = foot - (foot @ direction) * direction
    return direction, foot


def _ends_ahead(line: Line, heading: Floats, foot: Floats, image: TactileImage, config: EdgeConfig) -> bool:
    """Whether the material beside the edge ends a little ahead, as it does at a corner."""
    at = foot + config.ahead * heading + config.ahead * line.inward
    column = int(
        np.clip(np.round((at[0] - image.array.x[0]) / image.array.pitch[0]), 1, image.array.columns - 2)
    )
    row = int(np.clip(np.round((at[1] - image.array.y[0]) / image.array.pitch[1]), 1, image.array.rows - 2))
    felt = float(image.depth[row - 1 : row + 2, column - 1 : column + 2].mean())
    return felt < config.share * line.plateau


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

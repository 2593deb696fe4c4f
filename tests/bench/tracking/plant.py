"""The plant of the tracking benchmarks: 5 % noise, 200 Hz, a stage that obeys 20 ms late and reads its pose badly.

The rows of the array are scanned one after another, over most of a period.
The tracker is told nothing of it: latency is measured by a shake in free air before each track.
"""

from dataclasses import dataclass, replace

import numpy as np

from exploration.control.latency import measure_latency
from exploration.control.sighting import Sighting
from exploration.control.track_edge import EdgeConfig, Tracked, follow_edge
from exploration.control.track_outline import TrackedOutline, follow_outline
from exploration.devices.guard import Guard
from exploration.devices.simulated import PoseNoise, simulate
from exploration.planning.moves.edge_from_face import dihedral, pressed
from exploration.planning.touching.pad import Pad
from exploration.sensing.calibration import Calibration
from exploration.sensing.response import rubber
from exploration.sensing.spec import load_sensor
from models.solid import Solid
from primitives.evidence import EdgeTrace
from primitives.pose import pose
from recognition.tracking.falling_face import set_back

NOISE = 0.05  # of the full-contact signal
SCAN = 0.004  # [s] from the first row to the last
LATE = 0.02  # [s]
POSE_NOISE = PoseNoise(0.05, 0.02, 0.0, np.radians(0.02))
PRESS = 0.5  # [mm]
INSIDE = 1.0  # [mm] of the pad's center within the material
BOX = np.array([-200.0, -200, -200, 200, 200, 200])
LTS = load_sensor("lts210")
SPEC = replace(LTS, electronics=replace(LTS.electronics, noise=NOISE, scan=SCAN))


@dataclass(frozen=True)
class Start:
    """A place on an edge: the point, unit directions along it, outward in the face, and the face's normal."""

    point: np.ndarray
    along: np.ndarray
    outward: np.ndarray
    normal: np.ndarray


def guard_over(solid: Solid, start: Start, seed: int) -> Guard:
    """A guard whose pad is pressed on the face beside the edge, and which has measured its latency in the air."""
    turn = np.stack([start.along, np.cross(-start.normal, start.along), -start.normal], axis=1)
    place = start.point - INSIDE * start.outward - PRESS * start.normal
    above = pose(turn, place + 8.0 * start.normal)
    stage, arrays = simulate(
        solid, [SPEC], np.random.default_rng(seed), pose_noise=POSE_NOISE, start_pose=above, latency=LATE
    )
    guard = Guard(stage, arrays, [Calibration.nominal(SPEC)])
    guard.pending.latency = measure_latency(guard).seconds
    guard.go_to(pose(turn, place))
    guard.hold(5)
    return guard


def tracked(guard: Guard, start: Start, length: float, speed: float) -> Tracked:
    """An edge followed, for `length` [mm]."""
    return follow_edge(guard, start.along, length, 0, 0, config=EdgeConfig(speed=speed))


def with_dihedral(guard: Guard, trace: EdgeTrace) -> tuple[EdgeTrace, float | None]:
    """The trace, set back by the dihedral angle [rad] that is felt behind its middle."""
    k = len(trace.points) // 2
    outward = np.cross(trace.tangents, trace.normals)
    at = Sighting(trace.points[k], trace.tangents[k], outward[k], trace.normals[k], 0.02, 50.0)
    at = replace(at, tangent=np.cross(at.outward, at.normal))
    pad = Pad(guard, BOX, lambda kind, detail: None)
    press = pressed(pad) or PRESS
    pad.lie(np.empty((0, 3)))
    angle = dihedral(pad, at)
    if angle is None:
        return trace, None
    response = rubber(SPEC.elastomer.spread, SPEC.array.pitch)
    return set_back(trace, outward, angle, press, response, response.mean_width), angle


def outlined(guard: Guard, start: Start, length: float, speed: float) -> TrackedOutline:
    """An outline followed, round its corners, for at most `length` [mm]."""
    return follow_outline(guard, start.along, length, 0, 0, config=EdgeConfig(speed=speed))

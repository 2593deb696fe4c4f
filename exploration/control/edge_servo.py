"""The law of an edge: along it at a speed, its line under the pad's middle and along the pad's long side.

With e the pad center's distance inside the material, a the angle between the pad's long axis and the edge, and
kappa the edge's bend, all as they will be once the commands still on their way are done,

    v = speed t + gain_e (e0 - e) inward,      w_z = gain_a a + speed kappa,

and press and level are the hybrid law's: the force that the nominal press makes on the area in contact, the pad
flat on the face.
"""

from dataclasses import dataclass
from math import sqrt

import numba
import numpy as np

from exploration.control.hybrid import PRESS_AND_LEVEL, HybridGains, HybridState, commanded
from exploration.devices.guard import Guard, Observation
from exploration.sensing.lines.followed import Expected, Followed
from primitives.arrays import Bools, Floats

AREA_SHARE = 0.05  # of each tick, in the mean area in contact


@dataclass(frozen=True)
class EdgeServoConfig:
    """How an edge is kept under the pad."""

    speed: float = 20.0  # [mm/s]
    inside: float = 1.0  # [mm] of the pad's center within the material
    gain_offset: float = 6.0  # [1/s]
    gain_angle: float = 6.0  # [1/s]
    turn: float = 1.6  # [rad/s] at most
    level_sigma: float = 0.03  # slope known worse than this levels nothing
    least_area: float = 20.0  # [mm^2] the force of a smaller contact is not a press error
    reach: float = 10.0  # [mm] of the edge, either way, that one frame is fitted to
    sharpest: float = 0.8  # [rad] of a bent edge that one frame is fitted to, either way
    bend_drift: float = 0.02  # [1/mm] by which the bend may change within a mm
    curvatures: tuple[float, float] = (0.0, 0.0)  # [1/mm] of the face, along the edge and across it


class EdgeServo:
    """One track's controller."""

    def __init__(self, guard: Guard, press: float, config: EdgeServoConfig, rest: float) -> None:
        """`press` [mm] is the nominal; the pad's x axis is held `rest` [rad], 0 or pi, from the edge."""
        self.guard, self.press, self.config = guard, press, config
        self.wanted: list[float] = []  # [N] at every tick
        self._gains = HybridGains.for_delay(guard.period, guard.pending.latency).all
        self._integral = HybridState().integral
        self._area = 0.0  # [mm^2]
        self._curves = any(config.curvatures)
        self._law = (
            config.speed,
            config.inside,
            config.gain_offset,
            config.gain_angle,
            config.turn,
            config.level_sigma**2,
            rest,
        )

    def rest(self) -> None:
        """The pad has been standing, or was moved by another."""
        self._integral = HybridState().integral

    def want(self, seen: Observation, edge: Followed) -> None:
        """Take down the force that the nominal press makes on what is in contact.

        Of a curved face less lies within the pad's reach, and its end is less sure: it is averaged.
        """
        share = AREA_SHARE if self.wanted and self._curves else 1.0
        self._area += share * (edge.area - self._area)
        self.wanted.append(self.press * seen.image.stiffness * self._area)

    def twist(self, seen: Observation, edge: Followed) -> Floats:
        """The (6,) twist of this tick, aimed from where the pad will be when it is obeyed."""
        missing = self.wanted[-1] - seen.force
        soon = self.guard.pending.motion(seen.time)
        twist, self._integral = _aimed(
            self._curved(edge, soon),
            edge.covariance,
            float(edge.side),
            edge.centroid,
            missing / (seen.image.stiffness * max(edge.area, self.config.least_area)),
            soon,
            self._law,
            self._integral,
            self.guard.period,
            self._gains,
            PRESS_AND_LEVEL,
        )
        if self._curves:
            turn = self._turning(edge, twist[:2])
            twist[3] += turn[1]
            twist[4] -= turn[0]
        out: Floats = twist
        return out

    def _curved(self, edge: Followed, soon: Floats) -> Floats:
        """(6,) parameters of the edge, its slopes as a curved face has them after the (4, 4) motion `soon`."""
        if not self._curves:
            return edge.parameters
        turn = self._turning(edge, soon[:2, 3])
        p = edge.parameters.copy()
        p[3] -= turn @ edge.inward
        p[4] -= turn @ edge.direction
        return p

    def _turning(self, edge: Followed, gone: Floats) -> Floats:
        """(2,) [rad] or [rad/s] by which the face's normal turns where the pad goes (2,) [mm] or [mm/s]."""
        along, across = self.config.curvatures
        turn: Floats = (
            along * (edge.direction @ gone) * edge.direction + across * (edge.inward @ gone) * edge.inward
        )
        return turn

    def expected(self, edge: Followed, before: Floats, after: Floats) -> Expected:
        """The edge as the pad should see it after its move from one (4, 4) pose to another."""
        return expected_next(edge, before, after, self.config, self.guard.period)


def expected_next(
    edge: Followed, before: Floats, after: Floats, config: EdgeServoConfig, period: float
) -> Expected:
    """The edge as the pad should see it after its move from one (4, 4) pose to another, in a `period` [s]."""
    angle, offset = _carried(edge.angle, edge.offset, before, after)
    sigma = sqrt(max(edge.covariance[5, 5], 0.0) + config.bend_drift**2 * config.speed * period)
    reach = min(config.reach, config.sharpest / max(abs(edge.bend), 1e-6))
    return Expected(angle, offset, edge.side, edge.bend, sigma, reach)


@numba.njit(cache=True, error_model="numpy")
def _aimed(
    p: Floats,
    covariance: Floats,
    side: float,
    centroid: Floats,
    missing: float,
    soon: Floats,
    law: tuple[float, float, float, float, float, float, float],
    integral: tuple[float, float, float],
    period: float,
    gains: tuple[float, float, float, float],
    selection: Bools,
) -> tuple[Floats, tuple[float, float, float]]:
    """The (6,) twist for an edge of (6,) parameters `p`, the pad having gone on by the (4, 4) motion `soon`."""
    speed, inside, gain_offset, gain_angle, most, doubt, rest = law
    ca, sa = np.cos(p[0]), np.sin(p[0])
    tx = soon[0, 0] * ca + soon[1, 0] * sa
    ty = soon[0, 1] * ca + soon[1, 1] * sa
    out_x, out_y = side * ty, -side * tx
    off_x, off_y = -sa * p[1] - soon[0, 3], ca * p[1] - soon[1, 3]
    foot_x = soon[0, 0] * off_x + soon[1, 0] * off_y
    foot_y = soon[0, 1] * off_x + soon[1, 1] * off_y
    slope = np.zeros(2)
    if covariance[3, 3] <= doubt and covariance[4, 4] <= doubt:
        slope[0] = -out_x * p[3] + tx * p[4] - soon[0, 2]
        slope[1] = -out_y * p[3] + ty * p[4] - soon[1, 2]
    angle = (np.arctan2(ty, tx) - rest + np.pi) % (2.0 * np.pi) - np.pi
    speed = min(speed, 0.75 * most / max(abs(p[5]), 1e-3))
    aside = gain_offset * (inside - foot_x * out_x - foot_y * out_y)
    aside = max(-speed, min(speed, aside))
    wish = np.zeros(6)
    wish[0], wish[1] = speed * tx - aside * out_x, speed * ty - aside * out_y
    wish[5] = max(-most, min(most, gain_angle * angle + speed * p[5] * side))
    found: tuple[Floats, tuple[float, float, float]] = commanded(
        integral, missing - soon[2, 3], slope, centroid, wish, period, gains, selection
    )
    return found


@numba.njit(cache=True, error_model="numpy")
def _carried(angle: float, offset: float, before: Floats, after: Floats) -> tuple[float, float]:
    """Angle and offset of a line of the pad's plane after the pad's move."""
    ca, sa = np.cos(angle), np.sin(angle)
    along, foot = np.zeros(2), np.zeros(2)
    for i in range(3):
        direction = before[i, 0] * ca + before[i, 1] * sa
        place = before[i, 3] - after[i, 3] + offset * (before[i, 1] * ca - before[i, 0] * sa)
        for k in range(2):
            along[k] += after[i, k] * direction
            foot[k] += after[i, k] * place
    turned = np.arctan2(along[1], along[0])
    return turned, foot[1] * np.cos(turned) - foot[0] * np.sin(turned)

"""Four-direction curvature by motion: strokes through a contact at 0, 45, 90 and 135 degrees.

Along a stroke the surface's normal turns, in the stroke's own plane, by theta(s) = the pad's turning, less the
slope that the pad still feels under its center; theta = a + kappa s + c s^2 / 2 is fitted.  White noise sigma on n
ticks over a length L costs sigma sqrt(12 / n) / L, some hundredth of what one frame does.  The frames' own
curvature along the stroke is fused with it by inverse variance.  The four readings give the principal curvatures,
a test of redundancy and the order (`primitives.curvature`).

A cone is told from a cylinder by 1/k1 = s tan(alpha), linear along its generator: the curvatures k that the
frames felt at places u along it are fitted by 1 / (a + b u); with b = tan(alpha) drawn from N(0, v) before touch,
if it is a cone, the evidence for one is  b^2 v / (2 s^2 (v + s^2)) - ln(1 + v / s^2) / 2,  s the error of b (our
derivation).

Property class: structural (exact shape).
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import dist

import numpy as np

from exploration.control.procedures.approach import retreat
from exploration.control.surface_reading import SurfaceReading
from exploration.control.surface_trace import travel_of
from exploration.control.track_surface import StrokeConfig, follow_surface
from exploration.devices.guard import Guard
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.curvature import ORDERS, FourCurvatures, from_four, name_order

SERVES = "structural: exact shape"
LIFT = 15.0  # [mm] over the contact, on a way back
DIRECTIONS = np.radians([0.0, 45.0, 90.0, 135.0])


@dataclass(frozen=True)
class StrokeCurvatureConfig:
    """The strokes, and errors that their noise does not show."""

    length: float = 20.0  # [mm] of a stroke
    speed: float = 30.0  # [mm/s]
    least: float = 8.0  # [mm] of a stroke that is worth a reading
    ticks: int = 20  # of it
    tries: int = 2  # of each: noise may pass for the face's end
    away: float = 2.0  # [mm] from the contact, from which a stroke has not come back
    rest: int = 8  # ticks at the contact, before the first
    near: float = 5.0  # [mm] of the contact, within which frames speak for its curvature
    floor: float = 2e-6  # [1/mm]
    share: float = 0.005  # of the curvature, the same
    frame_floor: float = 3e-5  # [1/mm] of one frame's model
    frame_share: float = 0.01  # of the curvature, the same
    unknown: float = 0.2  # [1/mm] of a direction that could not be stroked
    tangent: float = 0.5  # prior standard deviation of tan(alpha)
    tangent_floor: float = 0.005
    cone_odds: float = 0.15  # of a cone to a cylinder, before touch; by area among the built-in parts: 0.16


@dataclass(frozen=True)
class StrokeCurvature:
    """The surface under the contact, by the turning of its normal; false where no stroke could be made."""

    four: FourCurvatures
    order: str  # of `primitives.curvature.ORDERS`
    probability: float
    type: str  # plane, cylinder, cone, sphere or other
    type_probability: float
    tangent: float  # tan of a cone's half-angle, with sign; 0 where not tried
    tangent_sigma: float
    strokes: int  # that could be made

    def __bool__(self) -> bool:
        return self.strokes > 0

    @property
    def radius(self) -> tuple[float, float]:
        """[mm] of the sharpest normal section, and its sigma; a ball's is the mean of all four."""
        if self.order == "sphere":
            k, sigma = (
                float(self.four.components[0, 0]),
                float(np.sqrt(self.four.components_covariance[0, 0, 0])),
            )
        else:
            k, sigma = float(self.four.k1[0]), float(np.sqrt(self.four.covariance[0, 0, 0]))
        if self.order == "plane" or abs(k) < 1e-9:
            return np.inf, np.inf
        return 1.0 / k, sigma / k**2


def stroke_curvature(
    guard: Guard, touch: int = 0, stroke: int = 0, config: StrokeCurvatureConfig = StrokeCurvatureConfig()
) -> StrokeCurvature:
    """From a flush contact, stroke it in four directions and come back to it each time."""
    here = guard.world_from_sensor
    home = np.mean([guard.hold().world_from_sensor[:3, 3] for _ in range(config.rest)], axis=0)
    place = se3.pose(here[:3, :3], home)
    readings, sigmas, runs = [], [], []
    for angle in DIRECTIONS:
        heading, run = np.array([np.cos(angle), np.sin(angle)]), None
        for _ in range(config.tries):
            run = run or _there_and_back(guard, heading, place, touch, stroke, config)
        kappa, sigma = (0.0, config.unknown) if run is None else curvature_along(run, config)
        readings.append(kappa)
        sigmas.append(sigma)
        if run is not None:
            runs.append(run)
    missing = [i for i, sigma in enumerate(sigmas) if sigma >= config.unknown]
    if len(missing) == 1:
        readings[missing[0]], sigmas[missing[0]] = _by_redundancy(readings, sigmas, missing[0])
    most = max(abs(k) for k in readings)
    known = np.hypot(np.array(sigmas), config.share * most)
    k0, k45, k90, k135 = readings
    four = from_four(k0, k45, k90, k135, known[None])
    chances = name_order(four)[0]
    order = ORDERS[int(np.argmax(chances))]
    found, tangent, sigma = (float(chances.max()), 0.0, np.inf)
    kind = "sphere" if order == "sphere" else "other" if order == "other" else "plane"
    if order == "cylinder or cone":
        tangent, sigma = cone_tangent(runs, float(four.theta[0]), float(four.k1[0]), config)
        cone = _cone_probability(tangent, sigma, config)
        kind, found = ("cone", found * cone) if cone > 0.5 else ("cylinder", found * (1.0 - cone))
    return StrokeCurvature(four, order, float(chances.max()), kind, found, tangent, float(sigma), len(runs))


def _there_and_back(
    guard: Guard, heading: Floats, place: Floats, touch: int, stroke: int, config: StrokeCurvatureConfig
) -> "Run | None":
    """One stroke through a (4, 4) place where the pad lies, and back to it."""
    told = replace(StrokeConfig(), speed=config.speed, spacing=np.inf)
    coast = config.speed * guard.pending.latency
    back = follow_surface(guard, -heading, config.length / 2.0 - coast, touch, stroke, config=told).travel
    length = back + config.length / 2.0 - coast
    there = follow_surface(guard, heading, length, touch, stroke, config=told)
    follow_surface(guard, -heading, max(there.travel - back - coast, 0.0), touch, stroke, config=told)
    if dist(guard.world_from_sensor[:3, 3], place[:3, 3]) > config.away:  # one of them ended early
        retreat(guard, LIFT)
        guard.go_to(place @ se3.pose(translation=[0.0, 0.0, -LIFT]))
        guard.go_to(place)
    return run_of(list(there.readings), heading, place[:3, 3], config)


def _by_redundancy(readings: list[float], sigmas: list[float], missing: int) -> tuple[float, float]:
    """The reading and its sigma that k0 + k90 = k45 + k135 leaves for a direction that could not be stroked."""
    opposite, beside = (missing + 2) % 4, [(missing + 1) % 4, (missing + 3) % 4]
    others = [opposite, *beside]
    kappa = readings[beside[0]] + readings[beside[1]] - readings[opposite]
    return kappa, float(np.sqrt(sum(sigmas[i] ** 2 for i in others)))


@dataclass(frozen=True)
class Run:
    """One stroke through the contact."""

    heading: Floats  # (2,)
    travel: Floats  # (n,) [mm] from the contact
    angle: Floats  # (n,) [rad] of the normal, in the stroke's plane
    hessians: Floats  # (n, 3) [1/mm] kxx, kxy, kyy of each frame
    covariances: Floats  # (n, 3, 3)


def run_of(
    readings: list[SurfaceReading], heading: Floats, home: Floats, config: StrokeCurvatureConfig
) -> Run | None:
    """Travel and turning of a stroke through (3,) `home` [mm]; None of too few ticks."""
    readings = [r for r in readings if r.whole]
    if len(readings) < config.ticks:
        return None
    travel = travel_of(readings, heading)
    turns = [r.world_from_sensor[:3, :3] for r in readings]
    steps = [se3.rotation_log(a.T @ b) for a, b in pairwise(turns)]
    pitch = np.array([w[0] * heading[1] - w[1] * heading[0] for w in steps])
    slopes = np.array([r.slope @ heading for r in readings])
    angle = np.concatenate([[0.0], np.cumsum(pitch)]) - np.arctan(slopes)
    return Run(
        heading,
        travel - _passing(readings, travel, heading, home),
        angle,
        np.array([r.coefficients[3:6] for r in readings]),
        np.array([r.covariance[3:6, 3:6] for r in readings]),
    )


def _passing(readings: list[SurfaceReading], travel: Floats, heading: Floats, home: Floats) -> float:
    """[mm] of travel at which a stroke passes nearest to home."""
    ahead = np.array(
        [(home - r.world_from_sensor[:3, 3]) @ (r.world_from_sensor[:3, :2] @ heading) for r in readings]
    )
    near = np.argsort(np.abs(ahead))[:10]
    return float(np.mean(travel[near] + ahead[near]))


def curvature_along(run: Run, config: StrokeCurvatureConfig) -> tuple[float, float]:
    """Normal curvature at the contact and its standard deviation [1/mm], by motion and by the frames near it."""
    s = run.travel
    if np.ptp(s) < config.least:
        return 0.0, config.unknown
    basis = np.stack([np.ones_like(s), s, 0.5 * s**2], axis=1)
    fitted, *_ = np.linalg.lstsq(basis, run.angle, rcond=None)
    residual = run.angle - basis @ fitted
    variance = float(residual @ residual) / max(1, len(s) - 3) * float(np.linalg.inv(basis.T @ basis)[1, 1])
    moved, precision = float(fitted[1]), 1.0 / (variance + config.floor**2)
    near = np.abs(s) < config.near
    h = run.heading
    along = np.array([h[0] ** 2, 2.0 * h[0] * h[1], h[1] ** 2])
    felt, count = run.hessians[near] @ along, int(near.sum())
    if count < 2:
        return moved, float(precision**-0.5)
    spread = float(np.mean(along @ run.covariances[near] @ along)) / count
    mean = float(felt.mean())
    other = 1.0 / (spread + config.frame_floor**2 + (config.frame_share * mean) ** 2)
    total = precision + other
    return (precision * moved + other * mean) / total, float(total**-0.5)


def cone_tangent(
    runs: list[Run], theta: float, k1: float, config: StrokeCurvatureConfig
) -> tuple[float, float]:
    """The b of k = 1 / (a + b u) along the generator, and its standard deviation, by Gauss and Newton's steps.

    k is the trace of a frame's Hessian, which turning about the normal leaves as it is.
    """
    generator = np.array([-np.sin(theta), np.cos(theta)])
    u = np.concatenate([run.travel * float(run.heading @ generator) for run in runs])
    k = np.concatenate([run.hessians[:, 0] + run.hessians[:, 2] for run in runs])
    both = np.array([1.0, 0.0, 1.0])
    sigma = np.sqrt(np.concatenate([both @ run.covariances @ both for run in runs]))
    a, b = 1.0 / max(k1, 1e-6), 0.0
    spread = np.inf
    for _ in range(12):
        model = 1.0 / np.maximum(a + b * u, 0.1 * a)
        jacobian = -(model**2)[:, None] * np.stack([np.ones_like(u), u], axis=1) / sigma[:, None]
        information = jacobian.T @ jacobian
        step = np.linalg.solve(information, jacobian.T @ ((k - model) / sigma))
        a, b = max(a + float(step[0]), 1e-3), b + float(step[1])
        spread = float(np.sqrt(np.linalg.inv(information)[1, 1]))
    return b, float(np.hypot(spread, config.tangent_floor))


def _cone_probability(tangent: float, sigma: float, config: StrokeCurvatureConfig) -> float:
    v, s2 = config.tangent**2, sigma**2
    log = 0.5 * tangent**2 * v / (s2 * (v + s2)) - 0.5 * np.log1p(v / s2) + np.log(config.cone_odds)
    return float(1.0 / (1.0 + np.exp(-np.clip(log, -500.0, 500.0))))

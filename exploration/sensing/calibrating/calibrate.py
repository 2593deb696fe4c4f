"""A calibration from frames: free air, then a flat, an edge, a step and weights, as far as they were recorded.

Each part stands on the ones before it; what was not recorded stays as the data sheet has it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.sensing.calibrating.edge import spread_from_edges
from exploration.sensing.calibrating.flat import gains_from_flat
from exploration.sensing.calibrating.rest import mean_frame, rest
from exploration.sensing.calibrating.step import Ratio, counts_per_depth, counts_per_force
from exploration.sensing.calibration import Calibration
from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.response import Response
from primitives.arrays import frozen

Press = Sequence[TaxelFrame]  # frames of one place, the pad at rest there


@dataclass(frozen=True)
class CalibrationFrames:
    """What was recorded."""

    air: Press  # untouched
    flats: Sequence[Press] = ()  # a flat larger than the pad, at several depths and tilts
    edges: Sequence[Press] = ()  # a straight edge across the pad, at several angles
    steps: Sequence[Press] = ()  # over a step, both faces touching
    step_height: float = 0.0  # [mm]
    step_height_sigma: float = 0.0  # [mm]
    weights: Sequence[tuple[Press, float]] = ()  # bodies that lie within the pad, and their forces [N]


def calibrate(
    frames: CalibrationFrames,
    nominal: Calibration,
    array: TaxelArray,
    family: Callable[[float], Response] | None = None,
) -> Calibration:
    """The calibration that the frames tell, starting from the data sheet's.

    Twice: how a flat bends at the skin's end takes the spread, and a curve the true depth, which come later.
    """
    first = _pass(frames, nominal, array, family)
    if not frames.flats:
        return first
    scale = first.gain[~first.dead].mean() / nominal.gain[~first.dead].mean()
    start = replace(
        nominal,
        gain=frozen(nominal.gain * scale),
        spread=first.spread,
        response=first.response,
        stiffness=first.stiffness,
    )
    return _pass(frames, start, array, family)


def _pass(
    frames: CalibrationFrames,
    nominal: Calibration,
    array: TaxelArray,
    family: Callable[[float], Response] | None,
) -> Calibration:
    air = rest(frames.air)
    known = replace(
        nominal, zero=air.zero, noise=air.noise, dead=frozen(nominal.dead | air.restless, np.bool_)
    )
    if frames.flats:
        flat = [mean_frame(press) for press in frames.flats]
        gains = gains_from_flat(flat, known, array, _averaged(frames.flats))
        gain = frozen(known.gain * gains.relative)
        known = replace(known, gain=gain, gain_sigma=gains.sigma, dead=gains.dead)
    if frames.edges:
        edges = [mean_frame(press) for press in frames.edges]
        spread = spread_from_edges(edges, known, array, _averaged(frames.edges), family)
        response = known.response if family is None else family(spread.spread)
        known = replace(known, spread=spread.spread, spread_sigma=spread.sigma, response=response)
    return _scaled(frames, known, array)


def _scaled(frames: CalibrationFrames, known: Calibration, array: TaxelArray) -> Calibration:
    """Counts per N from weights, counts per mm from steps, and the stiffness that these are apart."""
    force = depth = Ratio(1.0, 0.0)
    if frames.weights:
        force = counts_per_force([(mean_frame(press), n) for press, n in frames.weights], known, array)
        known = replace(known, gain=frozen(known.gain * force.value), stiffness=known.stiffness / force.value)
    if not frames.steps:
        return known
    steps = [mean_frame(press) for press in frames.steps]
    depth = counts_per_depth(steps, frames.step_height, known, array, frames.step_height_sigma)
    stiffness = known.stiffness * depth.value
    relative = float(np.hypot(depth.sigma / depth.value, force.sigma / force.value))
    return replace(known, stiffness=stiffness, stiffness_sigma=stiffness * relative)


def _averaged(presses: Sequence[Press]) -> int:
    return min(len(press) for press in presses)

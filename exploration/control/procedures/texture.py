"""Texture: stroke at constant force, and look at what changes under the taxels (Klatzky's *lateral motion*).

The pad strokes both ways, the longest run of whole contact counts, and `grain_signal` reads it.  An object that
yields takes its share of every height: give its `share` of a press (see `hardness`).

Property class: surface (texture).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.ndimage import binary_erosion

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.hybrid import HybridGains, HybridState, hybrid
from exploration.control.procedures.grain_signal import Sweep, Texture, texture_of
from exploration.devices.guard import Guard, Observation
from exploration.sensing.frame import TaxelArray
from exploration.sensing.response import response_of
from primitives.arrays import Bools, Floats, frozen

SERVES = "surface: texture"


@dataclass(frozen=True)
class TextureConfig:
    """The stroke."""

    speed: float = 20.0  # [mm/s]
    length: float = 30.0  # [mm] to either side of where it begins
    least: float = 8.0  # [mm] in all, below which nothing is told
    shrunk: float = 0.9  # of the touched taxels, below which an edge is near
    margin: float = 7.0  # [mm] of travel left out where contact shrank
    press: float = 0.5  # [mm] of the skin, that sets the force


@dataclass(frozen=True)
class NotStroked:
    """There was no way to stroke; false in a condition."""

    reason: str

    def __bool__(self) -> Literal[False]:
        return False


def texture(
    guard: Guard, heading: Floats, share: float = 1.0, config: TextureConfig = TextureConfig()
) -> Texture | NotStroked:
    """Stroke from a flush contact both ways along a (2,) unit `heading`; ends in contact."""
    sweeps = [_stroke(guard, sign * heading, length, config) for sign, length in _legs(config)]
    sweeps = [sweep for sweep in sweeps if sweep is not None]
    travel = sum(float(np.ptp(sweep.travel)) for sweep in sweeps if sweep is not None)
    told = [sweep for sweep in sweeps if sweep is not None and float(np.ptp(sweep.travel)) > config.least]
    if not told:
        return NotStroked(
            f"no {config.least:g} mm were left {config.margin:g} mm off edges; touch a wider face, or its middle"
        )
    longest = max(told, key=lambda sweep: float(np.ptp(sweep.travel)))
    return texture_of(longest, share, travel)


def _legs(config: TextureConfig) -> tuple[tuple[float, float], ...]:
    return (1.0, config.length), (-1.0, 2.0 * config.length)


def _stroke(guard: Guard, heading: Floats, length: float, config: TextureConfig) -> Sweep | None:
    """One straight stroke at constant force until its length is done or contact shrinks."""
    gains = HybridGains.for_delay(guard.period, guard.pending.latency)
    seen = dwell(guard, 8)
    felt = feel(seen.image)
    if not felt:
        return None
    area = float(seen.image.array.pitch[0] * seen.image.array.pitch[1])
    law, start, shrunk, most, told = HybridState(), seen.world_from_sensor, 0, 0, 0.0
    along = start[:3, :2] @ heading
    kept: list[tuple[Observation, Bools]] = []
    while told < length and shrunk < 3:
        wanted = config.press * seen.image.stiffness * float(felt.mask.sum()) * area
        missing = (wanted - seen.force) / (seen.image.stiffness * felt.area)
        missing -= float(guard.pending.motion(seen.time)[2, 3])
        wish = np.array([*(heading * config.speed), 0.0, 0.0, 0.0, 0.0])
        twist, law = hybrid(law, missing, felt.slope, felt.centroid, wish, guard.period, gains)
        seen = guard.move(twist)
        told += config.speed * guard.period
        felt = feel(seen.image)
        if not felt:
            break
        count = int(felt.mask.sum())
        most = max(most, count)
        shrunk = shrunk + 1 if count < config.shrunk * most else 0
        kept.append((seen, felt.mask))
    guard.hold(round(guard.pending.latency / guard.period) + 1)
    return _swept(_far_from_edges(kept, guard.period, config), heading, along)


def _far_from_edges(
    kept: list[tuple[Observation, Bools]], period: float, config: TextureConfig
) -> list[tuple[Observation, Bools]]:
    """The longest run of frames with whole contact, less what the rubber lets an edge reach at its ends."""
    counts = np.array([int(mask.sum()) for _, mask in kept])
    if not len(counts):
        return []
    whole = np.concatenate([[False], counts >= config.shrunk * counts.max(), [False]])
    begin, end = np.flatnonzero(~whole[:-1] & whole[1:]), np.flatnonzero(whole[:-1] & ~whole[1:])
    longest = int(np.argmax(end - begin))
    first, last = int(begin[longest]), int(end[longest])
    margin = round(config.margin / config.speed / period)
    ramp = round(0.1 / period)  # while the stage gets up to speed
    first += ramp if first == 0 else margin
    return kept[first : last - margin if last < len(kept) or counts[-1] < counts.max() else last]


def _swept(run: list[tuple[Observation, Bools]], heading: Floats, along: Floats) -> Sweep | None:
    if len(run) < 20:
        return None
    kept = [seen for seen, _ in run]
    image = kept[0].image
    array: TaxelArray = image.array
    mask = np.mean([mask for _, mask in run], axis=0) > 0.99
    mask = binary_erosion(mask, border_value=1) & np.isfinite(image.sigma)
    rows, columns = np.nonzero(mask)
    if len(rows) < 8:
        return None
    places = np.array([seen.world_from_sensor[:3, 3] @ along for seen in kept])
    ticks = np.arange(len(places))
    travel = np.polynomial.polynomial.polyval(ticks, np.polynomial.polynomial.polyfit(ticks, places, 1))
    return Sweep(
        frozen(np.stack([seen.image.depth[mask] for seen in kept])),
        frozen(travel),
        frozen(np.column_stack([array.x[columns], array.y[rows]])),
        frozen(heading),
        response_of(image).mean_width,
        array.pitch[0] * array.pitch[1],
    )

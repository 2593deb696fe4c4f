"""Surface normal: null the moments, and again beside it; two points give the normal (Stansfield's procedure).

Where the pad lies level, the moments about the contact's centroid vanish and the pad's own normal, less the slope
still felt, is the surface's.  From a second place the chord between both contacts comes in: on a flat face and on
any arc of a circle it is square to the mean of the two normals, so what of that mean lies along the chord is
error, and is taken out (our derivation).  The errors of a contact's attitude stay in the other direction.

Property class: structural (exact shape).
"""

from dataclasses import dataclass

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.hardness import NotPressed
from exploration.control.procedures.settle import settle
from exploration.control.track_surface import follow_surface
from exploration.devices.guard import Guard, Observation
from primitives.arrays import Floats, frozen

SERVES = "structural: exact shape"


@dataclass(frozen=True)
class NormalConfig:
    """The two places."""

    apart: float = 6.0  # [mm]
    least: float = 2.0  # [mm] of a chord that is worth anything
    frames: int = 12  # averaged


@dataclass(frozen=True)
class SurfaceNormal:
    """The outward normal at a point."""

    point: Floats  # (3,) [mm]
    normal: Floats  # (3,) unit
    places: int  # that it comes from, one or two
    disagreement: float  # [rad] of the first mean with the chord; 0 from one place


def surface_normal(
    guard: Guard, heading: Floats, config: NormalConfig | None = None
) -> SurfaceNormal | NotPressed:
    """From a flush contact; the second place lies along a (2,) unit `heading` in the pad's plane."""
    config = config or NormalConfig()
    first = _here(guard, config)
    if first is None:
        return NotPressed("no contact; approach and settle first")
    guard.cost.strokes += 1
    follow_surface(guard, heading, config.apart, guard.cost.touches, guard.cost.strokes)
    settle(guard)
    second = _here(guard, config)
    if second is None:
        return SurfaceNormal(first[0], first[1], 1, 0.0)
    chord = second[0] - first[0]
    length = float(np.linalg.norm(chord))
    mean = _unit(first[1] + second[1])
    if length < config.least:
        return SurfaceNormal(first[0], mean, 1, 0.0)
    along = float(mean @ chord) / length
    normal = _unit(mean - along * chord / length)
    middle = (first[0] + second[0]) / 2.0
    return SurfaceNormal(frozen(middle), frozen(normal), 2, float(np.arcsin(min(1.0, abs(along)))))


def _here(guard: Guard, config: NormalConfig) -> tuple[Floats, Floats] | None:
    """Point and outward normal under the pad; the stage is asked as often as the array."""
    places: list[Floats] = []

    def note(seen: Observation) -> None:
        places.append(seen.world_from_sensor)

    before = guard.observers
    guard.observers = (*before, note)
    seen = dwell(guard, config.frames)
    guard.observers = before
    felt = feel(seen.image)
    if not felt:
        return None
    place = seen.world_from_sensor
    origin = np.mean([p[:3, 3] for p in places], axis=0)
    slope = felt.slope - felt.hessian @ felt.centroid
    local = np.array([*felt.centroid, -felt.depth])
    return place[:3, :3] @ local + origin, _unit(place[:3, :3] @ np.array([*-slope, -1.0]))


def _unit(v: Floats) -> Floats:
    out: Floats = v / np.linalg.norm(v)
    return out

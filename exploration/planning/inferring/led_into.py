"""Round openings that lead into a hollow that was felt, as of the drill hole under a countersink.

Behind its rim the hole goes on straight until all its wall has come out in the hollow; that is likely and not
measured, so the wall is marked as inferred (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.open.holes import Hole
from exploration.planning.open.round_rims import RoundRim
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cone, Shape, Sphere


@dataclass(frozen=True)
class LedIntoConfig:
    """Where a hollow is looked for."""

    deepest: float = 60.0  # [mm] behind a rim
    step: float = 0.25  # [mm]
    least: float = 1.0  # [mm] of a hole
    felt: float = 16.0  # [mm] from where it comes out, within which the hollow was felt
    at_rim: float = 1.0  # [mm] from a hollow, within which a rim is the hollow's own


def hollows_of(faces: Sequence[Face]) -> list[Face]:
    """The hollows among faces that end by themselves behind what opens into them."""
    return [f for f in faces if isinstance(f.fit, Fit) and not f.fit.convex and _closes(f.fit.shape)]


def own_rim(rim: RoundRim, hollows: Sequence[Face], config: LedIntoConfig = LedIntoConfig()) -> bool:
    """Whether a rim is where a hollow itself comes out, which then needs no other wall behind it."""
    at = rim.places()[0]
    return any(
        isinstance(face.fit, Fit)
        and float(np.median(np.abs(face.fit.shape.signed_distance(at)))) < config.at_rim
        for face in hollows
    )


def led_into(rim: RoundRim, hollows: Sequence[Face], config: LedIntoConfig = LedIntoConfig()) -> Hole | None:
    """The hole behind a rim, down to the nearest hollow that it comes out in; None where there is none."""
    depths = [deep for face in hollows if (deep := _depth(rim, face, config)) is not None]
    if not depths:
        return None
    deep = min(depths)
    return Hole(rim.center - 0.5 * deep * rim.axis, rim.axis, rim.radius, deep, rim.sigma)


def _depth(rim: RoundRim, face: Face, config: LedIntoConfig) -> float | None:
    """[mm] behind a rim, where all of its circle is in a hollow."""
    assert isinstance(face.fit, Fit)
    at, steps = rim.places()[0], np.arange(0.0, config.deepest, config.step)
    places = at - steps[:, None, None] * rim.axis
    inside = face.fit.shape.signed_distance(places.reshape(-1, 3)).reshape(len(steps), -1).max(axis=1) < 0.0
    if not inside.any() or inside[0]:
        return None
    first = int(np.argmax(inside))
    near = np.linalg.norm(face.contacts.points[:, None] - places[first], axis=2).min()
    deep = float(steps[first])
    return deep if deep > config.least and near < config.felt else None


def _closes(shape: Shape) -> bool:
    return isinstance(shape, Cone | Sphere)

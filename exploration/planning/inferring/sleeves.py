"""Where the bore of an adapter narrows that no array could feel: where its outside does.

A hole whose two mouths differ, through a body whose outside narrows round the same axis in between, with a wall
that is nearly as thick at one mouth as at the other, is a tube that was drawn with one wall.  Its bore narrows
between the same depths as the cone outside (our derivation; likely, and not measured).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.open.round_rims import RoundRim
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class SleeveConfig:
    """What is an outside of a hole."""

    parallel: float = 0.998  # least cosine between its axis and the hole's
    aside: float = 1.0  # [mm] between them
    alike: float = 1.6  # times as thick that the wall is at one mouth as at the other, at most
    beyond: float = 1.0  # [mm] past a mouth, that the cone may reach


def narrowing(
    rim: RoundRim, other: RoundRim, faces: Sequence[Face], config: SleeveConfig = SleeveConfig()
) -> tuple[float, float] | None:
    """[mm] depths below the wide `rim` between which the outside narrows; None where there is no such outside."""
    shapes = [face.fit.shape for face in faces if isinstance(face.fit, Fit) and face.fit.convex]
    round_it = [s for s in shapes if isinstance(s, Cylinder | Cone) and _about(s, rim, config)]
    far = float((rim.center - other.center) @ rim.axis)
    for cone in round_it:
        if not isinstance(cone, Cone) or float(cone.axis @ rim.axis) < 0.0:
            continue  # it widens toward the narrow mouth
        apex, slope = float((rim.center - cone.anchor) @ rim.axis), float(np.tan(cone.semi_angle))
        outer = [s.radius for s in round_it if isinstance(s, Cylinder)]
        wide = min((r for r in outer if r > rim.radius), default=apex * slope)
        thin = min((r for r in outer if other.radius < r < wide), default=(apex - far) * slope)
        first, last = apex - wide / slope, apex - thin / slope
        walls = wide - rim.radius, thin - other.radius
        within = -config.beyond < first < last < far + config.beyond
        if within and min(walls) > 0.0 and max(walls) < config.alike * min(walls):
            return max(first, 0.0), min(last, far)
    return None


def _about(shape: Cylinder | Cone, rim: RoundRim, config: SleeveConfig) -> bool:
    """Whether a shape turns about the axis of a mouth."""
    away = shape.anchor - rim.center
    aside = float(np.linalg.norm(away - away @ rim.axis * rim.axis))
    return abs(float(shape.axis @ rim.axis)) > config.parallel and aside < config.aside

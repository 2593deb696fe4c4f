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
from primitives.shapes import Cone, Cylinder, Shape


@dataclass(frozen=True)
class SleeveConfig:
    """What is an outside of a hole."""

    parallel: float = 0.998  # least cosine between its axis and the hole's
    aside: float = 1.0  # [mm] between them
    alike: float = 1.6  # times as thick that the wall is at one mouth as at the other, at most
    step: tuple[float, float] = (0.65, 1.5)  # times the bore's narrowing, that the outside's is
    beyond: float = 1.0  # [mm] past a mouth, that the cone may reach
    least: float = 1.0  # [mm] between the two depths


def narrowing(
    rim: RoundRim, other: RoundRim, faces: Sequence[Face], config: SleeveConfig = SleeveConfig()
) -> tuple[float, float] | None:
    """[mm] depths below the wide `rim` between which the outside narrows; None where there is no such outside."""
    far = float((rim.center - other.center) @ rim.axis)
    outer = [
        (face.fit.shape, face.contacts)
        for face in faces
        if isinstance(face.fit, Fit) and face.fit.convex and _about(face.fit.shape, rim, other, config)
    ]
    straight = [shape.radius for shape, _ in outer if isinstance(shape, Cylinder)]
    for cone, contacts in outer:
        if not isinstance(cone, Cone) or float(cone.axis @ rim.axis) < 0.0:
            continue  # it widens toward the narrow mouth
        apex, slope = float((rim.center - cone.anchor) @ rim.axis), float(np.tan(cone.semi_angle))
        middle = float(np.median((contacts.points - cone.anchor) @ cone.axis)) * slope
        wide = min((r for r in straight if r > middle), default=apex * slope)
        thin = max((r for r in straight if r < middle), default=(apex - far) * slope)
        first, last = apex - wide / slope, apex - thin / slope
        walls, narrower = (wide - rim.radius, thin - other.radius), rim.radius - other.radius
        drawn_so = min(walls) > 0.0 and max(walls) < config.alike * min(walls)
        drawn_so = drawn_so and config.step[0] < (wide - thin) / narrower < config.step[1]
        if drawn_so and -config.beyond < first and last < far + config.beyond:
            depths = max(first, 0.0), min(last, far)
            return depths if depths[1] - depths[0] > config.least else None
    return None


def _about(shape: Shape, rim: RoundRim, other: RoundRim, config: SleeveConfig) -> bool:
    """Whether a shape turns about the axis of a hole, between its mouths."""
    if not isinstance(shape, Cylinder | Cone):
        return False
    away = 0.5 * (rim.center + other.center) - shape.anchor
    aside = float(np.linalg.norm(away - away @ shape.axis * shape.axis))
    return abs(float(shape.axis @ rim.axis)) > config.parallel and aside < config.aside

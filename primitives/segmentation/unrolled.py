"""Contacts on a plane, cylinder or cone, laid out flat as they lie on it.

A cylinder unrolls to (r phi, z); a cone to the sector (s cos(phi sin a), s sin(phi sin a)), with s the distance
from the apex along its side and a the semi-angle.  Both are slit where the contacts leave the widest angle free.
Other shapes cannot be laid out flat without stretching them.
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.pose import frame_along
from primitives.shapes import Cone, Cylinder, Plane, Shape


def unrolled(shape: Shape, points: Floats) -> Floats | None:
    """(n, 2) [mm] places of (n, 3) contacts on the shape laid out flat; None where that stretches it."""
    if isinstance(shape, Plane):
        return np.asarray((points - shape.origin) @ frame_along(shape.normal)[:, :2])
    if isinstance(shape, Cylinder):
        x, y, z = ((points - shape.origin) @ frame_along(shape.axis)).T
        return np.stack([shape.radius * _slit(np.arctan2(y, x)), z], axis=1)
    if isinstance(shape, Cone):
        x, y, z = ((points - shape.apex) @ frame_along(shape.axis)).T
        sine, cosine = np.sin(shape.semi_angle), np.cos(shape.semi_angle)
        along, turn = z * cosine + np.hypot(x, y) * sine, _slit(np.arctan2(y, x)) * sine
        return np.stack([along * np.cos(turn), along * np.sin(turn)], axis=1)
    return None


def _slit(turn: Floats) -> Floats:
    """(n,) angles [rad] in one range of 2 pi that begins after the widest gap between them."""
    order = np.sort(np.mod(turn, 2 * np.pi))
    gaps = np.diff(order, append=order[0] + 2 * np.pi)
    begin = order[(int(gaps.argmax()) + 1) % len(order)]
    return np.asarray(np.mod(turn - begin, 2 * np.pi))

"""Planes that no face has, and that a body's primitives end at.

Where a plane touches a cylinder along a line, the cells beside the line have no surface between them: there a
separator is needed, the plane through the cylinder's axis and across the tangent one (after Shapiro and Vossler
1993).  So is one where a bent tube goes over into a straight one, the plane through its ring's center and across
the straight axis.  A wall that runs into a round body, or a pin into a ball, a ring or another pin, ends somewhere
inside it, at no face: for the shortest list it may end at a stop, the plane through the round body's axis, center
or tube and across the wall or the pin; a hole on one side of it alone may always (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from primitives.arrays import Floats
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

_TANGENT = 0.01  # [rad] within which directions are one
_ACROSS = 0.1  # [rad] within which a pin runs across an axis: one that was hardly felt leans
_SHARE = 0.02  # of a radius, within which a plane touches a cylinder that was felt at a few places
_TOUCHING = 0.05  # [mm] the same, however small the radius
_GOES_OVER = 0.1  # of a tube's radius, within which a straight axis touches the circle of its bent one
_MOST = 12  # stops
_NEAR_END = 4.0  # [mm] from where a round body was felt last, within which a face may end it
_PAST_LAST = 1.0  # [mm] past it, where it ends else: a pad does not feel up to the rim


def separators(shapes: Sequence[Shape]) -> list[Plane]:
    """The planes that part cells which tangent surfaces leave undecided; each once."""
    found: list[Plane] = []
    planes = [shape for shape in shapes if isinstance(shape, Plane)]
    for shape, plane, away in _along(shapes):
        if abs(away - shape.radius) <= max(_SHARE * shape.radius, _TOUCHING):
            _add(Plane(shape.origin, np.cross(shape.axis, plane.normal)), found, planes)
    for ring in shapes:
        for pin in shapes:
            if isinstance(ring, Torus) and isinstance(pin, Cylinder | Cone) and _goes_over(pin, ring):
                _add(Plane(ring.center, pin.axis), found, planes)
    return found


def one_sided(shapes: Sequence[Shape], touched: Sequence[tuple[Floats, Floats]]) -> list[Plane]:
    """The planes through the axes of round bodies at which a hole may end that was found on one side alone.

    `touched[i]` are the (n, 3) contacts of surface i and their (n, 3) normals: a set screw's hole in a collar goes
    through one wall of two.
    """
    found: list[Plane] = []
    planes = [shape for shape in shapes if isinstance(shape, Plane)]
    for pin, (felt, normals) in zip(shapes, touched, strict=False):  # separators among the shapes have none
        if not isinstance(pin, Cylinder) or not len(felt) or (pin.normals(felt) * normals).sum() > 0.0:
            continue
        for body in shapes:
            if isinstance(body, Cylinder) and pin.radius < body.radius and _meets(pin, body):
                beyond = (felt - body.anchor) @ pin.axis
                if beyond.min() > _TOUCHING or beyond.max() < -_TOUCHING:
                    _add(Plane(body.anchor, pin.axis), found, planes)
    return found[:_MOST]


def stops(shapes: Sequence[Shape]) -> list[Plane]:
    """The planes inside round bodies at which what runs into them may end; each once."""
    found: list[Plane] = []
    planes = [shape for shape in shapes if isinstance(shape, Plane)]
    for shape, plane, away in _along(shapes):
        if away < shape.radius:
            _add(Plane(shape.origin, np.cross(shape.axis, plane.normal)), found, planes)
    pins = [shape for shape in shapes if isinstance(shape, Cylinder | Cone)]
    for body in shapes:
        if isinstance(body, Plane | Cone):
            continue
        for pin in pins:
            if pin is not body and _meets(pin, body):
                for point in _middles(pin, body):
                    _add(Plane(point, pin.axis), found, planes)
    return found[:_MOST]


def felt_ends(
    shapes: Sequence[Shape], touched: Sequence[tuple[Floats, Floats]], inferred: Sequence[bool]
) -> list[Plane]:
    """The planes across round bodies where they were felt last, with no face near that they could end at.

    Nothing was felt of the separators among the shapes, which come last, nor of what is `inferred`.  A collar
    whose underside is too narrow to be felt ends somewhere there; without an end it would be none, for what it
    stands on lies inside it.
    """
    found: list[Plane] = []
    planes = [shape for shape in shapes if isinstance(shape, Plane)]
    for shape, (felt, _), guessed in zip(shapes, touched, inferred, strict=False):
        if guessed or not isinstance(shape, Cylinder | Cone) or not len(felt):
            continue
        across = [plane for plane in planes if abs(float(plane.normal @ shape.axis)) > 1.0 - _TANGENT]
        ends = [float((plane.origin - shape.anchor) @ shape.axis) for plane in across]
        along = (felt - shape.anchor) @ shape.axis
        for last, way in ((float(along.min()), -1.0), (float(along.max()), 1.0)):
            if not any(abs(end - last) < _NEAR_END for end in ends):
                _add(Plane(shape.anchor + (last + way * _PAST_LAST) * shape.axis, shape.axis), found, planes)
    return found[:_MOST]


def _along(shapes: Sequence[Shape]) -> list[tuple[Cylinder, Plane, float]]:
    """Cylinders, planes along their axes, and how far from these."""
    out = []
    for shape in shapes:
        for plane in shapes:
            if not (isinstance(shape, Cylinder) and isinstance(plane, Plane)):
                continue
            if abs(float(plane.normal @ shape.axis)) < _TANGENT:
                out.append((shape, plane, abs(float((shape.origin - plane.origin) @ plane.normal))))
    return out


def _goes_over(pin: Cylinder | Cone, ring: Torus) -> bool:
    """Whether a straight axis touches the circle in the middle of a ring's tube."""
    if abs(float(pin.axis @ ring.axis)) > _ACROSS:
        return False
    away = np.array([(pin.anchor - ring.center) @ ring.axis, _distance(ring.center, pin) - ring.radius])
    return float(np.linalg.norm(away)) < max(_GOES_OVER * ring.minor_radius, _TOUCHING)


def _meets(pin: Cylinder | Cone, body: Shape) -> bool:
    """Whether a pin's axis runs through a ball, or across another's axis or a ring."""
    if isinstance(body, Sphere):
        return _distance(body.center, pin) < body.radius
    assert isinstance(body, Cylinder | Torus)
    if abs(float(pin.axis @ body.direction)) > _ACROSS:
        return False
    apart = abs(float((body.anchor - pin.anchor) @ np.cross(pin.axis, body.direction)))
    if isinstance(body, Cylinder):
        return apart < body.radius
    level = abs(float((body.center - pin.anchor) @ body.direction))
    return level < body.minor_radius and apart < body.radius + body.minor_radius


def _middles(pin: Cylinder | Cone, body: Shape) -> list[Floats]:
    """Where a pin is inside a body: at its axis or center, or in a ring's tube, on either side."""
    if not isinstance(body, Torus):
        return [body.anchor]
    aside = float((body.center - pin.anchor) @ np.cross(pin.axis, body.direction))
    reach = float(np.sqrt(max(body.radius**2 - aside**2, 0.0)))
    return [body.center + side * reach * pin.axis for side in (-1.0, 1.0)]


def _distance(point: Floats, pin: Cylinder | Cone) -> float:
    return float(np.linalg.norm(np.cross(point - pin.anchor, pin.axis)))


def _add(made: Plane, found: list[Plane], planes: Sequence[Plane]) -> None:
    if not any(_same(made, other) for other in (*planes, *found)):
        found.append(made)


def _same(a: Plane, b: Plane) -> bool:
    turned = float(np.linalg.norm(np.cross(a.normal, b.normal)))
    return turned < _TANGENT and abs(float((a.origin - b.origin) @ b.normal)) < _TOUCHING

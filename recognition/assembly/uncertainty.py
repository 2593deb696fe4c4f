"""Standard deviations of what an assembly says: of each face's parameters, and of each primitive's sizes.

A plane moves outward at a point p by dn - (p - origin)_t . tilt when it takes the step (dn, tilt); a size that
spans two surfaces gets its variance from both and their covariance after regularization.
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from primitives.shapes import Cone, Cylinder, Shape, Sphere, Torus
from recognition.assembly.piece import Piece
from recognition.assembly.regularities import Regularized

Sigma = dict[str, float | list[float | None]]


def face_sigma(shape: Shape, covariance: Floats) -> dict[str, float]:
    """By the names of the parameters: of the origin (its worst direction), of the axis, and of each size."""
    count = len(shape.translations)
    out = {"origin_mm": _worst(covariance[:count, :count])}
    if shape.tilts:
        out["axis_deg"] = float(np.rad2deg(_worst(covariance[count : count + 2, count : count + 2])))
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))[count + shape.tilts :]
    if isinstance(shape, Cone):
        out["semi_angle_deg"] = float(np.rad2deg(deviations[0]))
    else:
        names = ("radius_mm", "minor_radius_mm")
        out.update({n: float(d) for n, d in zip(names, deviations, strict=False)})
    return out


def piece_sigma(piece: Piece, regularized: Regularized) -> Sigma:
    """Of the extents [mm], None along axes with a side that no surface closes; a cone's radii besides."""
    at = piece.world_from_piece[:3, 3]
    lengths: list[float | None] = []
    for below, above in piece.ends:
        if below is None or above is None:
            lengths.append(None)
        else:
            slope = outward_slope(below, at, regularized) + outward_slope(above, at, regularized)
            lengths.append(_deviation(slope, regularized))
    if piece.body is None:
        across: list[float | None] = (
            [None, None] if piece.kind == "cylinder" else []
        )  # of a bar that no wall made
        return {"extent_mm": [*across, *lengths]}
    shape = regularized.shapes[piece.body]
    size = np.zeros(len(regularized.step))
    size[regularized.slices[piece.body].stop - 1] = 1.0
    if isinstance(shape, Torus):
        wide = np.zeros(len(regularized.step))
        wide[regularized.slices[piece.body].stop - 2] = 1.0
        width, height = _deviation(2 * (wide + size), regularized), _deviation(2 * size, regularized)
        return {
            "radius_mm": _deviation(wide, regularized),
            "minor_radius_mm": _deviation(size, regularized),
            "extent_mm": [width, width, height],
        }
    if isinstance(shape, Cylinder | Sphere):
        radius = _deviation(size, regularized)
        last = lengths if isinstance(shape, Cylinder) else [2 * radius]
        return {"radius_mm": radius, "extent_mm": [2 * radius, 2 * radius, *last]}
    bottom, top = piece.ends[0] if piece.ends else (None, None)
    radii = [_cone_radius(shape, piece.body, cap, size, regularized) for cap in (bottom, top)]
    tall = (
        _deviation(_cone_height(piece.body, bottom, top, regularized), regularized)
        if bottom is not None
        else None
    )
    wide_end = None if radii[0] is None else 2 * radii[0]
    out: Sigma = {"extent_mm": [wide_end, wide_end, tall]}
    for name, radius_sigma in zip(("bottom_radius_mm", "top_radius_mm"), radii, strict=True):
        if radius_sigma is not None:
            out[name] = radius_sigma
    return out


def outward_slope(plane: int, at: Floats, regularized: Regularized) -> Floats:
    """(d,) by which a plane moves outward at a point, per unit of the stacked step."""
    shape = regularized.shapes[plane]
    out = np.zeros(len(regularized.step))
    out[regularized.slices[plane]] = [1.0, *(-(at - shape.anchor) @ shape.frame[:, :2])]
    return out


def _cone_radius(
    shape: Shape, body: int, cap: int | None, size: Floats, regularized: Regularized
) -> float | None:
    """Of r = h tan(a), h from the apex to the cap."""
    if cap is None or not isinstance(shape, Cone):
        return None
    plane = regularized.shapes[cap]
    height = abs(float((plane.anchor - shape.apex) @ shape.axis))
    slope = np.tan(shape.semi_angle) * _from_apex(body, cap, regularized)
    slope = slope + height / np.cos(shape.semi_angle) ** 2 * size
    return _deviation(slope, regularized)


def _cone_height(body: int, bottom: int, top: int | None, regularized: Regularized) -> Floats:
    far = _from_apex(body, bottom, regularized)
    return far if top is None else far - _from_apex(body, top, regularized)


def _from_apex(body: int, cap: int, regularized: Regularized) -> Floats:
    """(d,) slope of the distance, along the cone's axis, from its apex to a plane across it."""
    cone, plane = regularized.shapes[body], regularized.shapes[cap]
    outward = float(plane.direction @ cone.direction)
    slope = outward * outward_slope(cap, cone.anchor, regularized)
    start = regularized.slices[body].start
    slope[start : start + 3] -= cone.frame.T @ cone.direction
    return slope


def _worst(covariance: Floats) -> float:
    return float(np.sqrt(max(float(np.linalg.eigvalsh(covariance)[-1]), 0.0)))


def _deviation(slope: Floats, regularized: Regularized) -> float:
    return float(np.sqrt(max(float(slope @ regularized.covariance @ slope), 0.0)))

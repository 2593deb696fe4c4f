"""Parameter grids over the part of an unbounded surface that may lie in a box, refined only where asked.

A chart maps (u, v) to the surface.  A cell of it, half as wide as `half` in u and v, lies within a ball round
its center whose radius follows from the local metric, so a coarse cell that is farther from the wanted body
than that radius is dropped with everything in it (our derivation: branch and bound on 1-Lipschitz distances).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import frame_along
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere

Map = Callable[[Floats, Floats], Floats]  # (n,), (n,) -> (n, 3) [mm]
Metric = Callable[[Floats, Floats], tuple[Floats, Floats]]  # v, half of v -> [mm] per unit of u and of v


@dataclass(frozen=True)
class Chart:
    """A rectangle of parameters and its map onto the surface."""

    u: tuple[float, float]
    v: tuple[float, float]
    point: Map
    metric: Metric  # greatest scale anywhere in the cell


@dataclass(frozen=True)
class Cells:
    """Centers of chart cells on the surface."""

    points: Floats  # (n, 3) [mm]
    area: Floats  # (n,) [mm^2] each stands for


Bound = Callable[[Floats], Floats]  # (n, 3) -> (n,) [mm] lower bound of the distance to what is wanted


def sample_chart(chart: Chart, spacing: float, bound: Bound) -> Cells:
    """Cell centers at most `spacing` [mm] apart in u and v, where `bound` is not positive."""
    u, v, half_u, half_v = _coarse(chart, 8.0 * spacing)
    while True:
        points = chart.point(u, v)
        scale_u, scale_v = chart.metric(v, half_v)
        wide, tall = half_u * scale_u, half_v * scale_v
        distance = bound(points)
        near = distance <= np.hypot(wide, tall)
        split_u, split_v = (wide > 0.5 * spacing) & near, (tall > 0.5 * spacing) & near
        if not (split_u.any() or split_v.any()):
            inside = distance <= 0.0
            area: Floats = 4.0 * half_u * half_v * np.multiply(*chart.metric(v, 0.0 * half_v))
            return Cells(points[inside], area[inside])
        u, v, half_u, half_v = (a[near] for a in (u, v, half_u, half_v))
        u, v, half_u, half_v = _split(u, v, half_u, half_v, split_u[near])
        # the first split doubled its rows in place, so the second mask is doubled alike
        rows = np.repeat(split_v[near], np.where(split_u[near], 2, 1))
        v, u, half_v, half_u = _split(v, u, half_v, half_u, rows)


def _split(
    a: Floats, b: Floats, half_a: Floats, half_b: Floats, mask: np.ndarray[tuple[int], np.dtype[np.bool_]]
) -> tuple[Floats, Floats, Floats, Floats]:
    count = np.where(mask, 2, 1)
    half = np.repeat(np.where(mask, 0.5 * half_a, half_a), count)
    side = np.zeros(int(count.sum()))
    first = np.cumsum(count) - count
    side[first[mask]] = -1.0
    side[first[mask] + 1] = 1.0
    return np.repeat(a, count) + side * half, np.repeat(b, count), half, np.repeat(half_b, count)


def _coarse(chart: Chart, size: float) -> tuple[Floats, Floats, Floats, Floats]:
    middle = np.array([0.5 * (chart.v[0] + chart.v[1])])
    scale_u, scale_v = chart.metric(middle, np.array([0.5 * (chart.v[1] - chart.v[0])]))
    nu = max(1, int(np.ceil((chart.u[1] - chart.u[0]) * scale_u[0] / size)))
    nv = max(1, int(np.ceil((chart.v[1] - chart.v[0]) * scale_v[0] / size)))
    half_u, half_v = (chart.u[1] - chart.u[0]) / (2 * nu), (chart.v[1] - chart.v[0]) / (2 * nv)
    u, v = np.meshgrid(
        chart.u[0] + half_u * (2 * np.arange(nu) + 1), chart.v[0] + half_v * (2 * np.arange(nv) + 1)
    )
    n = nu * nv
    return u.ravel(), v.ravel(), np.full(n, half_u), np.full(n, half_v)


def chart(shape: Shape, box: Floats) -> Chart:
    """A chart that covers all of `shape` inside the (2, 3) `box` [mm]."""
    for kind, make in _CHARTS.items():
        if isinstance(shape, kind):
            return make(shape, np.asarray(box, dtype=float))
    raise PalpateError(f"no chart for a {type(shape).__name__}; use plane, cylinder, cone or sphere")


def _corners(box: Floats) -> Floats:
    grid = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
    return np.asarray(grid, dtype=float)


def _of_plane(shape: Plane, box: Floats) -> Chart:
    frame = frame_along(shape.normal)
    flat = (_corners(box) - shape.origin) @ frame[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)

    def point(u: Floats, v: Floats) -> Floats:
        return np.asarray(shape.origin + u[:, None] * frame[:, 0] + v[:, None] * frame[:, 1])

    def metric(v: Floats, half: Floats) -> tuple[Floats, Floats]:
        return np.ones_like(v), np.ones_like(v)

    return Chart((low[0], high[0]), (low[1], high[1]), point, metric)


def _of_cylinder(shape: Cylinder, box: Floats) -> Chart:
    frame = frame_along(shape.axis)
    along = (_corners(box) - shape.origin) @ shape.axis

    def point(u: Floats, v: Floats) -> Floats:
        ring = np.stack([shape.radius * np.cos(u), shape.radius * np.sin(u), v], axis=1)
        return np.asarray(shape.origin + ring @ frame.T)

    def metric(v: Floats, half: Floats) -> tuple[Floats, Floats]:
        return np.full_like(v, shape.radius), np.ones_like(v)

    return Chart((-np.pi, np.pi), (float(along.min()), float(along.max())), point, metric)


def _of_cone(shape: Cone, box: Floats) -> Chart:
    frame = frame_along(shape.axis)
    sine, cosine = np.sin(shape.semi_angle), np.cos(shape.semi_angle)
    reach = float(np.linalg.norm(_corners(box) - shape.apex, axis=1).max())

    def point(u: Floats, v: Floats) -> Floats:
        ring = np.stack([v * sine * np.cos(u), v * sine * np.sin(u), v * cosine], axis=1)
        return np.asarray(shape.apex + ring @ frame.T)

    def metric(v: Floats, half: Floats) -> tuple[Floats, Floats]:
        return (v + half) * sine, np.ones_like(v)

    return Chart((-np.pi, np.pi), (0.0, reach), point, metric)


def _of_sphere(shape: Sphere, box: Floats) -> Chart:
    def point(u: Floats, v: Floats) -> Floats:
        ring = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=1)
        return np.asarray(shape.center + shape.radius * ring)

    def metric(v: Floats, half: Floats) -> tuple[Floats, Floats]:
        nearest = np.maximum(np.abs(v) - half, 0.0)
        return shape.radius * np.cos(nearest), np.full_like(v, shape.radius)

    return Chart((-np.pi, np.pi), (-np.pi / 2, np.pi / 2), point, metric)


_CHARTS: dict[type, Callable[..., Chart]] = {
    Plane: _of_plane,
    Cylinder: _of_cylinder,
    Cone: _of_cone,
    Sphere: _of_sphere,
}

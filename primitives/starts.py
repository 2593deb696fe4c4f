"""Where the fits begin: algebraic solutions from normals, felt or estimated from neighbors.

* cylinder: the axis is across all normals (least singular vector); then p - r n = c is linear in (c, r).
* cone: every tangent plane holds the apex, linear; the directions from it lie on a circle round the axis.
* sphere: p - r n = c is linear in (c, r).
* torus: p - r n runs along a circle, for the right one of a row of tube radii r.
Without normals: principal axes, and the algebraic circle and sphere |p|^2 = 2 p . c + d.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from primitives.arrays import Floats
from primitives.residuals import Problem
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

Start = tuple[Shape, float]  # a shape, and -1 where the felt face is concave
_ANGLES = (0.02, 0.25, -0.25)  # [rad] semi-angles at which a cylinder is opened to a cone
_TUBES = np.geomspace(0.02, 4.0, 20)  # tube radii tried, in units of the contacts' extent
_DIRECTIONS = 64  # cylinder axes tried where no normal is felt
_NEIGHBORS = 8  # for estimated normals


def plane_starts(problem: Problem) -> Iterator[Start]:
    """The mean normal, or the least principal axis."""
    normal = problem.normals.sum(axis=0)
    if not len(problem.felt) or np.linalg.norm(normal) < 0.1 * len(problem.felt):
        normal = _principal(problem.points - problem.center)[1][:, 0]
    yield Plane(problem.center, normal), 1.0


def sphere_starts(problem: Problem) -> Iterator[Start]:
    """Linear in center and radius."""
    if len(problem.felt) >= 2:
        center, radius = _from_normals(problem.points[problem.felt], problem.normals)
        if radius != 0:
            yield Sphere(center, abs(radius)), float(np.sign(radius))
    if len(problem.points) >= 4:
        center, radius = ball_through(problem.points)
        if radius > 0:
            yield Sphere(center, radius), _sign(problem, Sphere(center, radius))


def cylinder_starts(problem: Problem) -> Iterator[Start]:
    """Across the normals; along the principal axes; else the best of many directions."""
    points = problem.points - problem.center
    if len(problem.felt) >= 3:
        vectors = _principal(problem.normals)[1]
        spread = _principal(points)[1]
        for axis in (vectors[:, 0], vectors[:, 1], spread[:, 2]):
            flat = points - np.outer(points @ axis, axis)
            normals = problem.normals - np.outer(problem.normals @ axis, axis)
            length = np.sqrt((normals**2).sum(axis=1, keepdims=True))
            if length.min() < 1e-3:
                continue
            center, radius = _from_normals(flat[problem.felt], normals / length)
            if radius != 0:
                center = center - axis * (center @ axis) + problem.center
                yield Cylinder(center, axis, abs(radius)), float(np.sign(radius))
    elif len(points) >= 5:
        for shape in _cylinders_without_normals(points):
            moved = Cylinder(shape.origin + problem.center, shape.axis, shape.radius)
            yield moved, _sign(problem, moved)


def cone_starts(problem: Problem) -> Iterator[Start]:
    """The common point of the tangent planes; and cylinders, opened a little."""
    normals, points = _normals_or_estimates(problem)
    if len(normals) >= 3:
        apex = np.linalg.lstsq(normals, ((points - problem.center) * normals).sum(axis=1), rcond=1e-6)[0]
        apex = apex + problem.center
        arms = points - apex
        arms = arms / np.maximum(np.sqrt((arms**2).sum(axis=1, keepdims=True)), 1e-9)
        mean = arms.sum(axis=0)
        for axis in (
            _principal(arms - arms.mean(axis=0))[1][:, 0],
            _principal(normals - normals.mean(axis=0))[1][:, 0],
        ):
            axis = axis if axis @ mean > 0 else -axis
            angle = float(np.arccos(np.clip(np.median(arms @ axis), -1.0, 1.0)))
            if 0.01 < angle < 1.55:
                cone = Cone(apex, axis, angle)
                yield cone, _sign(problem, cone)
    for count, (shape, sign) in enumerate(cylinder_starts(problem)):
        if count == 2:
            break
        for angle in _ANGLES:
            assert isinstance(shape, Cylinder)
            pivot = shape.origin + shape.axis * ((problem.center - shape.origin) @ shape.axis)
            axis = np.copysign(1.0, angle) * shape.axis
            yield Cone(pivot - axis * shape.radius / np.tan(abs(angle)), axis, abs(angle)), sign


def torus_starts(problem: Problem) -> Iterator[Start]:
    """For a row of tube radii of either sign, the circle nearest to p - r n; the best of them."""
    if len(problem.felt) < 4:
        yield from _tori_without_normals(problem)
        return
    normals, points = problem.normals, problem.points[problem.felt] - problem.center
    extent = float(np.sqrt((points**2).sum(axis=1).max()))
    tubes = extent * np.concatenate([_TUBES, -_TUBES])
    spines = points - tubes[:, None, None] * normals  # (r, n, 3)
    means = spines.mean(axis=1, keepdims=True)
    centered = spines - means
    vectors = np.linalg.eigh(np.einsum("rni,rnj->rij", centered, centered))[1]
    flat = centered @ vectors[:, :, 1:]
    height = (centered @ vectors[:, :, :1])[..., 0]
    design = np.concatenate([2 * flat, np.ones((*flat.shape[:2], 1))], axis=2)
    square = (flat**2).sum(axis=2)
    gram = np.einsum("rni,rnj->rij", design, design) + 1e-9 * extent**2 * np.eye(3)
    solution = np.linalg.solve(gram, np.einsum("rni,rn->ri", design, square)[..., None])[..., 0]
    radii = np.sqrt(np.maximum(solution[:, 2] + (solution[:, :2] ** 2).sum(axis=1), 1e-12))
    away = np.sqrt(((flat - solution[:, None, :2]) ** 2).sum(axis=2)) - radii[:, None]
    cost = np.sqrt((away**2 + height**2).mean(axis=1)) / np.abs(tubes)
    for i in np.argsort(cost)[:4]:
        center = means[i, 0] + vectors[i, :, 1:] @ solution[i, :2] + problem.center
        if radii[i] > 1e-3 * extent:
            torus = Torus(center, vectors[i, :, 0], float(radii[i]), float(abs(tubes[i])))
            yield torus, _sign(problem, torus)


STARTS: dict[str, Callable[[Problem], Iterator[Start]]] = {
    "plane": plane_starts,
    "cylinder": cylinder_starts,
    "cone": cone_starts,
    "sphere": sphere_starts,
    "torus": torus_starts,
}


def _principal(vectors: Floats) -> tuple[Floats, Floats]:
    values, axes = np.linalg.eigh(vectors.T @ vectors)
    return values, axes


def _sign(problem: Problem, shape: Shape) -> float:
    if not len(problem.felt):
        return 1.0
    agreement = (shape.normals(problem.points[problem.felt]) * problem.normals).sum()
    return 1.0 if agreement >= 0 else -1.0


def _from_normals(points: Floats, normals: Floats) -> tuple[Floats, float]:
    """Center and signed radius that least squares gives p - r n = c."""
    mean_p, mean_n = points.mean(axis=0), normals.mean(axis=0)
    p, n = points - mean_p, normals - mean_n
    below = float((n * n).sum())
    radius = float((p * n).sum()) / below if below > 1e-12 else 0.0
    return mean_p - radius * mean_n, radius


def ball_through(points: Floats) -> tuple[Floats, float]:
    """Center and radius of |p|^2 = 2 p . c + d, in any dimension."""
    mean = points.mean(axis=0)
    p = points - mean
    design = np.concatenate([2 * p, np.ones((len(p), 1))], axis=1)
    solution = np.linalg.lstsq(design, (p**2).sum(axis=1), rcond=1e-9)[0]
    return solution[:-1] + mean, float(np.sqrt(max(solution[-1] + (solution[:-1] ** 2).sum(), 0.0)))


def _normals_or_estimates(problem: Problem) -> tuple[Floats, Floats]:
    """Felt normals, or least principal axes of each contact's neighbors, turned to one side of the middle."""
    if len(problem.felt) >= 3:
        return problem.normals, problem.points[problem.felt]
    points = problem.points
    if len(points) <= _NEIGHBORS:
        return np.empty((0, 3)), np.empty((0, 3))
    square = ((points[:, None] - points[None]) ** 2).sum(axis=2)
    near = points[np.argpartition(square, _NEIGHBORS, axis=1)[:, : _NEIGHBORS + 1]]
    centered = near - near.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", centered, centered))[1][:, :, 0]
    sides = np.sign(((points - problem.center) * normals).sum(axis=1))
    return normals * np.where(sides == 0, 1.0, sides)[:, None], points


def _cylinders_without_normals(points: Floats) -> list[Cylinder]:
    """The best three of many axes, each with its algebraic circle (Eberly's search, by fewer directions)."""
    axes = np.concatenate([hemisphere(_DIRECTIONS), _principal(points)[1].T])
    side = np.where(np.abs(axes[:, 2:]) < 0.9, np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]]))
    u = np.cross(axes, side)
    u = u / np.sqrt((u**2).sum(axis=1, keepdims=True))
    v = np.cross(axes, u)
    x, y = u @ points.T, v @ points.T  # (directions, n)
    square = x * x + y * y
    design = np.stack([2 * x, 2 * y, np.ones_like(x)], axis=2)
    scale = float(square.max())
    gram = np.einsum("dni,dnj->dij", design, design) + 1e-9 * scale * np.eye(3)
    solution = np.linalg.solve(gram, np.einsum("dni,dn->di", design, square)[..., None])[..., 0]
    radii = np.sqrt(np.maximum(solution[:, 2] + (solution[:, :2] ** 2).sum(axis=1), 1e-12))
    away = np.hypot(x - solution[:, :1], y - solution[:, 1:2]) - radii[:, None]
    best = np.argsort((away**2).sum(axis=1))[:3]
    return [Cylinder(solution[i, 0] * u[i] + solution[i, 1] * v[i], axes[i], float(radii[i])) for i in best]


def _tori_without_normals(problem: Problem) -> Iterator[Start]:
    """An axis through the middle, or the one that all estimated normals meet; then the circle in (rho, z).

    A line (n, p x n) meets the axis (c, x x c) where n . (x x c) + c . (p x n) = 0 (Pottmann and Wallner), which
    is linear and does not ask which way n points.
    """
    points = problem.points - problem.center
    axes = [(axis, np.zeros(3)) for axis in _principal(points)[1].T]
    normals, at = _normals_or_estimates(problem)
    if len(normals) >= 6:
        moments = np.cross(at - problem.center, normals)
        cross = np.linalg.lstsq(normals, moments, rcond=1e-9)[0]  # the moment that each direction c needs
        for axis in _principal(moments - normals @ cross)[1].T[:2]:
            axes += [(axis, np.cross(axis, -cross @ axis))]
    for axis, through in axes:
        offset = points - through
        z = offset @ axis
        rho = np.sqrt(np.maximum((offset**2).sum(axis=1) - z * z, 0.0))
        (radius, height), minor = ball_through(np.stack([rho, z], axis=1))
        if radius > 0 and minor > 0:
            yield Torus(problem.center + through + height * axis, axis, float(radius), minor), 1.0


def hemisphere(count: int) -> Floats:
    """(count, 3) directions spread evenly over half the sphere (Fibonacci's spiral)."""
    i = np.arange(count) + 0.5
    z, angle = i / count, i * np.pi * (1 + np.sqrt(5.0))
    rho = np.sqrt(1 - z * z)
    return np.stack([rho * np.cos(angle), rho * np.sin(angle), z], axis=1)

"""Triangles of one primitive, each labeled with the exact surface that it stands for.

Facets are volume-fair: the regular n-gon that stands for a circle of radius r has the circle's area, so its
corners lie at r sqrt(2 pi / (n sin(2 pi / n))), outside by about r pi^2 / (3 n^2) and at mid-side inside by half
of that; a sphere is an icosahedron's faces in n^2 parts each, put on the sphere and scaled to the ball's volume.
No facet departs from its surface by more than the tolerance (our derivation; tested on the meshes).  Who takes
the corners to be on the surface, as bare triangles make one, finds radii larger by what they are outside.
"""

import numpy as np

from models.csg import Cone, Cube, Cylinder, Polyhedron, Primitive, Prism, Sphere, Torus
from models.meshing.flat_facets import Facets, cube_facets, polyhedron_facets, prism_facets
from primitives import shapes
from primitives.arrays import Floats, Ints, frozen
from primitives.errors import PalpateError

_FEWEST = 32  # sides of the coarsest circle; through its corners a cone opens wider by no more than 0.1 deg
_MOST = 4096  # sides of the finest


def facets(primitive: Primitive, tolerance: float) -> Facets:
    """The mesh of a primitive whose facets stay within `tolerance` [mm] of its surface."""
    if not tolerance > 0:
        raise PalpateError(f"the facets' tolerance must be positive, not {tolerance} mm")
    match primitive:
        case Cube():
            return cube_facets(primitive)
        case Cylinder():
            r, half = primitive.radius, primitive.height / 2
            side = shapes.Cylinder(np.zeros(3), np.array([0.0, 0.0, 1.0]), r)
            return _turned([(r, -half), (r, half)], side, tolerance)
        case Cone():
            return _cone(primitive, tolerance)
        case Sphere():
            return _sphere(primitive, tolerance)
        case Torus():
            return _torus(primitive, tolerance)
        case Prism():
            return prism_facets(primitive)
        case Polyhedron():
            return polyhedron_facets(primitive)
    raise PalpateError(f"no facets for {primitive!r}; build it from the primitives of models.csg")


def sides_of_circle(radius: float, tolerance: float) -> int:
    """How many sides keep the corners of a volume-fair polygon within the tolerance, a multiple of four."""
    first_order = np.pi * np.sqrt(radius / (3 * tolerance))  # a little low
    n = int(np.ceil(first_order / 4)) * 4
    n = min(max(n, _FEWEST), _MOST)
    return n if n == _MOST or radius * (_fair_radius(n) - 1) <= tolerance else n + 4


def _cone(cone: Cone, tolerance: float) -> Facets:
    low, high, half = cone.bottom_radius, cone.top_radius, cone.height / 2
    slope = (low - high) / cone.height
    up = np.array([0.0, 0.0, 1.0])
    apex = np.array([0.0, 0.0, -half + low / slope])
    side = shapes.Cone(apex, -up if slope > 0 else up, float(np.arctan(abs(slope))))
    return _turned([(low, -half), (high, half)], side, tolerance)


def _turned(profile: list[tuple[float, float]], side: shapes.Shape, tolerance: float) -> Facets:
    """The solid under a profile of two (radius, height) points, the lower first, turned about z."""
    n = sides_of_circle(max(r for r, _ in profile), tolerance)
    circle = _fair_circle(n)
    vertices: list[Floats] = []
    rings: list[Ints] = []
    for radius, z in profile:
        start = sum(map(len, vertices))
        level = radius * circle if radius > 0 else np.zeros((1, 2))
        vertices.append(np.column_stack([level, np.full(len(level), z)]))
        rings.append(np.broadcast_to(start + np.arange(len(level)), (n,)))
    low, high = rings
    triangles = [np.stack([low, np.roll(low, -1), high], axis=1)] if profile[0][0] > 0 else []
    if profile[1][0] > 0:
        triangles.append(np.stack([np.roll(low, -1), np.roll(high, -1), high], axis=1))
    labels = [np.zeros(sum(map(len, triangles)), dtype=np.int64)]
    surfaces: list[shapes.Shape] = [side]
    for sign, (radius, z), ring in ((-1, profile[0], rings[0]), (1, profile[1], rings[1])):
        if radius > 0:
            fan = np.stack([np.full(n - 2, ring[0]), ring[1:-1], ring[2:]], axis=1)[:, ::sign]
            triangles.append(fan)
            labels.append(np.full(n - 2, len(surfaces)))
            surfaces.append(shapes.Plane(np.array([0.0, 0.0, z]), np.array([0.0, 0.0, float(sign)])))
    return Facets(
        frozen(np.concatenate(vertices)),
        frozen(np.concatenate(triangles), np.int64),
        frozen(np.concatenate(labels), np.int64),
        tuple(surfaces),
    )


def _torus(torus: Torus, tolerance: float) -> Facets:
    # both polygons bulge together on the outer equator, so each may take half of the tolerance; the ring scaled
    # by k and the tube by its root keep the volume (Pappus), every quad flat and every corner on one torus
    around = sides_of_circle(torus.major_radius + torus.minor_radius, tolerance / 2)
    along = sides_of_circle(torus.minor_radius, tolerance / 2)
    wider = _fair_radius(around)
    major, minor = wider * torus.major_radius, np.sqrt(wider) * torus.minor_radius
    crosses = minor * _fair_radius(along) >= major  # a corner at the axis; then a side faces it
    tube = minor * _fair_circle(along, 0.5 if crosses else 0.0)
    rho, z = (major + tube[:, 0]) / wider, tube[:, 1]
    ring = _fair_circle(around)
    points = np.concatenate(
        [rho[None, :, None] * ring[:, None], np.broadcast_to(z[None, :, None], (around, along, 1))], axis=2
    )
    number = np.arange(around * along).reshape(around, along)
    a, b = number, np.roll(number, -1, axis=0)
    c, d = np.roll(b, -1, axis=1), np.roll(number, -1, axis=1)
    triangles = np.concatenate(
        [np.stack(corners, axis=2).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))]
    )
    surface = shapes.Torus(np.zeros(3), np.array([0.0, 0.0, 1.0]), torus.major_radius, torus.minor_radius)
    return Facets(
        frozen(points.reshape(-1, 3)),
        frozen(triangles, np.int64),
        frozen(np.zeros(len(triangles)), np.int64),
        (surface,),
    )


def _fair_circle(n: int, first: float = 0.0) -> Floats:
    """(n, 2) corners of the regular polygon with the area of the unit circle, from `first` sides past x."""
    turn = 2 * np.pi / n * (np.arange(n) + first)
    fair: Floats = _fair_radius(n) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return fair


def _fair_radius(n: int) -> float:
    return float(np.sqrt(2 * np.pi / n / np.sin(2 * np.pi / n)))


def _sphere(sphere: Sphere, tolerance: float) -> Facets:
    # 20 n^2 equal triangles have edges L^2 = 4 pi r^2 / (5 sqrt(3) n^2) and mean depth L^2 / 8r;
    # 1.02 covers unequal ones
    n = int(np.ceil(np.sqrt(1.02 * np.pi * sphere.radius / (10 * np.sqrt(3) * tolerance))))
    directions, triangles = _geodesic(min(max(n, 4), _MOST // 8))
    a, b, c = np.moveaxis(directions[triangles], 1, 0)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
    fair = np.cbrt(4 * np.pi / 3 / volume)
    return Facets(
        frozen(sphere.radius * fair * directions),
        frozen(triangles, np.int64),
        frozen(np.zeros(len(triangles)), np.int64),
        (shapes.Sphere(np.zeros(3), sphere.radius),),
    )


def _geodesic(n: int) -> tuple[Floats, Ints]:
    """An icosahedron with every edge cut in n, on the unit sphere: 10 n^2 + 2 vertices, 20 n^2 triangles."""
    golden = (1 + np.sqrt(5)) / 2
    base = np.array([[0, s, t * golden] for s in (-1, 1) for t in (-1, 1)])
    corners = np.concatenate([np.roll(base, k, axis=1) for k in range(3)])
    corners /= np.linalg.norm(corners[0])
    near = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    side = near[near > 0].min()
    linked = np.abs(near - side) < 1e-9
    faces = [
        (a, b, c) if np.linalg.det(corners[[a, b, c]]) > 0 else (a, c, b)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if linked[a, b] and linked[b, c] and linked[a, c]
    ]
    rows, columns = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)]).T
    number = np.full((n + 1, n + 1), -1)
    number[rows, columns] = np.arange(len(rows))
    up = rows + columns < n
    down = up & (rows + columns < n - 1)
    i, j = rows[up], columns[up]
    patch = [np.stack([number[i, j], number[i + 1, j], number[i, j + 1]], axis=1)]
    i, j = rows[down], columns[down]
    patch.append(np.stack([number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]], axis=1))
    local = np.concatenate(patch)
    weights = np.sin(np.stack([n - rows - columns, rows, columns], axis=1) / n * _ICOSAHEDRON_EDGE)
    points = np.concatenate([weights @ corners[list(face)] for face in faces])
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = np.concatenate([local + k * len(rows) for k in range(len(faces))])
    _, first, same = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    return points[first], same.reshape(-1)[triangles]


_ICOSAHEDRON_EDGE = float(np.arctan(2.0))  # [rad] that an edge spans; weights by sine make parts nearly equal

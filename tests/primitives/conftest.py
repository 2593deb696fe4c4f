from collections.abc import Callable

import numpy as np
import pytest

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

SHAPES: dict[str, Shape] = {
    "plane": Plane([1.0, 2.0, 3.0], [1.0, 2.0, 2.0]),
    "cylinder": Cylinder([1.0, 2.0, 3.0], [1.0, 2.0, 2.0], 15.0),
    "cone": Cone([1.0, 2.0, 3.0], [1.0, 2.0, 2.0], 0.4),
    "sphere": Sphere([1.0, 2.0, 3.0], 15.0),
    "torus": Torus([1.0, 2.0, 3.0], [1.0, 2.0, 2.0], 20.0, 6.0),
}


def surface_points(shape: Shape, n: int, rng: np.random.Generator, arc: float = 2 * np.pi) -> Floats:
    """Points of the shape from its parametrization, not from its distance."""
    phi, z, tube = rng.uniform(0, arc, n), rng.uniform(-20, 20, n), rng.uniform(-np.pi, np.pi, n)
    if isinstance(shape, Plane):
        x, y, z = rng.uniform(-20, 20, n), z, 0.0 * z
    else:
        if isinstance(shape, Cylinder):
            rho = np.full(n, shape.radius)
        elif isinstance(shape, Cone):
            z = z + 35.0
            rho = z * np.tan(shape.semi_angle)
        elif isinstance(shape, Sphere):
            z = shape.radius * rng.uniform(-1, 1, n)
            rho = np.sqrt(shape.radius**2 - z**2)
        else:
            rho, z = shape.radius + shape.minor_radius * np.cos(tube), shape.minor_radius * np.sin(tube)
        x, y = rho * np.cos(phi), rho * np.sin(phi)
    return np.stack([x, y, z], axis=1) @ shape.frame.T + shape.anchor


@pytest.fixture(params=list(SHAPES))
def shape(request: pytest.FixtureRequest) -> Shape:
    return SHAPES[request.param]


@pytest.fixture
def on_surface() -> Callable[..., Floats]:
    return surface_points


@pytest.fixture
def touched() -> Callable[..., Contacts]:
    """Noisy contacts of a shape; without normals where `felt` is false; felt from inside where `sign` is -1."""

    def touch(
        shape: Shape,
        n: int,
        rng: np.random.Generator,
        sigma: float = 0.05,
        turn: float = 0.03,
        arc: float = 2 * np.pi,
        felt: bool = True,
        sign: float = 1.0,
    ) -> Contacts:
        points = surface_points(shape, n, rng, arc)
        normals = shape.normals(points)
        points = points + sigma * normals * rng.standard_normal((n, 1))
        normals = sign * normals + turn * rng.standard_normal((n, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return Contacts.of(points, normals if felt else None, max(sigma, 1e-3), max(turn, 1e-3))

    return touch

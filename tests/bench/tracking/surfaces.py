"""Bodies whose surface is stroked, each with its highest place under the origin, and what is true there."""

from dataclasses import dataclass

import numpy as np
import trimesh

from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.curvature import ORDERS

FACET = 0.001  # [mm] between a round wall and its facets
AROUND_CONE = 60.0  # [mm] of a cone's generator, either way, where its apex is not nearer


@dataclass(frozen=True)
class Body:
    """A body to stroke."""

    shape: Csg | np.ndarray  # or points, whose convex hull it is
    top: float  # [mm] height of its highest place
    radius: float  # [mm] of the sharpest normal section there
    kind: str
    tangent: float = 0.0  # by which that radius grows along x

    @property
    def order(self) -> str:
        """As `primitives.curvature` names it."""
        return self.kind if self.kind in ORDERS else "cylinder or cone"

    def solid(self) -> Solid:
        """Its mesh."""
        if isinstance(self.shape, np.ndarray):
            hull = trimesh.convex.convex_hull(self.shape)
            return Solid.from_mesh(np.asarray(hull.vertices), np.asarray(hull.faces))
        return Solid.from_csg(self.shape, FACET)


def cone(half_angle_deg: float, radius: float) -> Body:
    """A cone's flank, lying with a generator along x, its apex on the side of -x; z = 0 on it."""
    a = np.radians(half_angle_deg)
    place = radius / np.tan(a)  # [mm] from the apex, along the generator
    around = min(AROUND_CONE, place - 2.0)
    low, high = (place + around) * np.cos(a), (place - around) * np.cos(a)
    height = low - high
    upright = Cone(low * np.tan(a), high * np.tan(a), height).at(0.0, 0.0, -0.5 * (low + high))  # apex at 0
    lying = upright.turned("y", a - 0.5 * np.pi)
    return Body(lying.at(-place, 0.0, 0.0), 0.0, radius, "cone", float(np.tan(a)))


def cap(radius: float, half: float = 60.0, step: float = 2.0) -> np.ndarray:
    """(n, 3) points of a ball's top, over a square, and of a base: of a whole ball the facets are too many."""
    x, y = np.meshgrid(*[np.arange(-half, half + 0.5 * step, step)] * 2)
    z = np.sqrt(radius**2 - x**2 - y**2) - radius
    base = np.array([[sx * half, sy * half, -half] for sx in (-1, 1) for sy in (-1, 1)])
    return np.concatenate([np.stack([x, y, z], axis=-1).reshape(-1, 3), base])


BODIES: dict[str, Body] = {
    "plane": Body(Cube((160.0, 160.0, 40.0)), 20.0, np.inf, "plane"),
    "sphere R 15": Body(Sphere(15.0), 15.0, 15.0, "sphere"),
    "sphere R 60": Body(Sphere(60.0), 60.0, 60.0, "sphere"),
    "sphere R 500": Body(cap(500.0), 0.0, 500.0, "sphere"),
    "cylinder R 20": Body(Cylinder(20.0, 160.0).turned("y", np.pi / 2), 20.0, 20.0, "cylinder"),
    "cylinder R 150": Body(Cylinder(150.0, 160.0).turned("y", np.pi / 2), 150.0, 150.0, "cylinder"),
    "cylinder R 500": Body(Cylinder(500.0, 160.0).turned("y", np.pi / 2), 500.0, 500.0, "cylinder"),
    "cone 5 deg, R 20": cone(5.0, 20.0),
    "cone 15 deg, R 20": cone(15.0, 20.0),
    "cone 30 deg, R 30": cone(30.0, 30.0),
    "cone 45 deg, R 50": cone(45.0, 50.0),
}
ENDS: dict[str, Body] = {  # whose faces end near
    "cube's face": Body(Cube((80.0, 60.0, 40.0)), 20.0, np.inf, "plane"),
    "disc's face, R 30": Body(Cylinder(30.0, 20.0), 10.0, np.inf, "plane"),
    "cylinder's flank, R 20": Body(Cylinder(20.0, 60.0).turned("y", np.pi / 2), 20.0, 20.0, "cylinder"),
}

"""Outlines of about 100 mm and prisms to track, and how far a trace is from them."""

from typing import Any

import manifold3d
import numpy as np
from scipy.spatial import cKDTree

from models.csg import Cube, Cylinder, Prism
from models.solid import Solid

HEIGHT = 30.0  # [mm]
FACET = 0.001  # [mm] between a round wall and its facets
POINTS = 1500  # of an outline, whose chords lie as near


def prism(dihedral_deg: float, length: float = 200.0) -> Solid:
    """A triangular bar along z: its face y = 0 ends at x = 0 in an edge of this dihedral angle."""
    a = np.radians(dihedral_deg)
    corners = np.array([[-60.0, 0.0], [-60.0 * np.cos(a), -60.0 * np.sin(a)], [0.0, 0.0]])
    return Solid.from_csg(Prism(tuple(map(tuple, corners)), length))


def rounded_bar(radius: float, length: float = 200.0) -> Solid:
    """A square bar along z: its faces x = 0 and y = 0 meet in an edge that is rounded."""
    bar = Cube((60.0, 60.0, length)).at(-30.0, -30.0, 0.0)
    corner = Cube((2.0 * radius, 2.0 * radius, 1.1 * length))
    return Solid.from_csg(bar - corner | Cylinder(radius, length).at(-radius, -radius, 0.0), FACET)


def disc(radius: float) -> tuple[Solid, np.ndarray]:
    """A cylinder with its top at z = 0, and its outline."""
    t = np.linspace(0, 2 * np.pi, 4001)[:-1]
    ring = radius * np.column_stack([np.cos(t), np.sin(t)])
    solid = Solid.from_csg(Cylinder(radius, HEIGHT), FACET)
    down = np.eye(4)
    down[2, 3] = -0.5 * HEIGHT
    return solid.placed(down), ring


def plate(outline: np.ndarray) -> Solid:
    """An outline (n, 2), counterclockwise, with its top at z = 0."""
    section = manifold3d.CrossSection([outline])
    mesh = manifold3d.Manifold.extrude(section, HEIGHT).translate([0, 0, -HEIGHT]).to_mesh()
    return Solid.from_mesh(np.asarray(mesh.vert_properties[:, :3], float), np.asarray(mesh.tri_verts))


def rounded_square(half: float = 50.0, radius: float = 10.0) -> np.ndarray:
    """(n, 2) with its first point in the middle of a side."""
    s, quarter = half - radius, np.linspace(0, np.pi / 2, 400)
    centers = [(s, s), (-s, s), (-s, -s), (s, -s)]
    arcs = [
        np.add(c, radius * np.column_stack([np.cos(a), np.sin(a)]))
        for k, c in enumerate(centers)
        for a in [quarter + k * np.pi / 2]
    ]
    return even(np.concatenate([[[half, 0.0]], *arcs]))


def clover() -> np.ndarray:
    """(n, 2) r = 40 + 10 cos 4t."""
    t = np.linspace(0, 2 * np.pi, 8001)[:-1]
    r = 40.0 + 10.0 * np.cos(4.0 * t)
    return even(np.column_stack([r * np.cos(t), r * np.sin(t)]))


def foil(chord: float = 100.0, tip: float = 5.0) -> np.ndarray:
    """(n, 2) NACA 0012 opened by a disc, so that nothing is sharper than `tip` [mm]."""
    x = np.linspace(0, 1, 2000) ** 2
    y = 0.6 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    upper = chord * np.column_stack([x, y])
    section = manifold3d.CrossSection([np.concatenate([upper, (upper[::-1] * [1, -1])[1:-1]])[::-1]])
    round_join = manifold3d.JoinType.Round
    opened = section.offset(-tip, round_join, 2.0, 400).offset(tip, round_join, 2.0, 400)
    out = np.array(opened.to_polygons()[0])
    x, y = out.T
    out = out if x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0 else out[::-1]
    return even(out - [0.5 * chord, 0.0])


def even(outline: np.ndarray, count: int = POINTS) -> np.ndarray:
    """(count, 2) points at equal steps along a closed outline."""
    ring = np.concatenate([outline, outline[:1]])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    at = np.linspace(0, s[-1], count + 1)[:-1]
    return np.column_stack([np.interp(at, s, column) for column in ring.T])


def off_outline(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """(n,) [mm] from (n, 3) points to the outline at z = 0."""
    start, step = outline, np.roll(outline, -1, axis=0) - outline
    square = np.sum(step**2, axis=1)
    away = points[:, None, :2] - start
    along = np.clip(np.einsum("nmk,mk->nm", away, step) / square, 0.0, 1.0)
    flat = np.linalg.norm(away - along[:, :, None] * step, axis=2).min(axis=1)
    return np.hypot(flat, points[:, 2])


def share_traced(points: np.ndarray, outline: np.ndarray, near: float = 1.0) -> float:
    """Share of the points of an outline that have one of (n, 3) traced points within `near` [mm]."""
    return float(np.mean(cKDTree(points[:, :2]).query(outline)[0] < near))


def outlines() -> dict[str, tuple[Any, np.ndarray, int]]:
    """Solid, outline, and where on it tracking starts."""
    square, leaf, wing = rounded_square(), clover(), foil()
    return {
        "rounded square": (plate(square), square, 8),
        "clover": (plate(leaf), leaf, 112),
        "foil": (plate(wing), wing, 487),
    }

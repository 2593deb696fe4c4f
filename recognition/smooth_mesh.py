"""The mesh of the smooth surface through contacts, past no place that is empty, and over what flat faces will cut.

The surface is one of a Gaussian process (`primitives.implicit_surface`), through the contacts that are spread the
widest, and is told again of places on the wrong side of it.  It is meshed in the contacts' principal frame, on a
grid as fine as the body is thin, and the corners are moved onto it.  Ours.
"""

from __future__ import annotations

import numpy as np
import trimesh

from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.implicit_surface import ImplicitSurface, implicit_surface
from primitives.spread import spread

_MOST = 800  # contacts that it is made of
_COARSE = 20_000  # contacts that these are chosen of
_SIGMA, _LEAN = 0.05, 0.02  # [mm] and [rad] that no contact is better than
_ROUND = 3.0  # [mm] round all contacts that it may reach
_STEPS, _ACROSS = 40, 16  # of the grid along the longest side, and at least across the shortest
_NODES = 400_000  # of the grid, at most
_SMOOTH = 0.08  # [mm] that corners of the mesh are moved by, to have fewer,
_SMOOTHER = 0.02  # or of the shortest side, where that is less
_FARTHEST = 0.5  # [mm] that its corners are moved onto the surface
_CRUMB = 0.02  # of the volume, that may lie in pieces apart
_AT_ONCE = 200  # empty places that lie inside, and places of flat faces outside, that are told at a time
_TOLD_AGAIN = 3  # times they are
_INSIDE = 1.0  # [mm] on the other side, that they are told to be


def through(
    felt: Contacts, most: int = _MOST, elsewhere: Floats | None = None, outside: Floats | None = None
) -> ImplicitSurface:
    """The surface through so many of the contacts; (m, 3) places elsewhere lie (m,) [mm] outside of it.

    PalpateError where no surface has these contacts.
    """
    rows = np.arange(len(felt))
    if len(rows) > _COARSE:
        rows = np.random.default_rng(0).permutation(len(rows))[:_COARSE]
    kept = felt.select(rows[spread(felt.points[rows], most)])
    sigma, lean = np.maximum(kept.sigma, _SIGMA), np.maximum(kept.normal_sigma, _LEAN)
    return implicit_surface(kept.points, kept.normals, sigma, lean, elsewhere, outside)


def smooth_mesh(smooth: Contacts, room: Floats, cut: Floats, free: Floats | None) -> Solid | None:
    """The body inside the surface through smooth contacts, within (n, 3) places; None where it is in pieces.

    The faces that (m, 3) places lie on will `cut` it, and (k, 3) `free` ones are empty.  PalpateError where there
    is no surface, or nothing inside it.
    """
    sides = [(cut, -_INSIDE, 0.5 * _INSIDE), (np.empty((0, 3)) if free is None else free, _INSIDE, 0.0)]
    surface, told, away = through(smooth), [np.empty((0, 3))], [np.empty(0)]
    for _ in range(_TOLD_AGAIN):
        wrong = [(at[np.sign(side) * surface.values(at) < least], side) for at, side, least in sides]
        for places, side in wrong:
            told.append(places[spread(places, _AT_ONCE)])
            away.append(np.full(len(told[-1]), side))
        if not any(len(places) for places, _ in wrong):
            break
        surface = through(smooth, _MOST, np.concatenate(told), np.concatenate(away))
    whole = _settled(_on_grid(surface, room), surface)
    whole = whole.simplified(min(_SMOOTH, _SMOOTHER * float(whole.extent.min())))
    largest = whole.largest_part()
    return largest if whole.volume - largest.volume < _CRUMB * largest.volume else None


def _on_grid(surface: ImplicitSurface, room: Floats) -> Solid:
    """The body inside a surface round (n, 3) places, as a grid tells it."""
    middle = room.mean(axis=0)
    axes = np.linalg.svd(room - middle, full_matrices=False)[2]
    axes *= np.sign(np.linalg.det(axes))
    own = (room - middle) @ axes.T
    low, high = own.min(axis=0) - _ROUND, own.max(axis=0) + _ROUND
    sides = high - low
    step = min(float(sides.max()) / _STEPS, float(np.ptp(own, axis=0).min()) / _ACROSS)
    step = max(step, float(np.cbrt(sides.prod() / _NODES)))
    turned = Solid.from_field(lambda places: surface.values(places @ axes + middle), low, high, step)
    return Solid.from_mesh(turned.vertices @ axes + middle, turned.triangles)


def _settled(solid: Solid, surface: ImplicitSurface) -> Solid:
    """The same, its corners moved onto a surface that they lie near."""
    mesh = trimesh.Trimesh(solid.vertices, solid.triangles, process=False)
    away = np.clip(surface.values(solid.vertices), -_FARTHEST, _FARTHEST)
    return Solid.from_mesh(solid.vertices - away[:, None] * mesh.vertex_normals, solid.triangles)

"""The point of a mesh that a contact most likely touched: near, and with the normal that was felt.

With p and m the contact's point and normal and s, n those of the surface, the cost that is minimized over the
whole surface is::

    |p - s|^2 / sigma^2 + min(|m - n|^2 / tau^2, 2 log(2 / (TILTED tau^2)))

so that a contact beside an edge finds the face that its normal tells, not the nearest one (our derivation: the
exponent of the joint normal density).  A pad that lies on an edge feels a normal between its faces' normals, so a
share TILTED of contacts lies on the surface with any normal: the bound is where that becomes the likelier.

Nodes are pruned by the first term alone, and nothing beyond `cap` is looked for.  Normals are interpolated
between corners, which share them across edges flatter than `CREASE`, by angle (Thuermer and Wuethrich 1998).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from models.body import Body
from primitives.arrays import Bools, Floats, Ints

CREASE = np.deg2rad(30.0)  # [rad] a fold sharper than this is an edge of the object, not of its facets
_BESIDE = 1e-9  # barycentric coordinate of a point that is on a side
_SLIVER = 1e-6  # squared sine at a corner, below which these are too rough to tell: its sides may be edges
TILTED = 0.01  # share of contacts on the surface whose normal is not the surface's: pads that lay on an edge


class Facets(NamedTuple):
    """A mesh as the kernels read it."""

    corners: Floats  # (t, 3, 3) [mm]
    flat: Floats  # (t, 3) unit normals
    normals: Floats  # (t, 3, 3) at the corners, unit
    boxes: Floats  # (m, 6)
    nodes: Ints  # (m, 2)
    order: Ints  # (t,)
    sharp: Bools  # (t, 6) sides, from k to the next corner, and corners on edges; all where facets may be


def is_exact(body: Body) -> bool:
    """Whether the surfaces that a body's facets stand for are all known."""
    return body.remembered("exact", lambda: _exact(body))


def _exact(body: Body) -> bool:
    labels = np.unique(body.face_of_triangle)
    return bool((labels >= 0).all() and all(body.surfaces[k].shape is not None for k in labels))


def facets_of(body: Body) -> Facets:
    """Of a body's triangles, once for each body."""
    return body.remembered("facets", lambda: _made(body))


def _made(body: Body) -> Facets:
    tree = body.tree
    flat = np.ascontiguousarray(body.triangle_normals)
    corners = np.ascontiguousarray(body.vertices[body.triangles])
    at = body.triangles.ravel()
    order = np.argsort(at, kind="stable")
    first = np.searchsorted(at[order], np.arange(len(body.vertices) + 1))
    angles = _angles(corners).ravel()
    normals = _corner_normals(body.triangles, flat, angles, order, first, float(np.cos(CREASE)))
    _put_exact(body, corners, flat, normals)
    sharp = _sharp(body.triangles, flat, len(body.vertices)) | (not is_exact(body))
    return Facets(corners, flat, normals, *tree.arrays, sharp)


def _sharp(triangles: Ints, flat: Floats, vertices: int) -> Bools:
    """`Facets.sharp`; sides that any number but two of triangles share are edges."""
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    _, side, count = np.unique(ends[:, 0] * vertices + ends[:, 1], return_inverse=True, return_counts=True)
    total = np.stack([np.bincount(side, np.repeat(flat[:, k], 3)) for k in range(3)], axis=1)
    along = 0.5 * (total**2).sum(axis=1) - 1.0  # cosine between two of them
    sharp = ((count != 2) | (along < np.cos(CREASE)))[side]
    at = np.zeros(vertices, dtype=bool)
    at[ends[sharp].ravel()] = True
    return np.hstack([sharp.reshape(-1, 3), at[triangles]])


def _angles(corners: Floats) -> Floats:
    """(t, 3) [rad] of each corner: how much a triangle counts there, however its facet was cut into triangles."""
    to, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(to, back), axis=2)
    return np.asarray(np.arctan2(across, np.einsum("tki,tki->tk", to, back)))


def _put_exact(body: Body, corners: Floats, flat: Floats, normals: Floats) -> None:
    """The normals of the surfaces that facets stand for, where these are known."""
    for label, surface in enumerate(body.surfaces):
        rows = np.flatnonzero(body.face_of_triangle == label)
        if surface.shape is None or not len(rows):
            continue
        exact = surface.normals(corners[rows].reshape(-1, 3), normals[rows].reshape(-1, 3)).reshape(-1, 3, 3)
        good = np.isfinite(exact).all(axis=2) & (np.einsum("ijk,ik->ij", exact, flat[rows]) > np.cos(CREASE))
        normals[rows] = np.where(good[..., None], exact, normals[rows])


@njit(cache=True)
def _corner_normals(triangles, flat, angles, around, first, crease):  # type: ignore[no-untyped-def]
    out = np.empty((len(triangles), 3, 3))
    for t in range(len(triangles)):
        for k in range(3):
            v = triangles[t, k]
            x, y, z = 0.0, 0.0, 0.0
            for r in range(first[v], first[v + 1]):
                o = around[r] // 3
                along = flat[t, 0] * flat[o, 0] + flat[t, 1] * flat[o, 1] + flat[t, 2] * flat[o, 2]
                if along >= crease:
                    x += angles[around[r]] * flat[o, 0]
                    y += angles[around[r]] * flat[o, 1]
                    z += angles[around[r]] * flat[o, 2]
            length = np.sqrt(x * x + y * y + z * z)
            if length > 0.0:
                out[t, k, 0], out[t, k, 1], out[t, k, 2] = x / length, y / length, z / length
            else:
                out[t, k] = flat[t]
    return out


@njit(cache=True, nogil=True)
def likeliest(p, m, felt, sigma, tau, cap, mesh, stack, reach, found):  # type: ignore[no-untyped-def]
    """The least cost, or infinity where all cost more than `cap` and the bound.

    `found` becomes (s, n, t): the surface point, its normal, and the number of its triangle.

    `m` counts only where `felt`.  `stack` and `reach` are scratch of at least 64.
    """
    corners, flat, normals, boxes, nodes, order, _ = mesh
    best, over, spread = cap, 1.0 / (sigma * sigma), 1.0 / (tau * tau)
    bound = tilt_bound(tau)
    if felt:
        best += bound
    most = best
    stack[0], depth = 0, 1
    reach[0] = _away(p, boxes, 0) * over
    while depth > 0:
        depth -= 1
        if reach[depth] >= best:
            continue
        first, count = nodes[stack[depth], 0], nodes[stack[depth], 1]
        if count == 0:
            left, right = _away(p, boxes, first) * over, _away(p, boxes, first + 1) * over
            near, far = first, first + 1
            if right < left:
                near, far, left, right = far, near, right, left
            if right < best:
                stack[depth], reach[depth] = far, right
                depth += 1
            if left < best:
                stack[depth], reach[depth] = near, left
                depth += 1
            continue
        for k in range(first, first + count):
            t = order[k]
            if flat[t, 0] == 0.0 and flat[t, 1] == 0.0 and flat[t, 2] == 0.0:
                continue  # no area, and so no normal: its neighbors hold its places
            if felt and best < bound:
                along = m[0] * flat[t, 0] + m[1] * flat[t, 1] + m[2] * flat[t, 2]
                widest = np.sqrt(best) * tau + 0.5
                if widest < 3.0 and along < np.cos(widest):
                    continue
            u, v, away = _closest(p, corners[t])
            cost = away * over
            if cost >= best:
                continue
            w = 1.0 - u - v
            nx = w * normals[t, 0, 0] + u * normals[t, 1, 0] + v * normals[t, 2, 0]
            ny = w * normals[t, 0, 1] + u * normals[t, 1, 1] + v * normals[t, 2, 1]
            nz = w * normals[t, 0, 2] + u * normals[t, 1, 2] + v * normals[t, 2, 2]
            length = np.sqrt(nx * nx + ny * ny + nz * nz)
            nx, ny, nz = nx / length, ny / length, nz / length
            if felt:
                turned = (m[0] - nx) ** 2 + (m[1] - ny) ** 2 + (m[2] - nz) ** 2
                cost += min(turned * spread, bound)
            if cost < best:
                best = cost
                for axis in range(3):
                    a = corners[t, 0, axis]
                    found[axis] = a + u * (corners[t, 1, axis] - a) + v * (corners[t, 2, axis] - a)
                found[3], found[4], found[5], found[6] = nx, ny, nz, t
    return best if best < most else np.inf


@njit(cache=True, nogil=True)
def bent(corners, normals, k):  # type: ignore[no-untyped-def]
    """Into k (3, 3): by how much the normal turns along a triangle [1/mm], k e = n' - n over its two sides e."""
    uu, uv, vv = 0.0, 0.0, 0.0
    for a in range(3):
        u, v = corners[1, a] - corners[0, a], corners[2, a] - corners[0, a]
        uu, uv, vv = uu + u * u, uv + u * v, vv + v * v
    over = uu * vv - uv * uv
    over = 1.0 / over if over > 1e-12 * uu * vv else 0.0
    for b in range(3):
        u, v = corners[1, b] - corners[0, b], corners[2, b] - corners[0, b]
        du, dv = (vv * u - uv * v) * over, (uu * v - uv * u) * over
        for a in range(3):
            k[a, b] = (normals[1, a] - normals[0, a]) * du + (normals[2, a] - normals[0, a]) * dv


@njit(cache=True, nogil=True)
def on_edge(s, corners, sharp):  # type: ignore[no-untyped-def]
    """Whether a point (3,) of a triangle lies on a side or a corner of it that is an edge of the object."""
    uu, uv, vv, su, sv = 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(3):
        u, v, w = corners[1, a] - corners[0, a], corners[2, a] - corners[0, a], s[a] - corners[0, a]
        uu, uv, vv, su, sv = uu + u * u, uv + u * v, vv + v * v, su + w * u, sv + w * v
    over = uu * vv - uv * uv
    if over <= _SLIVER * uu * vv:
        return True
    second, third = (vv * su - uv * sv) / over, (uu * sv - uv * su) / over
    low, mid, high = 1.0 - second - third < _BESIDE, second < _BESIDE, third < _BESIDE
    if low and mid:
        return sharp[5]
    if mid and high:
        return sharp[3]
    if low and high:
        return sharp[4]
    return (high and sharp[0]) or (low and sharp[1]) or (mid and sharp[2])


@njit(cache=True, inline="always")
def tilt_bound(tau):  # type: ignore[no-untyped-def]
    """The cost of a normal beyond which it says no more than that the contact lay on an edge."""
    return 2.0 * np.log(1.0 + 2.0 / (TILTED * tau * tau))


@njit(cache=True, inline="always")
def _away(p, boxes, node):  # type: ignore[no-untyped-def]
    total = 0.0
    for axis in range(3):
        beyond = max(boxes[node, axis] - p[axis], p[axis] - boxes[node, 3 + axis], 0.0)
        total += beyond * beyond
    return total


@njit(cache=True)
def _closest(p, corners):  # type: ignore[no-untyped-def]
    """Barycentric (u, v) of the nearest point of a triangle, and its squared distance (Ericson 2005, 5.1.5)."""
    ax, ay, az = corners[0, 0], corners[0, 1], corners[0, 2]
    bx, by, bz = corners[1, 0] - ax, corners[1, 1] - ay, corners[1, 2] - az
    cx, cy, cz = corners[2, 0] - ax, corners[2, 1] - ay, corners[2, 2] - az
    px, py, pz = p[0] - ax, p[1] - ay, p[2] - az
    d1, d2 = bx * px + by * py + bz * pz, cx * px + cy * py + cz * pz
    bb, bc, cc = bx * bx + by * by + bz * bz, bx * cx + by * cy + bz * cz, cx * cx + cy * cy + cz * cz
    d3, d4, d5, d6 = d1 - bb, d2 - bc, d1 - bc, d2 - cc
    u, v = 0.0, 0.0
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0 and d2 <= 0:
        u = 0.0
    elif d3 >= 0 and d4 <= d3:
        u = 1.0
    elif vc <= 0 and d1 >= 0 and d3 <= 0:
        u = d1 / (d1 - d3)
    elif d6 >= 0 and d5 <= d6:
        v = 1.0
    elif vb <= 0 and d2 >= 0 and d6 <= 0:
        v = d2 / (d2 - d6)
    elif va <= 0 and d4 >= d3 and d5 >= d6:
        v = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        u = 1.0 - v
    else:
        u, v = vb / (va + vb + vc), vc / (va + vb + vc)
    x, y, z = px - u * bx - v * cx, py - u * by - v * cy, pz - u * bz - v * cz
    return u, v, x * x + y * y + z * z

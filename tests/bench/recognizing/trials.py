"""Contacts as a touch would leave them, at random places of an object at a random pose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from models.library import Entry
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points

NOISE = 0.3  # [mm] a coordinate
TURN = np.deg2rad(3.0) / np.sqrt(2.0)  # [rad] per tangent axis: 3 degrees in total


class Trial(NamedTuple):
    """One object somewhere, and what was felt of it."""

    name: str
    world: Floats  # (4, 4)
    contacts: Contacts


def trial(entry: Entry, count: int, one_sided: bool, rng: np.random.Generator, normals: bool = True) -> Trial:
    """So many contacts all round, or from one side only."""
    points, facing = on_surface(entry.solid, count, one_sided, rng)
    world = pose(random_rotation(rng), rng.uniform(-60.0, 60.0, 3))
    facing = facing + TURN * rng.standard_normal(facing.shape)
    facing = rotate(world, facing / np.linalg.norm(facing, axis=1, keepdims=True))
    points = transform_points(world, points) + NOISE * rng.standard_normal(points.shape)
    return Trial(entry.name, world, Contacts.of(points, facing if normals else None, NOISE, TURN))


def astray(t: Trial, entry: Entry, count: int, rng: np.random.Generator) -> Trial:
    """So many of the contacts met something else, 5 to 30 mm off; half of their normals are any."""
    points, normals = t.contacts.points.copy(), t.contacts.normals.copy()
    for row in rng.permutation(len(points))[:count]:
        while True:
            at, facing = on_surface(entry.solid, 1, False, rng)
            at = at + rng.uniform(5.0, 30.0) * random_rotation(rng)[:, 2]
            if entry.solid.signed_distance(at)[0] >= 5.0:
                break
        turned = random_rotation(rng)[:, 2][None] if rng.random() < 0.5 else facing
        points[row], normals[row] = transform_points(t.world, at)[0], rotate(t.world, turned)[0]
    return t._replace(contacts=Contacts.of(points, normals, NOISE, TURN))


def on_surface(solid: Solid, count: int, one_sided: bool, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """(n, 3) points and (n, 3) normals in the object's frame, even by area."""
    body = solid.body
    a, b, c = np.moveaxis(body.vertices[body.triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    many = 40 * count if one_sided else count
    t = rng.choice(len(area), many, p=area / area.sum())
    r, w = np.sqrt(rng.random((many, 1))), rng.random((many, 1))
    points = (1 - r) * a[t] + r * (1 - w) * b[t] + r * w * c[t]
    facing = body.exact_normals(points, t)
    if one_sided:
        view = random_rotation(rng)[:, 2]
        seen = facing @ view > 0.1
        away = points + 0.01 * facing
        blocked = solid.placed(np.eye(4)).first_hits(
            np.ascontiguousarray(away, dtype=np.float32),
            np.ascontiguousarray(np.tile(view, (many, 1)), dtype=np.float32),
        )[1]
        rows = np.flatnonzero(seen & (blocked < 0))[:count]
        points, facing = points[rows], facing[rows]
    return points, facing


def add_s(entry: Entry, found: Floats, true: Floats) -> float:
    """Mean distance from each sample at the true pose to the surface at the pose found, over the diagonal."""
    points = entry.samples.points[:300]
    there = transform_points(np.linalg.inv(found) @ true, points)
    off = np.abs(entry.solid.placed(np.eye(4)).signed_distance(there))
    return float(off.mean() / np.linalg.norm(entry.solid.extent))

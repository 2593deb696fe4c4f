"""Contacts on a known part, each with the face that it lies on: what clouds are judged by."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from models.boundary import labeled_boundary
from models.generate import generate
from models.part import load_part
from models.parts import names
from models.solid import Solid
from primitives.arrays import Ints
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points

DATA = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[4] / "shared")) / "parts"
SIZES = (60.0, 160.0)  # [mm] between which the longest side of a file's part is brought
_UNKNOWN = 1e-6  # [mm] sigma of contacts that are exact


@dataclass(frozen=True)
class Cloud:
    """Contacts, and the truth about each."""

    contacts: Contacts
    face: Ints  # (n,) of the part
    kinds: tuple[str, ...]  # of its faces


def sampled(
    solid: Solid,
    count: int,
    rng: np.random.Generator,
    sigma: float,
    tilt: float,
    normals: bool = True,
    scale: float = 1.0,
) -> Cloud:
    """Points spread evenly, `sigma` [mm] off along each axis, normals off by `tilt` [rad] each way."""
    brep, of_triangle = labeled_boundary(solid)
    corners = solid.body.vertices[solid.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    picked = rng.choice(len(area), size=count, p=area / area.sum())
    u, v = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    points = np.einsum("nk,nkj->nj", weights, corners[picked])
    outward = cross[picked] / np.linalg.norm(cross[picked], axis=1, keepdims=True)
    for f, face in enumerate(brep.faces):
        rows = np.flatnonzero(of_triangle[picked] == f)
        if face.shape is None or not len(rows):
            continue
        points[rows] = face.shape.project(points[rows])
        true = face.shape.normals(points[rows])
        outward[rows] = true * np.sign((true * outward[rows]).sum(axis=1, keepdims=True))
    points = scale * transform_points(solid.pose, points) + sigma * rng.normal(size=points.shape)
    outward = rotate(solid.pose, outward)
    noise = tilt * rng.normal(size=points.shape)
    noise -= (noise * outward).sum(axis=1, keepdims=True) * outward
    outward = outward + noise
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    each = np.arange(count)  # a touch of its own, as in a table that is read
    contacts = Contacts.of(
        points, outward if normals else None, max(sigma, _UNKNOWN), max(tilt, 1e-4), touch=each, stroke=each
    )
    return Cloud(contacts, of_triangle[picked], tuple(face.kind for face in brep.faces))


def step_parts() -> Iterator[tuple[str, Solid]]:
    """The STEP files of the outside data, none where it is not there."""
    for file in sorted(DATA.glob("*")) if DATA.is_dir() else []:
        if file.suffix.lower() in (".step", ".stp"):
            try:
                largest = float(load_part(file).solid.extent.max())
                size = float(np.clip(largest, *SIZES))
                yield file.stem, load_part(file, scale=size / largest).solid
            except PalpateError as error:
                print(f"{file.name} left out: {error}", file=sys.stderr)


def builtin_parts(only: tuple[str, ...] = ()) -> Iterator[tuple[str, Solid, float]]:
    """The built-in parts, each at an attitude and a size (0.9 to 1.1 of its own) that makes no number round."""
    for k, name in enumerate(names()):
        if not only or name in only:
            rng = np.random.default_rng(k)
            exact = load_part(name).solid.placed(pose(random_rotation(rng), rng.uniform(-20, 20, 3)))
            yield name, exact, float(rng.uniform(0.9, 1.1))


def generated_parts(count: int, first: int = 1000) -> Iterator[tuple[str, Solid]]:
    """Random parts with up to six features."""
    for k in range(first, first + count):
        rng = np.random.default_rng(k)
        yield f"generated{k}", Solid.from_csg(generate(rng, int(rng.integers(0, 7))))

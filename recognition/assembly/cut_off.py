"""Where the body ends that no felt face closes: at the last contacts, along the directions that it has.

Three directions across each other, those of flat faces and of the most contacts first, then those along which the
contacts spread (our derivation).  Where no contact as far out as they reach looks along one of them, a plane there
ends the body; or where one does, but the surface that it is on does not end what was assembled.  Nobody felt that
plane, and more of the object may be behind it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.pose import frame_along
from primitives.shapes import Cylinder, Sphere


@dataclass(frozen=True)
class CutOffConfig:
    """When a direction is closed, and how a plane that closes it is written down."""

    least: float = 2.0  # [mm] that the contacts reach along a direction; else it has no ends
    upright: float = 0.1  # most cosine between two directions of the faces
    looks: float = 0.95  # least cosine of the way that a contact looks which closes a direction
    off: float = 1.0  # [mm] of such a contact from the last one
    past: float = 15.0  # [mm] past the last contact, that a body runs on
    last: float = 3.0  # [mm] from the last contact, of those that tell where on the plane the body is
    behind: float = 0.7  # [mm] behind their own faces, where there is material
    beside: float = 0.3  # [mm] round each of these places on the plane, so that they tell how it lies
    sigma: float = 0.5  # [mm]
    normal_sigma: float = 0.05  # [rad]


class FittedFace(Protocol):
    """A face as exploration leaves it."""

    @property
    def fit(self) -> Fit:
        """Its surface."""
        ...

    @property
    def contacts(self) -> Contacts:
        """The evidence for it."""
        ...


def cut_off(
    faces: Sequence[FittedFace], corners: Floats | None = None, config: CutOffConfig = CutOffConfig()
) -> list[Contacts]:
    """Contacts of each plane that ends the body where no face does; nobody felt them.

    (n, 3) `corners` [mm] are of the body that the faces bound as they are, where they bound one.
    """
    felt = Contacts.concatenate([face.contacts for face in faces])
    felt = felt.select(felt.has_normal)
    if not len(felt):
        return []
    inside = felt.points - config.behind * felt.normals
    out: list[Contacts] = []
    for axis in _directions(faces, felt.points, config):
        if float(np.ptp(felt.points @ axis)) < config.least:
            continue
        for way in (axis, -axis):
            end = float((felt.points @ way).max())
            near = felt.points @ way > end - config.off
            looked = (felt.normals[near] @ way > config.looks).any()
            runs_on = corners is not None and float((corners @ way).max()) > end + config.past
            if not runs_on and (looked or any(_ends(f, way, end, config) for f in faces)):
                continue
            last = inside[felt.points @ way > end - config.last]
            on = last + np.outer(end - last @ way, way)
            aside = config.beside * frame_along(way)[:, :2].T
            places = np.concatenate([on + step for step in (*aside, *-aside)])
            normals = np.broadcast_to(way, places.shape)
            out.append(Contacts.of(places, normals, config.sigma, config.normal_sigma, touch=NOT_FELT))
    return out


def _directions(faces: Sequence[FittedFace], points: Floats, config: CutOffConfig) -> list[Floats]:
    """Three unit directions across each other."""
    ways: list[Floats] = []
    for face in sorted(faces, key=lambda face: (face.fit.kind != "plane", -len(face.contacts))):
        way = face.fit.shape.direction if face.fit.shape.tilts else None
        if way is not None and len(ways) < 2 and all(abs(float(way @ w)) < config.upright for w in ways):
            across = way - sum((float(way @ w) * w for w in ways), np.zeros(3))
            ways.append(across / np.linalg.norm(across))
    spread = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    for way in (*spread, *np.eye(3)):
        across = way - sum((float(way @ w) * w for w in ways), np.zeros(3))
        if len(ways) < 3 and np.linalg.norm(across) > 0.5:
            ways.append(across / np.linalg.norm(across))
    return ways


def _ends(face: FittedFace, way: Floats, end: float, config: CutOffConfig) -> bool:
    """Whether a round face, by its own shape, ends the body along a (3,) way, as far out as the contacts reach."""
    shape = face.fit.shape
    if not face.fit.convex or not isinstance(shape, Cylinder | Sphere):
        return False
    upright = isinstance(shape, Sphere) or abs(float(shape.axis @ way)) < config.upright
    return upright and float(shape.anchor @ way) + shape.radius > end - config.off

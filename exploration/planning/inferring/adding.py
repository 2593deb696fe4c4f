"""Adding inferred faces to what was found: as faces of their own, or joined to those that they turn out to be.

What was felt says where a face is; inferred contacts on it say only how far it goes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from exploration.planning.touching.findings import Findings
from primitives.arrays import frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, NoFit, fit
from primitives.patch_graph import Face
from primitives.surface_sigma import distance_sigma

_ALIKE = 0.95  # least cosine between inferred contacts and a face that they belong to
_PARALLEL = 0.998  # least cosine between the normals of an inferred wall and a felt face that are parallel
_SQUARE = 0.002  # most cosine between the normals of two felt faces that stand across each other
_OFF = 3.0  # sigmas of theirs, that they lie off it at most


def add(found: Findings, lot: Contacts, why: str, kind: str = "plane") -> Fit | None:
    """Add a face that is known to be of one `kind`, or join it to the one that it turns out to be; its fit."""
    lot = straightened(lot, found.graph.faces) if kind == "plane" else lot
    home = home_of(found.graph.faces, lot, kind)
    both = lot if home is None else _joined(home, lot, found.graph.faces)
    made = fit(kind, lot) if home is None else _widened(home, both)
    if home is not None and isinstance(made, Fit):
        change(found, lambda face: Face(face.id, made, both) if face is home else face)
    elif home is None and isinstance(made, Fit):
        number = found.graph.next_id
        found.graph = replace(found.graph, faces=(*found.graph.faces, Face(number, made, lot)))
    found.warnings.append(why)
    return made if isinstance(made, Fit) else None


def once(lots: Iterable[Contacts]) -> list[Contacts]:
    """Each wall once, as it is known best: of lots that look one way from one plane, the surest."""
    kept: list[Contacts] = []
    for lot in sorted(lots, key=lambda lot: float(lot.sigma.max())):
        normal, at = lot.normals[0], lot.points[0]
        alike = (
            other
            for other in kept
            if float(other.normals[0] @ normal) > _PARALLEL
            and abs(float((other.points[0] - at) @ normal)) < _OFF * float(lot.sigma.max())
        )
        if next(alike, None) is None:
            kept.append(lot)
    return kept


def add_own(found: Findings, lot: Contacts, why: str, kind: str) -> Fit | None:
    """Add a face of its own, which may be near another that looks its way and is none of it, where one fits."""
    made, number = fit(kind, lot), found.graph.next_id
    if not isinstance(made, Fit):
        return None
    found.graph = replace(found.graph, faces=(*found.graph.faces, Face(number, made, lot)))
    found.warnings.append(why)
    return made


def home_of(faces: Sequence[Face], lot: Contacts, kind: str) -> Face | None:
    """The face that inferred contacts lie on and face like: one that was felt, or inferred as of the same kind.

    They lie off it by at most `_OFF` sigmas, of theirs and of the surface there together: a round face felt on one
    side only is unsure of its other.  A flat one is held to theirs alone, or it would take in walls beside it.
    """
    best: tuple[float, Face] | None = None
    for face in faces:
        if not isinstance(face.fit, Fit) or not (face.fit.kind == kind or _felt(face)):
            continue
        side = 1.0 if face.fit.convex else -1.0
        facing = side * (face.fit.shape.normals(lot.points) * lot.normals).sum(axis=1)
        sigma = lot.sigma if kind == "plane" else np.hypot(lot.sigma, distance_sigma(face.fit, lot.points))
        off = np.abs(face.fit.shape.signed_distance(lot.points)) / sigma
        if float(facing.min()) > _ALIKE and float(off.max()) < min(_OFF, np.inf if best is None else best[0]):
            best = float(off.max()), face
    return None if best is None else best[1]


def straightened(lot: Contacts, faces: Sequence[Face]) -> Contacts:
    """Contacts of an inferred wall, put on one plane where that is parallel to a felt flat face, or across two.

    A few rims tell where a wall is to a tenth of a millimeter each, and each stands for many contacts: a plane
    through them all would lean by what the rims err.  One that leans by more than that is left as it is.
    """
    ways = [
        face.fit.shape.direction
        for face in faces
        if isinstance(face.fit, Fit) and face.fit.kind == "plane" and _felt(face)
    ]
    ways += [np.cross(a, b) for a, b in combinations(ways, 2) if abs(float(a @ b)) < _SQUARE]
    mean = lot.normals.mean(axis=0)
    nearest = max(ways, key=lambda way: abs(float(way @ mean)), default=None)
    if nearest is None or not abs(float(nearest @ mean)) >= _PARALLEL:
        return lot
    normal = nearest * np.sign(nearest @ mean) / np.linalg.norm(nearest)
    off = lot.points @ normal
    if float(off.std()) > _OFF * float(np.median(lot.sigma)):
        return lot
    points = lot.points - np.outer(off - off.mean(), normal)
    return replace(lot, points=frozen(points), normals=frozen(np.broadcast_to(normal, points.shape)))


def change(found: Findings, other: Callable[[Face], Face]) -> None:
    """Put another face in the place of each."""
    found.graph = replace(found.graph, faces=tuple(other(face) for face in found.graph.faces))


def _joined(home: Face, lot: Contacts, faces: Sequence[Face]) -> Contacts:
    """Those of a face and inferred ones; whoever fits them again finds a face that nobody felt as straight."""
    both = Contacts.concatenate([home.contacts, lot])
    flat = isinstance(home.fit, Fit) and home.fit.kind == "plane" and not _felt(home)
    return straightened(both, faces) if flat else both


def _widened(home: Face, both: Contacts) -> Fit | NoFit:
    """The fit of a face with inferred contacts: what was felt says where it is, and they only how far it goes."""
    if not isinstance(home.fit, Fit):
        return home.fit
    if not _felt(home):
        return fit(home.fit.kind, both)
    more = np.zeros(len(both) - len(home.contacts))
    return replace(home.fit, inliers=frozen(np.append(home.fit.inliers, more), bool))


def _felt(face: Face) -> bool:
    return bool((face.contacts.touch != NOT_FELT).any())

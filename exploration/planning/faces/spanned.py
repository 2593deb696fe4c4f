"""Round faces of which pads spanned several facets at a time, and what became of them.

A pad that lies on three facets of a coarse mesh reads a round face, and normals that lean with the facets: trusted
as those of smooth skin they pull its place aside.  Where most of them disagree with the face so, it is fitted by
where it was felt.  Such a face, and another that lies in it, are one (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from scipy.spatial import KDTree

from primitives.arrays import frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face
from primitives.shapes import Sphere

_ROUND = "cylinder", "cone", "sphere"
_MANY = 30  # contacts of a round face that a pad could span facets of
_ALONE = 1_000_000  # more touches than any exploration makes


@dataclass(frozen=True)
class SpannedConfig:
    """When a face was read off facets, and when two are one."""

    leaning: float = 3.0  # [sigma] that its normals lean for the most part
    normal_sigma: float = 0.1  # [rad] that they are believed to from there on
    rms: float = 0.15  # [mm] of contacts from one face
    on: float = 0.25  # [mm] from another face, of contacts that lie in it,
    mostly: float = 0.9  # and their share at least;
    among: float = 6.0  # [mm] from one of that face's own contacts,
    mixed: float = 0.5  # and the share of them, and of those beside it along its axis


def spanned(
    faces: Sequence[Face], config: SpannedConfig = SpannedConfig()
) -> tuple[list[Face], dict[int, int]]:
    """The faces, fitted by where they were felt if read off facets, and the ids that others have taken."""
    found, gone = [_eased(face, config) for face in faces], dict[int, int]()
    while (twins := _twins(found, config)) is not None:
        found, gone = put_in(*twins, found, gone)
    return found, gone


def put_in(
    whole: Face, ids: Sequence[int], faces: Sequence[Face], gone: dict[int, int]
) -> tuple[list[Face], dict[int, int]]:
    """The faces with one in place of those of some ids, its own too; and which ids have `gone` to others."""
    now = {old: whole.id for old in ids if old != whole.id}
    kept = [whole if face.id == whole.id else face for face in faces if face.id not in now]
    return kept, {old: now.get(new, new) for old, new in gone.items()} | now


def is_round(face: Face) -> bool:
    """Whether a face is round, and was felt well."""
    felt = int((face.contacts.touch != NOT_FELT).sum())
    return isinstance(face.fit, Fit) and face.fit.kind in _ROUND and felt >= _MANY


def fit_of(face: Face) -> Fit:
    """Of a face that has a shape."""
    assert isinstance(face.fit, Fit)
    return face.fit


def lies_in(other: Face, one: Face, config: SpannedConfig = SpannedConfig()) -> bool:
    """Whether most contacts of a round face lie as those of another do, among them and beside them."""
    own, shape = fit_of(one), fit_of(one).shape
    if own.kind != fit_of(other).kind or own.convex != fit_of(other).convex:
        return False
    felt, side = other.contacts, 1.0 if own.convex else -1.0
    near = np.abs(shape.signed_distance(felt.points)) < config.on
    alike = (side * shape.normals(felt.points) * felt.normals).sum(axis=1) > np.cos(config.normal_sigma)
    among = KDTree(one.contacts.points).query(felt.points)[0] < config.among
    lies = float(np.mean(near & alike)) > config.mostly and float(np.mean(among)) > config.mixed
    return lies and along_axis(felt, one) > config.mixed


def along_axis(felt: Contacts, one: Face) -> float:
    """Share of contacts that lie where a face was felt, along its axis; of a ball all do."""
    shape = fit_of(one).shape
    if isinstance(shape, Sphere):
        return 1.0
    mine, theirs = one.contacts.points @ shape.direction, felt.points @ shape.direction
    return float(np.mean((theirs > mine.min()) & (theirs < mine.max())))


def alone(felt: Contacts, number: int) -> Contacts:
    """Contacts of a face as touches of their own: what those of one facet are off by is no error of a stage."""
    touch = _ALONE * (number + 1) + np.arange(len(felt))
    return replace(felt, touch=frozen(np.where(felt.touch == NOT_FELT, NOT_FELT, touch), np.int64))


def off_facets(face: Face) -> bool:
    """Whether a face was read off facets."""
    return is_round(face) and bool((face.contacts.touch >= _ALONE).any())


def _eased(face: Face, config: SpannedConfig) -> Face:
    """The face, fitted by where it was felt, if its normals lean as those of facets do that a pad spans."""
    felt = face.contacts
    if not is_round(face):
        return face
    own = fit_of(face)
    cosine = np.abs((own.shape.normals(felt.points) * felt.normals).sum(axis=1))
    if not float(np.median(np.arccos(np.clip(cosine, 0.0, 1.0)) / felt.normal_sigma)) > config.leaning:
        return face
    eased = replace(felt, normal_sigma=frozen(np.maximum(felt.normal_sigma, config.normal_sigma)))
    found = fit(own.kind, eased)
    if not isinstance(found, Fit) or found.convex != own.convex or found.rms > config.rms:
        return face
    return replace(face, fit=found, contacts=alone(eased, face.id), ranked=())


def _twins(faces: Sequence[Face], config: SpannedConfig) -> tuple[Face, list[int]] | None:
    """One face for two round ones of which one lies in the other, that was read off facets; and their ids."""
    for one, other in permutations(filter(is_round, faces), 2):
        if len(one.contacts) < len(other.contacts) or not (off_facets(one) or off_facets(other)):
            continue
        if not lies_in(other, one, config):
            continue
        both = Contacts.concatenate([one.contacts, other.contacts])
        eased = replace(
            both,
            sigma=frozen(np.maximum(both.sigma, config.rms)),
            normal_sigma=frozen(np.maximum(both.normal_sigma, config.normal_sigma)),
        )
        found, ids = fit(fit_of(one).kind, eased), [one.id, other.id]
        if isinstance(found, Fit) and found.convex == fit_of(one).convex and found.rms < config.rms:
            return Face(min(ids), found, alone(eased, min(ids))), ids
    return None

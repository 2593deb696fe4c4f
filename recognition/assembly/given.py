"""What a body is assembled of: faces turned outward and regularized, one speaking for all that coincide."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.plate import Plate
from primitives.shapes import Plane, Shape
from primitives.touch_errors import fits_of_touches
from recognition.assembly.regularities import RegularityOptions, Regularized, regularize

_HEARSAY = 4  # inferred contacts that count as much as one that was felt


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


@dataclass(frozen=True)
class Given:
    """What is known of the body; of surfaces that coincide the first speaks for all."""

    faces: Sequence[FittedFace]
    fits: tuple[Fit, ...]
    regularized: Regularized
    speaker: Sequence[int]  # of each fit
    distinct: Sequence[int]  # speakers
    touched: Sequence[tuple[Floats, Floats]]  # of each speaker (n, 3) places and (n, 3) normals
    free: Floats | None  # (n, 3) [mm] where nothing is
    stray: Floats  # (n, 3) [mm] felt on no face
    plates: Sequence[Plate] = ()

    @property
    def shapes(self) -> list[Shape]:
        """Of the speakers."""
        return [self.regularized.shapes[i] for i in self.distinct]

    @property
    def inferred(self) -> list[bool]:
        """Whether nobody felt what a speaker speaks for."""
        return [
            all(
                (self.faces[i].contacts.touch == NOT_FELT).all()
                for i, s in enumerate(self.speaker)
                if s == own
            )
            for own in self.distinct
        ]

    def without(self, numbers: Collection[int]) -> Given:
        """Less some of the speakers, by their place among them."""
        kept = [k for k in range(len(self.distinct)) if k not in numbers]
        return replace(
            self, distinct=[self.distinct[k] for k in kept], touched=[self.touched[k] for k in kept]
        )

    @staticmethod
    def of(
        faces: Sequence[FittedFace],
        regularity: RegularityOptions,
        free: Floats | None,
        stray: Floats | None,
        plates: Sequence[Plate] = (),
    ) -> Given:
        """Faces with their planes turned outward, regularized together."""
        fits = tuple(outward(fit) for fit in fits_of_touches(faces))
        regularized = regularize(fits, regularity)
        speaker = _speakers(len(fits), regularized)
        distinct = sorted(set(speaker))
        touched = [_touched(regularized.shapes[i], i, speaker, fits, faces) for i in distinct]
        lone = np.empty((0, 3)) if stray is None else stray
        return Given(faces, fits, regularized, speaker, distinct, touched, free, lone, plates)


def outward(fit: Fit) -> Fit:
    """The same fit, with a plane's normal turned away from the material."""
    if fit.convex or not isinstance(fit.shape, Plane):
        return fit
    turned = Plane(fit.shape.origin, -fit.shape.normal)
    flip = np.zeros((3, 3))
    flip[0, 0] = -1.0
    flip[1:, 1:] = -turned.frame[:, :2].T @ fit.shape.frame[:, :2]
    return replace(fit, shape=turned, covariance=frozen(flip @ fit.covariance @ flip.T), convex=True)


def _speakers(count: int, regularized: Regularized) -> list[int]:
    speaker = list(range(count))
    for relation in regularized.relations:
        if relation.kind == "coincident":
            low, high = sorted(speaker[i] for i in relation.faces)
            speaker = [low if s == high else s for s in speaker]
    return speaker


def _touched(
    shape: Shape, speaker_of: int, speaker: Sequence[int], fits: Sequence[Fit], faces: Sequence[FittedFace]
) -> tuple[Floats, Floats]:
    """Contacts of every face on a surface, put on it, with the normals it has there; few of those inferred."""
    mine = [faces[i].contacts for i, s in enumerate(speaker) if s == speaker_of]
    felt = Contacts.concatenate(mine)
    felt = felt.select((felt.touch != NOT_FELT) | (np.arange(len(felt)) % _HEARSAY == 0))
    points = shape.project(felt.points)
    normals = shape.normals(points)
    known = felt.has_normal
    facing = np.where(known, (np.nan_to_num(felt.normals) * normals).sum(axis=1), 0.0)
    side = 1.0 if fits[speaker_of].convex or isinstance(shape, Plane) else -1.0
    sign = np.where(known, np.sign(facing), side)
    return points, normals * sign[:, None]

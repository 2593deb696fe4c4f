"""What touch has given, and what was known before: the input of matching.

n contacts whose errors correlate by r are worth n / (1 + r (n - 1)) of independent ones (Kish 1965).  Those of one
touch share its pose's error; those of different touches, the closer they lie the more, what the surface there
differs from the model, so that n - 1 is, for each, the sum of exp(-d^2 / 2 l^2) over the others (our derivation).

Contacts may carry normals or not, and free space bounds where material can be.  Lengths are in mm.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial.distance import cdist

from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.evidence import Contacts, EdgeTrace, FreeSpace, Imprint
from primitives.shapes import Shape
from recognition.matching.round_face import round_face

ALIKE = 0.1  # share of the error's variance that contacts of one touch have in common
WIDE = 200.0  # [mm] of a prior round contacts, where nobody told it
_FREE = 6  # numbers of a pose
BESIDE = 6.0  # [mm] over which the surface's own departure from the model is much the same


@dataclass(frozen=True)
class Evidence:
    """All that is known of one object by touch."""

    contacts: Contacts
    traces: tuple[EdgeTrace, ...] = ()
    free: FreeSpace | None = None
    scale_known: bool = True  # whether the contacts' sigma is theirs; else it is estimated with the pose
    normal_scale_known: bool = True  # the same of their normals
    untouched: Floats = field(
        default_factory=lambda: np.empty((0, 3))
    )  # (m, 3) [mm] of the pressed skin, that
    # felt nothing
    missed: FreeSpace | None = None  # what approaches swept that met nothing
    imprints: tuple[Imprint, ...] = ()  # what the whole skin felt of each touch

    def checked(self) -> Evidence:
        """Itself without broken rows, its noise taken for told where it cannot be; raises if nothing is left."""
        c = self.contacts
        whole = np.isfinite(c.points).all(axis=1) & np.isfinite(c.sigma) & (c.sigma > 0)
        if not whole.any():
            raise PalpateError(
                "there is no contact to match; give at least one row x,y,z of finite numbers in mm"
            )
        kept = self if whole.all() else replace(self, contacts=c.select(whole))
        return kept if kept._tells_noise() else replace(kept, scale_known=True, normal_scale_known=True)

    def _tells_noise(self) -> bool:
        """Whether more numbers were felt than a pose has: no more fit some pose exactly, whatever their noise."""
        return len(self.contacts) + 2 * int(self.contacts.has_normal.sum()) > _FREE

    def with_contacts(self, more: Contacts) -> Evidence:
        """After further contacts."""
        return replace(self, contacts=Contacts.concatenate([self.contacts, more]))

    @property
    def shares(self) -> Floats:
        """(n,) what each contact counts for: those that share an error speak as fewer."""
        c = self.contacts
        apart = cdist(c.points, c.points, "sqeuclidean")
        alike = np.exp(-np.minimum(apart / (2.0 * BESIDE**2), 700.0))
        if len(np.unique(c.touch)) > 1:
            alike[c.touch[:, None] == c.touch] = 1.0
        return np.asarray(1.0 / (1.0 + ALIKE * (alike.sum(axis=1) - 1.0)))

    @cached_property
    def round_face(self) -> Shape | None:
        """What was felt, if that was nothing but one round face, as far as can be told."""
        return round_face(self.contacts) if self.scale_known else None

    @property
    def lacking(self) -> int:
        """How many contacts have no normal."""
        return int((~self.contacts.has_normal).sum())


@dataclass(frozen=True)
class Prior:
    """Where the middle of the object may be: anywhere in a ball; its orientation is not known."""

    center: Floats  # (3,) [mm]
    radius: float  # [mm]

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", frozen(np.asarray(self.center, dtype=float).reshape(3)))
        if not (np.isfinite(self.radius) and self.radius > 0 and np.isfinite(self.center).all()):
            raise PalpateError(
                "a prior needs a finite center and a radius above 0 mm (--prior-center, --prior-radius)"
            )

    @staticmethod
    def around(contacts: Contacts, radius: float = WIDE) -> Prior:
        """Round the contacts themselves, where nothing is known."""
        return Prior(np.median(contacts.points, axis=0), radius)

    @property
    def volume(self) -> float:
        """[mm^3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3

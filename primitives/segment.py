"""Contacts to smooth faces: the fewest and simplest shapes that explain them, and which contact lies on which.

A contact that no face explains better than a face of its own is in none.  Where a face is fitted to contacts that
leave a gap, it is two faces.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Floats, Ints, frozen
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.segmentation.faces import Search
from primitives.segmentation.normals import with_normals
from primitives.segmentation.parts import PartOptions, density, parts
from primitives.segmentation.terms import FacesOptions

_LEAST = 4  # contacts, below which no face is looked for


@dataclass(frozen=True)
class SegmentOptions:
    """How faces are found, and parted."""

    faces: FacesOptions = field(default_factory=FacesOptions)
    parts: PartOptions = field(default_factory=PartOptions)


@dataclass(frozen=True)
class Segment:
    """One face, and the rows of its contacts in the table that they were taken from."""

    fit: Fit
    rows: Ints  # (n,)


def segment(
    contacts: Contacts, options: SegmentOptions | None = None, among: Floats | None = None
) -> tuple[Segment, ...]:
    """Faces, largest first.

    Where no normal was felt, neighbors give one: of `among` (m, 3), these contacts' points first and then
    others of the same cloud; None for these alone.
    """
    options = options or SegmentOptions()
    if len(contacts) < _LEAST:
        return ()
    oriented = with_normals(contacts, among)
    search = Search(contacts, oriented, options.faces)
    models, label = search.run()
    rho = density(contacts.points)
    found: list[Segment] = []
    for k, model in enumerate(models):
        mine = np.flatnonzero(label == k)
        several = [mine[part] for part in parts(model.fit.shape, contacts.points[mine], rho, options.parts)]
        fits = [search.best(rows, [model], ()) for rows in several] if len(several) > 1 else [model]
        if any(made is None for made in fits):
            several, fits = [mine], [model]
        found += [
            Segment(made.fit, frozen(rows, np.int64))
            for made, rows in zip(fits, several, strict=True)
            if made is not None
        ]
    return tuple(sorted(found, key=lambda s: len(s.rows), reverse=True))

"""A table's normals turned out of the object, where they point into it all round."""

from __future__ import annotations

from dataclasses import replace

from primitives.arrays import frozen
from primitives.facing import may_face_in
from recognition.sources import Source

_TOLD = (
    "the normals of the contacts seem to point into the object, and were turned round; turn them in the file, for "
    "a hollow felt from within looks the same"
)


def facing_out(source: Source) -> Source:
    """The source, its normals turned round where those of contacts that came without a run point in."""
    c = source.contacts
    if source.kind != "contacts" or not may_face_in(c, noise_known=False):
        return source
    return replace(
        source, contacts=replace(c, normals=frozen(-c.normals)), warnings=(*source.warnings, _TOLD)
    )

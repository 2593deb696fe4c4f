"""The objects that are worth a search, likeliest first, by what pairs of contacts say before any pose."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from models.library import Entry, Library
from models.library.pair_table import PairTable, table_of
from primitives.evidence import Contacts
from recognition.matching.contact_pairs import spread

_PAIRED = 100  # contacts whose pairs are counted; of more, those that lie farthest apart


def shortlist(
    contacts: Contacts, library: Mapping[str, Entry], most: int, always: Collection[str] = ()
) -> list[str]:
    """At most so many names, best first; `always` are among them."""
    names = list(library)
    if len(names) <= 1:
        return names
    few = contacts.select(spread(contacts, _PAIRED))
    felt = few.has_normal
    table = _table(library)
    ranks = table.rank(few.points, np.where(felt[:, None], few.normals, 0.0), felt)
    order = [table.names[k] for k in np.argsort(-ranks, kind="stable")]
    taken = order[:most]
    return taken + [name for name in always if name in library and name not in taken]


def _table(library: Mapping[str, Entry]) -> PairTable:
    if isinstance(library, Library):
        return library.pair_table
    return table_of(list(library), [entry.pairs for entry in library.values()])

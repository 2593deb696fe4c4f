"""A library: objects by name, each with what recognition asks of it.

`Library.of` holds solids in memory; entries are made when asked for, so a large library costs nothing until it is
used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from typing import Any

from models.library.entry import Computed, Entry
from models.solid import Solid
from primitives.errors import PalpateError


class Library(Mapping[str, Entry]):
    """Entries by name, in order."""

    def __init__(self, entries: Mapping[str, Entry]) -> None:
        self._entries = dict(entries)

    @staticmethod
    def of(solids: Mapping[str, Solid]) -> Library:
        """A library in memory; each solid in its part's own frame, whatever its pose."""
        return Library({name: Entry(name, Computed(solid)) for name, solid in solids.items()})

    def __getitem__(self, name: str) -> Entry:
        try:
            return self._entries[name]
        except KeyError:
            raise PalpateError(self._unknown(name)) from None

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def get(self, name: str, default: Any = None) -> Any:
        """The entry, or `default`."""
        return self[name] if name in self._entries else default

    def _unknown(self, name: str) -> str:
        near = get_close_matches(name, self._entries, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        return f"no object {name!r} in the library{hint} (palpate library list shows all)"

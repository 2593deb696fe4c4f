"""A library: objects by name, each with what recognition asks of it.

`Library.of` holds solids in memory; `Library.open` stands on a folder of CAD files and on what was stored beside
them.  Entries are made or mapped when asked for, so a large library costs nothing until it is used.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from models.library.build import Watch, build, read_part
from models.library.entry import Computed, Entry
from models.library.folder import ModelFile, model_files, stamp, strays
from models.library.pair_table import PairTable, table_of
from models.library.settings import FolderSettings, read_settings
from models.library.store import Row, Store
from models.library.stored import Stored
from models.library.stored_table import load_table
from models.solid import Solid
from primitives.errors import NotWritten, PalpateError

_AT_HAND = 512  # entries kept with what was asked of them, up to 2 MB each; the least used is forgotten first


class Library(Mapping[str, Entry]):
    """Entries by name, in order."""

    def __init__(
        self,
        makers: Mapping[str, Callable[[], Entry]],
        rows: tuple[Row, ...] = (),
        warnings: tuple[str, ...] = (),
        table: PairTable | None = None,
    ) -> None:
        self._table = table
        self._makers = dict(makers)
        self._at_hand: OrderedDict[str, Entry] = OrderedDict()
        self.rows = rows  # what the index says of each; none in memory
        self.warnings = warnings  # files that made no entry, one line each

    @staticmethod
    def of(solids: Mapping[str, Solid]) -> Library:
        """A library in memory; each solid in its part's own frame, whatever its pose."""
        return Library({name: _maker(name, solid) for name, solid in solids.items()})

    @staticmethod
    def open(
        folder: str | Path,
        units: str = "auto",
        scale: float = 1.0,
        watch: Watch | None = None,
        workers: int = 1,
    ) -> Library:
        """The library of a folder, first brought up to date where a file was added, changed or removed.

        Where nothing may be written beside the files, what is missing is made in memory, when it is asked for.
        """
        home = Path(folder)
        settings = read_settings(home, units, scale)
        files = model_files(home, settings)
        rows = Store(home).load()
        if rows is None or not _current(home, files, rows):
            try:
                rows = build(home, units, scale, watch, workers).rows
            except NotWritten:
                return _in_memory(home, files, rows or (), settings)
        return _stored(home, files, rows, strays(home, settings))

    @property
    def pair_table(self) -> PairTable:
        """What pairs of touched places say of every object before any pose."""
        if self._table is None:
            self._table = table_of(list(self), [entry.pairs for entry in self.values()])
        return self._table

    def __getitem__(self, name: str) -> Entry:
        if name not in self._makers:
            raise PalpateError(self._unknown(name))
        if name not in self._at_hand:
            self._at_hand[name] = self._makers[name]()
            if len(self._at_hand) > _AT_HAND:
                self._at_hand.popitem(last=False)
        self._at_hand.move_to_end(name)
        return self._at_hand[name]

    def get(self, name: str, default: Any = None) -> Any:
        """The entry, or `default`."""
        return self[name] if name in self._makers else default

    def __contains__(self, name: object) -> bool:
        return name in self._makers

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)

    def _unknown(self, name: str) -> str:
        near = get_close_matches(name, self._makers, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        return f"no object {name!r} in the library{hint} (palpate library list shows all)"


def _maker(name: str, solid: Solid) -> Callable[[], Entry]:
    return lambda: Entry(name, Computed(solid))


def _stored(
    home: Path, files: tuple[ModelFile, ...], rows: tuple[Row, ...], warnings: tuple[str, ...]
) -> Library:
    store, by_name = Store(home), {file.name: file for file in files}
    makers = {
        row.name: _stored_maker(store, row, by_name[row.name])
        for row in rows
        if not row.failed and row.name in by_name
    }
    bad = tuple(f"{row.file} is left out: {row.failed}" for row in rows if row.failed)
    if not makers:
        raise PalpateError(bad[0] if bad else f"{home} holds no CAD files; copy some into it")
    good = tuple(row for row in rows if not row.failed)
    table = load_table(store, good) if len(good) == len(makers) else None
    return Library(makers, good, (*warnings, *bad), table)


def _stored_maker(store: Store, row: Row, file: ModelFile) -> Callable[[], Entry]:
    def make() -> Entry:
        return Entry(
            row.name, Stored(store.entry(row.key), file), file.path, row.settings.get("material", "")
        )

    return make


def _in_memory(
    home: Path, files: tuple[ModelFile, ...], rows: tuple[Row, ...], settings: FolderSettings
) -> Library:
    """Of a folder that may not be written: what is stored and current is used, the rest is read now."""
    store, stored = Store(home), {row.name: row for row in rows}
    makers: dict[str, Callable[[], Entry]] = {}
    warnings = [*strays(home, settings)]
    for file in files:
        row = stored.get(file.name)
        if row and not row.failed and _same(home, file, row) and store.entry(row.key).exists():
            makers[file.name] = _stored_maker(store, row, file)
            continue
        try:
            solid = read_part(file).solid
        except PalpateError as error:
            warnings.append(f"{file.path.name} is left out: {error}")
            continue
        entry = Entry(file.name, Computed(solid), file.path, file.settings.material)
        makers[file.name] = lambda entry=entry: entry  # type: ignore[misc]
    if not makers:
        raise PalpateError(warnings[0] if warnings else f"{home} holds no CAD files; copy some into it")
    return Library(makers, (), tuple(warnings))


def _current(home: Path, files: tuple[ModelFile, ...], rows: tuple[Row, ...]) -> bool:
    """Whether the index speaks of the files as they are now: no content is read for that."""
    by_name = {row.name: row for row in rows}
    return by_name.keys() == {file.name for file in files} and all(
        _same(home, file, by_name[file.name]) for file in files
    )


def _same(home: Path, file: ModelFile, row: Row) -> bool:
    told = file.settings.as_json() | {"material": file.settings.material}
    return (
        row.file == file.path.name
        and row.settings == told
        and all(stamp(f"{home}/{path}") == known for path, known in row.stamps.items())
    )

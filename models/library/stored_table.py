"""The pair table of a stored library, in one file beside its objects: opened, not read, whatever its length."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from models.library.packed import map_arrays, write_arrays
from models.library.pair_table import BINS, PairTable, table_of
from models.library.store import Row, Store
from primitives.errors import NotWritten

FILE = "pairs.table"


def save_table(store: Store, rows: Sequence[Row]) -> None:
    """Of the objects that are stored; where that fails, it is put together when it is asked for."""
    good = [row for row in rows if not row.failed]
    if load_table(store, good) is not None:
        return
    columns = [(row, map_arrays(store.entry(row.key))) for row in good]
    if any(arrays is None or "pairs" not in arrays for _, arrays in columns):
        return
    table = table_of([row.name for row, _ in columns], [a["pairs"] for _, a in columns if a is not None])
    with suppress(NotWritten):
        write_arrays(_path(store), {"keys": _keys(good), "scores": table.scores})


def load_table(store: Store, rows: Sequence[Row]) -> PairTable | None:
    """The table of exactly these objects, mapped; None where it is of others."""
    arrays = map_arrays(_path(store))
    wanted = _keys(rows)
    if arrays is None or {"keys", "scores"} - arrays.keys() or not np.array_equal(arrays["keys"], wanted):
        return None
    if arrays["scores"].shape != (BINS, len(rows)):
        return None
    return PairTable(tuple(row.name for row in rows), arrays["scores"])


def _path(store: Store) -> Path:
    return store.home / FILE


def _keys(rows: Sequence[Row]) -> np.ndarray:
    return np.frombuffer("\n".join(row.key for row in rows).encode(), dtype=np.uint8)

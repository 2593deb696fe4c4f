"""Make what is new, keep what is as it was, forget what is gone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from models.formats.bodies import SeveralBodies
from models.formats.intake import SUFFIXES
from models.library.folder import ModelFile, content_key, model_files, strays
from models.library.packed import map_arrays, write_arrays
from models.library.record import record, text_of
from models.library.settings import FILE as SETTINGS
from models.library.settings import read_settings
from models.library.store import HOME, Row, Store
from models.library.stored_table import save_table
from models.part import Part, load_part
from primitives.errors import NotWritten, PalpateError

Watch = Callable[[int, int, str], object]
"""Told how many files of how many are done, and what was last."""


@dataclass(frozen=True)
class Built:
    """What a build did, by name."""

    made: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    failed: dict[str, str]  # file -> why
    warnings: tuple[str, ...]  # files that are none of its objects, and what was mended in those that are
    rows: tuple[Row, ...]
    bytes: int  # of all objects


def build(
    folder: str | Path, units: str = "auto", scale: float = 1.0, watch: Watch | None = None, workers: int = 1
) -> Built:
    """Bring the store of a folder up to date."""
    home, told = Path(folder), watch or (lambda done, of, last: None)
    settings = read_settings(home, units, scale)
    files = model_files(home, settings)
    if not files:
        raise PalpateError(f"{home} holds no CAD files ({' '.join(SUFFIXES)}); copy some into it")
    store = Store(home)
    if not store.writable():
        raise NotWritten(f"{home / HOME} cannot be written; copy the folder to where it can")
    with store.locked(lambda: told(0, len(files), "waiting for another build of this folder")):
        before = {row.name: row for row in store.load() or ()}
        failed_before = {row.key: row for row in before.values() if row.failed}
        keyed = [(file, *content_key(file)) for file in files]
        rows: dict[str, Row] = {}
        todo = []
        for file, key, stamps in keyed:
            old = failed_before.get(key)
            about = None if old else _about(store.entry(key))
            if old or about is not None:
                rows[file.name] = _row(file, key, stamps, about or {}, old.failed if old else "")
            else:
                todo.append((file, key, stamps))
        kept = [name for name, row in rows.items() if not row.failed]
        for done, (file, key, stamps, about, why) in enumerate(_made(store, todo, workers), 1):
            rows[file.name] = _row(file, key, stamps, about, why)
            told(len(rows), len(files), file.name if not why else f"{file.path.name}: {why}")
            if done % 200 == 0:
                store.save(_ordered(files, rows))
        final = _ordered(files, rows)
        store.save(final)
        store.sweep(final)
        save_table(store, final)
    good = [row for row in final if not row.failed]
    return Built(
        tuple(file.name for file, *_ in todo if not rows[file.name].failed),
        tuple(kept),
        tuple(sorted(row.name for row in before.values() if row.name not in rows and not row.failed)),
        {row.file: row.failed for row in final if row.failed},
        (*strays(home, settings), *(text for row in good for text in _warnings(row))),
        final,
        sum(store.entry(key).stat().st_size for key in {row.key for row in good}),
    )


_Todo = tuple[ModelFile, str, dict[str, tuple[int, int]]]


def _made(store: Store, todo: Sequence[_Todo], workers: int) -> Iterator[tuple[Any, ...]]:
    if workers <= 1 or len(todo) < 8:
        for file, key, stamps in todo:
            yield file, key, stamps, *make(file, store.entry(key))
        return
    others = set(active_children())
    left = {key: (file, key, stamps) for file, key, stamps in todo}
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        jobs = {pool.submit(make, file, store.entry(key)): key for file, key, _ in left.values()}
        try:
            for job in as_completed(jobs):
                result = job.result()
                yield *left.pop(jobs[job]), *result
        except BrokenProcessPool:
            pass
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in set(active_children()) - others:  # or the block would wait for the files in hand
                worker.terminate()
            raise
    for one in left.values():  # a file ended its reader: which one is found by reading each apart
        with ProcessPoolExecutor(1, get_context("spawn")) as alone:
            try:
                yield *one, *alone.submit(make, one[0], store.entry(one[1])).result()
            except BrokenProcessPool:
                yield *one, {}, f"{one[0].path.name} ended its reader; export it again"


def make(file: ModelFile, path: Path) -> tuple[dict[str, Any], str]:
    """Write the object of one file; what it is, or why there is none."""
    try:
        arrays = record(read_part(file))
        write_arrays(path, arrays)
    except NotWritten:
        raise
    except SeveralBodies as error:
        where = f'body = N under ["{file.path.name}"] in {SETTINGS}'
        return {}, f"{error.held}, choose one with {where}: {error.listed}"
    except PalpateError as error:
        return {}, " ".join(str(error).split())
    except (MemoryError, ArithmeticError, LookupError, ValueError, RecursionError) as error:
        return {}, f"{file.path.name} cannot be understood ({type(error).__name__}); export it again"
    return about_of(arrays), ""


def read_part(file: ModelFile) -> Part:
    """The part in a file, under its settings."""
    s = file.settings
    return load_part(str(file.path.absolute()), s.units, s.scale, s.body, s.facets)


def about_of(arrays: Any) -> dict[str, Any]:
    """What a list shows of an object, and what tells far ones apart without opening them."""
    told = text_of(arrays)
    return {
        "faces": told["faces"],
        "extent_mm": told["extent"],
        "volume_mm3": told["volume"],
        "area_mm2": told["area"],
        "symmetry": told["symmetry"]["name"],
        "warnings": told["warnings"],
    }


def _about(path: Path) -> dict[str, Any] | None:
    arrays = map_arrays(path) if path.exists() else None
    try:
        return None if arrays is None else about_of(arrays)
    except (KeyError, ValueError, TypeError):
        return None


def _row(
    file: ModelFile, key: str, stamps: dict[str, tuple[int, int]], about: dict[str, Any], why: str
) -> Row:
    settings = file.settings.as_json() | {"material": file.settings.material}
    return Row(file.name, file.path.name, key, stamps, settings, about, why)


def _warnings(row: Row) -> list[str]:
    """What a person should know of an object, each with its file's name."""
    return [text if row.file in text else f"{row.file}: {text}" for text in row.about["warnings"]]


def _ordered(files: Sequence[ModelFile], rows: dict[str, Row]) -> tuple[Row, ...]:
    return tuple(rows[file.name] for file in files if file.name in rows)

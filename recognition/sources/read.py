"""SOURCE -> `Source`: a contact table (.csv, .txt, .ply), a run folder, or the recording of an episode.

A run folder gives the contacts it holds; where the run was killed before they were written, its recording's.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from primitives.errors import PalpateError
from primitives.evidence import Contacts
from recognition.running.evidence_log import explored
from recognition.running.folder import RECORDING, SUMMARY
from recognition.sources.columns import Columns
from recognition.sources.contact_ply import read_ply
from recognition.sources.contact_table import read_table
from recognition.sources.places import written_once
from recognition.sources.source import Felt, Source

_TABLES: dict[str, Callable[[Path], Columns]] = {
    ".csv": read_table,
    ".txt": read_table,
    ".xyz": read_table,
    ".ply": read_ply,
}
_CONTACTS = "contacts.csv"
_PLACEHOLDER = 0.1  # [mm] sigma of contacts that say none
_NORMAL_SIGMA = 0.05  # [rad] of normals of which nobody says more: about three degrees
_KNOWN = "give a run folder, an episode.mcap, or contacts (.csv or .ply: x,y,z[,nx,ny,nz[,sigma]] in mm)"
_WRITTEN = 1e-3  # [mm] to which a run's table is written
_WIDEST, _NARROWEST = 20_000.0, 0.5  # [mm] no object is wider; none that is narrower was told in mm


def read_source(path: str | Path, least: int = 0) -> Source:
    """The evidence in a SOURCE, at least `least` contacts; anything else is one line that names the fix."""
    file = Path(path)
    if not str(path):
        raise PalpateError(f"no source; {_KNOWN}")
    if file.is_dir():
        source = _of_folder(file)
    elif file.suffix.lower() == ".mcap":
        source = _of_episode(file)
    elif (read := _TABLES.get(file.suffix.lower())) is not None:
        source = _of_table(file, read)
    elif not file.exists():
        raise PalpateError(f"no file {file}; {_KNOWN}")
    else:
        raise PalpateError(f"cannot read {file.name}: {_KNOWN}")
    if len(source.contacts) < least:
        held = len(source.contacts)
        raise PalpateError(
            f"{file} holds {held} contact{'' if held == 1 else 's'}; at least {least} are needed"
        )
    return source


def _of_table(file: Path, read: Callable[[Path], Columns]) -> Source:
    columns = read(file)
    contacts, measured = contacts_of(columns, file.name)
    once = contacts.select(written_once(contacts))
    return Source(file, "contacts", file.stem, once, measured, warnings=_told_of(len(contacts), len(once)))


def _told_of(written: int, once: int) -> tuple[str, ...]:
    """A warning where a table says the same again."""
    if once == written:
        return ()
    repeat = "1 contact repeats" if written - once == 1 else f"{written - once} contacts repeat"
    count = "counts" if written - once == 1 else "count"
    return (f"of {written} that were written, {repeat} another to the last digit and {count} once with it",)


def contacts_of(columns: Columns, name: str) -> tuple[Contacts, bool]:
    """The table's rows as contacts, and whether it says how surely they were felt."""
    points = columns.points
    broken = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(broken):
        raise PalpateError(
            f"{name}: contact {broken[0] + 1} has a coordinate that is not a finite number; remove it"
        )
    widest = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if widest > _WIDEST or 0.0 < widest < _NARROWEST:
        metres = "" if widest > _WIDEST else ", or a header that says m"
        raise PalpateError(f"{name}: contacts lie up to {widest:.3g} mm apart; give mm{metres}")
    normals = np.full_like(points, np.nan)
    if columns.normals is not None:
        length = np.linalg.norm(columns.normals, axis=1)
        felt = np.isfinite(length) & (length > 1e-9)
        normals[felt] = columns.normals[felt] / length[felt, None]
    sigma = np.full(len(points), np.nan) if columns.sigma is None else columns.sigma
    wrong = np.flatnonzero(sigma <= 0)
    if len(wrong):
        raise PalpateError(
            f"{name}: contact {wrong[0] + 1} has a sigma of {sigma[wrong[0]]:g} mm; give one above 0"
        )
    said = np.isfinite(sigma)
    measured = bool(len(points) and said.all())
    filled = np.where(said, sigma, float(np.median(sigma[said])) if said.any() else _PLACEHOLDER)
    rows = np.arange(len(points))
    return Contacts.of(points, normals, filled, _NORMAL_SIGMA, touch=rows, stroke=rows), measured


def _of_folder(folder: Path) -> Source:
    table, recording = folder / _CONTACTS, folder / RECORDING
    if not table.is_file() and not recording.is_file():
        raise PalpateError(
            f"{folder} is no run folder: it holds neither {_CONTACTS} nor {RECORDING}; {_KNOWN}"
        )
    summary = _summary(folder)
    name = str(summary.get("part") or folder.resolve().name)
    if not table.is_file():
        source = _of_episode(recording)
        told = (
            "the run was cut short, and its recording is read as far as it is whole: what it had not come to is "
            "not known, and a model of it lacks that or fills it"
        )
        return Source(
            folder, "episode", name, source.contacts, True, source.felt,
            (told, *(w for w in source.warnings if "cut short" not in w)), source.sweep, source.explored,
        )  # fmt: skip
    contacts, measured = contacts_of(read_table(table), str(table))
    sweep, made = None, None
    if recording.is_file():
        from recognition.sources.episode import swept

        found = explored(recording)
        made = found if found is not None and _same(contacts, found.contacts) else None

        def sweep_recording() -> Any:
            return swept(recording)

        sweep = sweep_recording
    return Source(folder, "run", name, contacts, measured, _cost(summary), (), sweep, made)


def _same(written: Contacts, felt: Contacts) -> bool:
    """Whether a run's table holds what its recording does: else somebody has edited it, and it holds."""
    if len(written) != len(felt):
        return False
    return bool(np.allclose(written.points, felt.points, atol=_WRITTEN, rtol=0.0))


def _of_episode(file: Path) -> Source:
    from recognition.sources.episode import felt_contacts, swept

    made = explored(file)
    found = felt_contacts(file, None if made is None else made.contacts)
    told = _summary(file.parent) if file.name == RECORDING else {}
    felt = _cost(told) if "touches" in told else found.felt  # in its folder it cost what the run says
    name = file.resolve().parent.name if file.name == RECORDING else file.stem
    return Source(
        file, "episode", name, found.contacts, True, felt, found.warnings,
        lambda: swept(file), made,
    )  # fmt: skip


def _summary(folder: Path) -> dict[str, Any]:
    """What the run said of itself; nothing where it ended before it could."""
    try:
        told = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return told if isinstance(told, dict) else {}


def _cost(told: dict[str, Any]) -> Felt:
    def number(key: str) -> float:
        value = told.get(key)
        return float(value) if isinstance(value, int | float) else 0.0

    sensor = told.get("sensor")
    return Felt(
        int(number("touches")), int(number("strokes")), int(number("frames")),
        number("travel_mm"), number("device_seconds"), str(sensor) if sensor else None,
    )  # fmt: skip

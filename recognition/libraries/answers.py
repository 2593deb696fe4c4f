"""What `palpate library` answers: rows, texts and JSON of a library, and progress while one is made."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from exploration.sensing.spec import SensorSpec, load_sensor
from models.library import Built, Library
from primitives.errors import PalpateError
from recognition.confusable import Pair
from recognition.report.terminal import table_text

MADE_MM = 0.05
"""[mm] 1 sigma by which a made object leaves its CAD file, and a simulated contact its surface."""

_MOST_WARNINGS = 20  # that a person is told of a build
_Watch = Callable[[int, int, str], object]


@contextmanager
def progress(quiet: bool = False) -> Iterator[_Watch]:
    """Something to tell how many of how many are done; it draws on stderr, and only where that is a terminal."""
    from rich.console import Console

    console = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)
    if quiet or not console.is_terminal:
        yield lambda done, of, last: None
        return
    with console.status("reading the library") as status:
        yield lambda done, of, last: status.update(f"{done} of {of}: {last}"[: console.width - 4])


def opened(folder: Path, units: str = "auto", scale: float = 1.0, quiet: bool = False) -> Library:
    """The library of a folder, brought up to date with progress; what was left out is said on stderr."""
    with progress(quiet) as watch:
        return Library.open(folder, units, scale, watch, workers_of(None))


def workers_of(asked: int | None) -> int:
    """How many processes."""
    return asked or os.cpu_count() or 1


def sensor_of(text: str) -> SensorSpec:
    """The first of the sensors named."""
    return load_sensor(text.split(",")[0])


def contact_sigma_of(spec: SensorSpec, noise: float | None, pose_noise: float, given: float | None) -> float:
    """[mm] of a contact's point: a reading's noise as depth, the stage's, and how truly objects are made."""
    for value, flag in ((noise, "--noise"), (pose_noise, "--pose-noise-mm"), (given, "--contact-sigma")):
        if value is not None and not (np.isfinite(value) and value >= 0):
            raise PalpateError(f"{flag} {value} is not a number from 0")
    if given is not None:
        if given == 0:
            raise PalpateError("--contact-sigma 0 is no standard deviation; give a positive number of mm")
        return given
    depth = spec.press_depth * (spec.electronics.noise if noise is None else noise)
    return float(np.sqrt(depth**2 + pose_noise**2 + MADE_MM**2))


def built_json(built: Built) -> dict[str, Any]:
    """As `library build --json` prints it."""
    return {
        "command": "library build",
        "entries": sum(not row.failed for row in built.rows),
        "made": list(built.made),
        "kept": list(built.kept),
        "removed": list(built.removed),
        "failed": [{"file": file, "reason": why} for file, why in built.failed.items()],
        "bytes": built.bytes,
        "warnings": list(built.warnings),
    }


def built_text(built: Built) -> str:
    """The same for a person."""
    objects = sum(not row.failed for row in built.rows)
    counts = [
        f"{len(names)} {word}"
        for names, word in ((built.made, "made"), (built.kept, "kept"), (built.removed, "removed"))
        if names
    ]
    size = f", {built.bytes / max(objects, 1) / 1000:.0f} kB each" if objects else ""
    lines = [f"{objects} objects ({', '.join(counts) or 'nothing to do'}){size}"]
    lines += [f"left out: {_about(file, why)}" for file, why in built.failed.items()]
    more = len(built.warnings) - _MOST_WARNINGS
    lines += [f"warning: {text}" for text in built.warnings[:_MOST_WARNINGS]]
    return "\n".join([*lines, *([f"and {more} warnings more (--json has all)"] if more > 0 else [])])


def list_rows(library: Library) -> list[dict[str, Any]]:
    """As `library list --json` prints them; no object is opened where the index has them."""
    known = {row.name: row for row in library.rows}
    rows = []
    for name in library:
        if name in known:
            row = known[name]
            about = row.about
            rows.append(
                {
                    "name": name,
                    "file": row.file,
                    "faces": about["faces"],
                    "extent_mm": about["extent_mm"],
                    "symmetry": about["symmetry"],
                    "material": row.settings.get("material", ""),
                }
            )
            continue
        entry = library[name]
        rows.append(
            {
                "name": name,
                "file": entry.file.name if entry.file else "",
                "faces": len(entry.brep.faces),
                "extent_mm": entry.solid.extent.tolist(),
                "symmetry": entry.symmetry.name,
                "material": entry.material,
            }
        )
    return rows


def list_text(rows: Sequence[dict[str, Any]], warnings: Sequence[str]) -> str:
    """The same for a person."""
    some = any(row["material"] for row in rows)
    kept = [{k: v for k, v in row.items() if some or k != "material"} for row in rows]
    return "\n".join([table_text(kept), *(f"warning: {text}" for text in warnings)])


def confusable_json(
    pairs: Sequence[Pair], objects: int, sensor: str, sigma: float, warnings: Sequence[str]
) -> dict[str, Any]:
    """As `library confusable --json` prints it; `touches` goes with `pairs`, one list each."""
    return {
        "command": "library confusable",
        "sensor": sensor,
        "contact_sigma_mm": sigma,
        "objects": objects,
        "pairs": [
            {
                "a": pair.a,
                "b": pair.b,
                "probability": pair.probability,
                "after_random": {str(n): value for n, value in pair.after_random.items()},
                "separable": bool(pair.touches),
                "differing_area_fraction": pair.share,
            }
            for pair in pairs
        ],
        "touches": [[touch.as_json() for touch in pair.touches] for pair in pairs],
        "warnings": list(warnings),
    }


def confusable_text(
    pairs: Sequence[Pair], objects: int, sensor: str, sigma: float, warnings: Sequence[str]
) -> str:
    """The same for a person."""
    never = [pair for pair in pairs if not pair.touches]
    told = [pair for pair in pairs if pair.touches]
    lines = [f"{objects} objects, {sensor}, contacts good to {sigma:.2g} mm"]
    if not pairs:
        lines.append("every two are told apart by a dozen contacts anywhere")
    if never:
        rows = [{"a": p.a, "b": p.b, "wrong name": f"{p.probability:.1%}"} for p in never]
        lines += ["", "cannot be told apart:", table_text(rows)]
    if told:
        rows = [
            {
                "a": p.a,
                "b": p.b,
                "wrong after": " / ".join(f"{v:.0%} ({n})" for n, v in p.after_random.items()),
                "after the best": f"{p.probability:.1g}",
                "touch": p.touches[0].on,
                "at [mm]": ", ".join(f"{x:.1f}" for x in p.touches[0].point),
                "gap [mm]": f"{p.touches[0].gap:.2f}",
            }
            for p in told
        ]
        lines += ["", "alike, but told apart by the right touch (contacts anywhere in brackets):"]
        lines.append(table_text(rows))
    return "\n".join([*lines, *(f"warning: {text}" for text in warnings)])


def _about(file: str, why: str) -> str:
    return why if file in why else f"{file}: {why}"

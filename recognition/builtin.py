"""What comes with Palpate: a library of its parts, and rows for a table or for JSON."""

from collections.abc import Callable, Iterable

from exploration.sensing.spec import load_sensor, sensor_names
from models.library import Entry, Library
from models.library.kept import Kept
from models.parts import build, describe, names
from recognition.console.interrupts import checkpoint


def part_library(chosen: Iterable[str] | None = None) -> Library:
    """Built-in parts as objects to recognize, all of them where none are named; made once for a user."""
    return Library({name: _maker(name) for name in (names() if chosen is None else chosen)})


def _maker(name: str) -> Callable[[], Entry]:
    def make() -> Entry:
        checkpoint()  # all are made one after the other where nothing is kept yet
        return Entry(name, Kept(build(name)))

    return make


def part_rows() -> list[dict[str, object]]:
    """Every built-in part."""
    return [
        {
            "name": part.name,
            "extent_mm": list(part.extent),
            "convex": part.convex,
            "description": part.description,
        }
        for part in map(describe, names())
    ]


def sensor_rows() -> list[dict[str, object]]:
    """Every built-in tactile array."""
    return [
        {
            "name": name,
            "rows": spec.array.rows,
            "columns": spec.array.columns,
            "pitch_mm": list(spec.array.pitch),
            "frames_per_second": round(1.0 / spec.period, 1),
            "technology": spec.technology,
        }
        for name in sensor_names()
        for spec in [load_sensor(name)]
    ]

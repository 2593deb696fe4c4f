"""What comes with Palpate: a library of its parts, and rows for a table or for JSON."""

from exploration.sensing.spec import load_sensor, sensor_names
from models.library import Library
from models.parts import build, describe, names
from models.solid import Solid


def part_library() -> Library:
    """Every built-in part as an object to recognize."""
    return Library.of({name: Solid.from_csg(build(name)) for name in names()})


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

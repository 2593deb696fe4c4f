"""What comes with Palpate, as rows for a table or for JSON."""

from exploration.sensing.spec import load_sensor, sensor_names
from models.parts import load_part, part_names


def part_rows() -> list[dict[str, object]]:
    """Name, size and number of primitives of every built-in part."""
    rows: list[dict[str, object]] = []
    for name in part_names():
        part = load_part(name)
        low, high = part.bounds()
        rows.append(
            {
                "name": name,
                "extent_mm": [round(x, 3) for x in (high - low).tolist()],
                "primitives": sum(1 for _ in part.leaves()),
            }
        )
    return rows


def sensor_rows() -> list[dict[str, object]]:
    """Name, layout and kind of every built-in tactile array."""
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

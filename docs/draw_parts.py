"""Draws every built-in part and lists them in `docs/parts.md`: `make docs`."""

from itertools import groupby
from pathlib import Path

from models.parts import BuiltIn, build, describe, names
from models.solid import Solid
from recognition.report.drawing import drawing_svg

HERE = Path(__file__).parent
COLUMNS = 4
HEAD = """# Built-in parts

What `palpate parts` lists: {count} parts, each a few lines of CSG in `models/parts`. Any of their names stands
where a command takes a part. Sizes are the sides of the bounding box in mm; planes are blue, cylinders yellow,
cones red, spheres green, tori purple. `make docs` draws this page.
"""


def main() -> None:
    """Write the pictures and the page."""
    pictures = HERE / "parts"
    pictures.mkdir(exist_ok=True)
    for stale in {path.stem for path in pictures.glob("*.svg")} - set(names()):
        (pictures / f"{stale}.svg").unlink()
    for name in names():
        solid = Solid.from_csg(build(name), tolerance=0.005)
        (pictures / f"{name}.svg").write_text(drawing_svg(solid), encoding="utf-8")
    (HERE / "parts.md").write_text(page(), encoding="utf-8")


def page() -> str:
    """The page as Markdown."""
    pieces = [HEAD.format(count=len(names()))]
    for group, listed in groupby(map(describe, names()), key=lambda part: part.group):
        parts = list(listed)
        rows = [parts[i : i + COLUMNS] for i in range(0, len(parts), COLUMNS)]
        pieces.append(f"\n## {group}\n\n" + "|" + " |" * COLUMNS + "\n|" + "---|" * COLUMNS + "\n")
        pieces += [
            "| " + " | ".join([*map(cell, row), *[""] * (COLUMNS - len(row))]) + " |\n" for row in rows
        ]
    return "".join(pieces)


def cell(part: BuiltIn) -> str:
    """One part's place in the table."""
    size = " × ".join(f"{side:g}" for side in part.extent)
    return f'<img src="parts/{part.name}.svg" width="180" alt=""><br>`{part.name}`<br>{size}<br>{part.description}'


if __name__ == "__main__":
    main()

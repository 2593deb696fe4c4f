"""OpenSCAD's `.csg` and a subset of `.scad` as exact trees (docs/openscad.md), and trees as `.csg`."""

from models.formats.openscad.reader import SUFFIXES, Drawing, read, read_text
from models.formats.openscad.writer import text, write

__all__ = ["SUFFIXES", "Drawing", "read", "read_text", "text", "write"]

"""OFF as people write it: counts on the first line or later, comments, blank lines, colors, any polygons."""

import numpy as np

from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError


def parse(data: bytes, name: str) -> tuple[Floats, Ints]:
    """(v, 3) vertices and (t, 3) triangles in the file's unit; polygons become fans."""
    lines = [line.split("#", 1)[0].split() for line in data.decode("utf-8", "replace").splitlines()]
    rows = [words for words in lines if words]
    if not rows or not rows[0][0].upper().endswith("OFF"):
        raise PalpateError(f"{name} does not begin with OFF; export it again")
    kind, rest = rows[0][0].upper(), rows[0][1:]
    rows = [rest, *rows[1:]] if rest else rows[1:]
    if kind not in ("OFF", "COFF", "NOFF", "CNOFF"):
        raise PalpateError(f"{name} is of the rare kind {kind}; export it as plain OFF")
    try:
        vertex_count, face_count = int(rows[0][0]), int(rows[0][1])
        if vertex_count < 0 or face_count < 0 or 1 + vertex_count + face_count > len(rows):
            held = len(rows) - 1
            raise PalpateError(
                f"{name} announces {vertex_count} vertices and {face_count} faces and holds {held} lines;"
                " it is truncated: export it again"
            )
        vertices = np.array([[float(x) for x in row[:3]] for row in rows[1 : 1 + vertex_count]])
        triangles = [
            (corners[0], corners[k], corners[k + 1])
            for row in rows[1 + vertex_count : 1 + vertex_count + face_count]
            for corners in [[int(i) for i in row[1 : 1 + int(row[0])]]]
            for k in range(1, len(corners) - 1)
        ]
    except (ValueError, IndexError):
        raise PalpateError(f"{name} has a line that OFF does not allow; export it again") from None
    return vertices.reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3)

"""OBJ as people write it: polygons, places counted back, tabs, comments, lines that go on."""

import re

import numpy as np

from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError


def parse(data: bytes, name: str) -> tuple[Floats, Ints]:
    """(v, 3) vertices and (t, 3) triangles in the file's unit; polygons become fans, all else is passed over."""
    points: list[list[bytes]] = []
    corners: list[list[int]] = []
    line = b""
    try:
        for line in re.sub(rb"\\[ \t]*\n", b" ", data).splitlines():
            words = line.partition(b"#")[0].split()
            if not words:
                continue
            if words[0] == b"v":
                points.append(words[1:4])
            elif words[0] == b"f":
                corners.append([_place(word, len(points)) for word in words[1:]])
        line = b"v, of three numbers"
        vertices = np.array([float(x) for point in points for x in point]).reshape(len(points), 3)
        line = b"f, of places too large"
        fans = [(face[0], face[k], face[k + 1]) for face in corners for k in range(1, len(face) - 1)]
        return vertices, np.array(fans, dtype=np.int64).reshape(-1, 3)
    except (ValueError, OverflowError):
        shown = " ".join(line.decode("ascii", "replace").split())[:40]
        raise PalpateError(
            f"cannot read {name} as OBJ (a line that it does not allow: {shown}); export it again"
        ) from None


def _place(word: bytes, count: int) -> int:
    """Which vertex a corner `v`, `v/vt`, `v//vn` or `v/vt/vn` is, where `count` were given before."""
    number = int(word.partition(b"/")[0])
    place = number - 1 if number > 0 else count + number
    if number == 0 or place < 0:
        raise ValueError("no such vertex")
    return place

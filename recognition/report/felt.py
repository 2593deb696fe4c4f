"""What was felt of a boundary that did not close: each flat face as far as contacts reach on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from primitives.arrays import Floats, Ints
from primitives.shapes import Plane
from recognition.report.run_report import ReportMesh


def felt_faces(faces: Sequence[dict[str, Any]], contacts: Floats, face_of_contact: Ints) -> ReportMesh | None:
    """The hulls of the contacts on plane faces, in their planes; None where there is none."""
    vertices, triangles, labels = list[Floats](), list[Ints](), list[int]()
    start = 0
    for face in faces:
        mine = contacts[face_of_contact == face["id"]]
        if face["shape"] != "plane" or len(mine) < 3:
            continue
        plane = Plane(np.asarray(face["parameters"]["origin_mm"]), np.asarray(face["parameters"]["axis"]))
        flat = (mine - plane.origin) @ plane.frame[:, :2]
        try:
            outline = flat[ConvexHull(flat).vertices]  # counterclockwise
        except QhullError:  # contacts in a line
            continue
        vertices.append(plane.origin + outline @ plane.frame[:, :2].T)
        after = np.arange(1, len(outline) - 1)
        triangles.append(start + np.stack([np.zeros_like(after), after, after + 1], axis=1))
        labels += [int(face["id"])] * len(after)
        start += len(outline)
    if not vertices:
        return None
    return ReportMesh(np.concatenate(vertices), np.concatenate(triangles), np.array(labels))

"""Generated parts: how many are what the generator promises, and what one costs to draw, to mesh and to bound."""

import time
from collections import Counter
from typing import Any

import numpy as np

from models.boundary import boundary
from models.generate import generate
from models.solid import Solid

PARTS = 500
TOLERANCE = 0.02  # [mm]


def run() -> list[dict[str, Any]]:
    """Sound is: one body, one shell, a boundary that checks, 20 to 200 mm, no flat face narrower than 2 mm."""
    sound, spent, faces, kinds = 0, Counter[str](), [], Counter[str]()
    for seed in range(PARTS):
        start = time.perf_counter()
        tree = generate(np.random.default_rng(seed), complexity=1 + seed % 7)
        drawn = time.perf_counter()
        solid = Solid.from_csg(tree, TOLERANCE)
        meshed = time.perf_counter()
        brep = boundary(solid)
        done = time.perf_counter()
        spent.update({"generate": drawn - start, "mesh": meshed - drawn, "boundary": done - meshed})
        flat = min(min(face.extent) for face in brep.faces if face.kind == "plane")
        whole = len(solid.body.mesh.decompose()) == brep.shells == 1 and not brep.check()
        sound += bool(whole and 20 <= solid.extent.max() <= 200 and flat >= 1.99)
        faces.append(len(brep.faces))
        kinds.update(face.kind for face in brep.faces)
    rows = [
        _row("generated parts", "sound", sound, f"of {PARTS}") | {"asked": PARTS},
        _row("generated parts", "faces, median", float(np.median(faces)), "1"),
        _row("generated parts", "faces, 95th percentile", float(np.percentile(faces, 95)), "1"),
    ]
    rows += [_row(step, "time a part", 1e3 * spent[step] / PARTS, "ms") for step in spent]
    rows += [_row("generated parts", f"faces, {kind}", count, "1") for kind, count in kinds.most_common()]
    return rows


def _row(method: str, metric: str, value: float, unit: str) -> dict[str, Any]:
    return {"bench": "generate", "method": method, "metric": metric, "value": value, "unit": unit}


if __name__ == "__main__":
    for row in run():
        print(row)

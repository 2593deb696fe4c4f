"""Which relations and round sizes are taken, right and wrong, where contacts know their faces but err."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from clouds.sampled import sampled

from models.boundary import labeled_boundary
from models.parts import build
from models.solid import Solid
from primitives.arrays import Floats, frozen
from primitives.fit import Fit, refit
from primitives.shapes import Cone, Shape
from recognition.assembly.given import outward
from recognition.assembly.regularities import Relation, regularize

EACH = 40  # contacts per face of a part
_EXACT = 1e-12  # [mm^2, rad^2] of the truth
_ROUND = 1e-3  # [mm] that a round size may be off the true one


def regularity_rows(names: Sequence[str], sigma: float) -> list[dict[str, Any]]:
    """Two rows a kind: of parts scaled at random, but for round sizes, which only parts as they are drawn have."""
    taken, wrong, true = Counter[str](), Counter[str](), Counter[str]()
    for number, name in enumerate(names):
        for scaled in (True, False):
            rng = np.random.default_rng([number, scaled])
            found, exact = _of_part(Solid.from_csg(build(name)), rng, sigma, scaled)
            held = {(r.kind, frozenset(r.faces)) for r in exact.relations if r.kind != "round"}
            if scaled:
                true.update(kind for kind, _ in held)
            for relation in found.relations:
                kind, is_round = relation.kind, relation.kind == "round"
                if scaled and not is_round:
                    taken[kind] += 1
                    wrong[kind] += (kind, frozenset(relation.faces)) not in held
                elif is_round:
                    kind = "round, parts scaled at random" if scaled else "round, parts as drawn"
                    taken[kind] += 1
                    wrong[kind] += abs(_size(relation, exact.shapes) - relation.taken) > _ROUND
    rows = []
    for kind in sorted(taken):
        where = f"{kind}, {len(names)} parts, {sigma} mm"
        rows.append(_row(f"wrongly taken: {where}", wrong[kind], f"of {taken[kind]}"))
        if true[kind]:
            share = 100.0 * (taken[kind] - wrong[kind]) / true[kind]
            rows.append(_row(f"true ones taken: {where}", share, "%"))
    return rows


def _of_part(solid: Solid, rng: np.random.Generator, sigma: float, scaled: bool) -> tuple[Any, Any]:
    """What is regular of noisy faces, and of the exact ones."""
    scale = float(rng.uniform(0.9, 1.1)) if scaled else 1.0
    faces = [face for face in labeled_boundary(solid)[0].faces if face.shape is not None]
    cloud = sampled(solid, EACH * len(faces), rng, sigma, 0.05, scale=scale)
    noisy, exact = list[Fit](), list[Fit]()
    for face in faces:
        shape = _scaled(face.shape, scale)
        fit = refit(shape, face.convex, cloud.contacts.select(cloud.face == face.id))
        if isinstance(fit, Fit):
            noisy.append(outward(fit))
            covariance = frozen(_EXACT * np.eye(shape.dof))
            exact.append(outward(replace(fit, shape=shape, covariance=covariance)))
    return regularize(noisy), regularize(exact)


def _scaled(shape: Shape, scale: float) -> Shape:
    sizes = shape.sizes if isinstance(shape, Cone) else tuple(scale * size for size in shape.sizes)
    return shape.with_parts(scale * shape.anchor, shape.direction, sizes)


def _size(relation: Relation, shapes: Sequence[Shape]) -> float:
    """[mm] a size of exact shapes."""
    first = shapes[relation.faces[0]]
    if len(relation.faces) == 1:
        return 2.0 * first.sizes[0]
    apart: Floats = shapes[relation.faces[1]].anchor - first.anchor
    return abs(float(apart @ first.direction))


def _row(metric: str, value: float, unit: str) -> dict[str, Any]:
    return {"bench": "clouds", "method": "palpate", "metric": metric, "value": float(value), "unit": unit}

"""The one body of a drawing, as a tree: what a file draws apart are bodies to choose from.

Every term of the union belongs to the bodies that it shares material with; a term that a cut leaves in pieces
is cut to each body's box, which is exact where the boxes do not meet.  Splinters that rounding left stay with the
only body.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np

from models.csg import Csg, Cube, Placed, Union
from models.formats.bodies import Found, chosen, thin_ones
from models.formats.shells import bodies
from models.solid import Solid
from primitives.arrays import Floats
from primitives.errors import PalpateError

_MOST = 100  # bodies in one drawing,
_MOST_SHELLS = 1000  # and closed surfaces, splinters among them
_SHARED = 1e-6  # of the volume of a term or a body, from which on it belongs to that
_MARGIN = 0.05  # of a body's size, that its box is wider


@dataclass(frozen=True, eq=False)
class Drawn:
    """One body of a drawing."""

    tree: Csg
    solid: Solid


def body_of(tree: Csg, body: int | None, name: str) -> Drawn:
    """The body with that number, from 1, or the only one."""
    whole = _solid(tree, name)
    found = bodies(whole.vertices, whole.triangles, _MOST_SHELLS)
    if not found:
        raise PalpateError(
            f"{name} draws more than {_MOST_SHELLS} closed surfaces; keep the body that is meant"
        )
    each = (Solid.from_mesh(whole.vertices, triangles) for triangles in found.triangles)
    apart = [whole] if len(found.triangles) == 1 else list(each)
    pieces = tuple(piece for piece, thin in zip(apart, thin_ones(apart), strict=True) if not thin)
    if len(pieces) > _MOST:
        raise PalpateError(f"{name} draws more than {_MOST} bodies; keep the one that is meant")
    if len(pieces) == 1:
        chosen([Found("", pieces, (), "")], body, name)
        return Drawn(tree, whole)
    _, number, _ = chosen([Found("", pieces, (), "")], body, name)
    terms = [part for term in _terms(tree) if (part := _share(term, pieces, number, name)) is not None]
    kept = reduce(lambda a, b: a | b, terms)
    return Drawn(kept, _solid(kept, name))


def _share(term: Csg, pieces: tuple[Solid, ...], number: int, name: str) -> Csg | None:
    """What of a term belongs to one body."""
    try:
        solid = Solid.from_csg(term)
    except PalpateError:  # nothing is left of it
        return None
    holders = [
        i
        for i, piece in enumerate(pieces)
        if solid.shared_volume(piece) > _SHARED * min(solid.volume, piece.volume)
    ]
    if number not in holders:
        return None
    if len(holders) == 1:
        return term
    box = _box(pieces[number])
    for i in holders:
        other = _box(pieces[i])
        if i != number and (np.maximum(box[0], other[0]) < np.minimum(box[1], other[1])).all():
            raise PalpateError(
                f"{name} cuts one solid into bodies that reach round each other; draw them one by one"
            )
    x, y, z = (box[1] - box[0]).tolist()
    return term & Cube((x, y, z)).at(*box.mean(axis=0).tolist())


def _solid(tree: Csg, name: str) -> Solid:
    try:
        return Solid.from_csg(tree)
    except PalpateError as error:
        raise PalpateError(f"{name}: {error}") from None


def _box(piece: Solid) -> Floats:
    low, high = piece.bounds
    more = _MARGIN * (high - low).max()
    return np.stack([low - more, high + more])


def _terms(tree: Csg) -> list[Csg]:
    """What the drawing is the union of."""
    match tree:
        case Placed():
            return [term.placed(tree.pose) for term in _terms(tree.child)]
        case Union():
            return [term for child in tree.children for term in _terms(child)]
    return [tree]

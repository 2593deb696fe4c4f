"""Whether two boundaries are of one object, in whatever pose, order of faces, or hand that made them.

`same_boundary` asks for a rigid motion that carries every face, edge and corner of one onto the other's, within
a tolerance; mirror images are different.  What a boundary cannot show is not compared: freeform faces agree by
their rims and areas.  `Canonical` lets models be members of sets.  Within a tolerance a = b and b = c do not
make a = c; where that matters, take a tolerance far below the least difference.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from models.brep import Brep
from models.comparison.isomorphism import Different, counted
from models.comparison.likeness import SameConfig, colored
from models.comparison.motions import Carried, motions
from models.comparison.outline import Outline, mirrored, outline
from models.comparison.signature import topology
from primitives.arrays import Floats

__all__ = ["Canonical", "Different", "Match", "same_boundary"]


@dataclass(frozen=True, eq=False)
class Match:
    """That two boundaries are the same, and how one lies on the other; true in a condition."""

    b_from_a: Floats  # (4, 4) the rigid motion
    faces: tuple[int, ...]  # face of b for each of a
    edges: tuple[int, ...]
    vertices: tuple[int, ...]
    residual: float  # [mm] the worst between corners and between edges


def same_boundary(a: Brep, b: Brep, tolerance: float | SameConfig = SameConfig()) -> Match | Different:  # noqa: B008
    """Whether a and b bound the same object, within `tolerance` [mm]."""
    config = tolerance if isinstance(tolerance, SameConfig) else SameConfig(tolerance=tolerance)
    return compared(outline(a), outline(b), config)


def compared(a: Outline, b: Outline, config: SameConfig) -> Match | Different:
    """The same, for boundaries that are measured already."""
    if reason := _uncounted(a, b):
        return Different(reason)
    colors = colored(a, b, config)
    if not np.array_equal(np.sort(colors[0]), np.sort(colors[1])):
        return Different(_unlike(a, b, config))
    if found := next(motions(a, b, colors, config), None):
        return _match(found)
    image = mirrored(a)
    if next(motions(image, b, colored(image, b, config), config), None):
        return Different("mirror images")
    return Different("equal faces in other places: no rigid motion carries one onto the other")


@dataclass(frozen=True, eq=False)
class Canonical:
    """A boundary that equals every other of the same object, and hashes alike."""

    brep: Brep
    config: SameConfig = field(default_factory=SameConfig)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Canonical) and bool(compared(self._outline, other._outline, self.config))

    def __hash__(self) -> int:
        return hash(self._topology)

    @cached_property
    def _outline(self) -> Outline:
        return outline(self.brep)

    @cached_property
    def _topology(self) -> str:
        return topology(self.brep)


def _match(found: Carried) -> Match:
    return Match(
        found.b_from_a,
        tuple(found.faces.tolist()),
        tuple(found.edges.tolist()),
        tuple(found.vertices.tolist()),
        found.residual,
    )


def _uncounted(a: Outline, b: Outline) -> str:
    kinds, others = (Counter(face.kind for face in whole.brep.faces) for whole in (a, b))
    for kind in sorted(kinds | others):
        if kinds[kind] != others[kind]:
            return f"{kinds[kind]} {kind} faces against {others[kind]}"
    return counted(a.graph, b.graph, labels=False)


def _unlike(a: Outline, b: Outline, config: SameConfig) -> str:
    """The first size or angle that finds no equal, in words."""
    for name, mine, theirs, reach in (
        ("a radius", a.sizes.ravel(), b.sizes.ravel(), config.tolerance),
        ("an edge's length", a.length, b.length, config.tolerance * np.pi),
        ("a dihedral angle", a.dihedral, b.dihedral, config.dihedral),
    ):
        away = np.abs(np.sort(mine) - np.sort(theirs))
        if len(away) and float(away.max()) > 2 * reach:
            worst = int(away.argmax())
            unit = "deg" if "angle" in name else "mm"
            return f"{name} of {np.sort(mine)[worst]:.6g} {unit} against {np.sort(theirs)[worst]:.6g} {unit}"
    return "faces of the same sizes meet in other ways or places"

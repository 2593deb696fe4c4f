"""Several bodies in one file: overlapping ones of one mesh are united, and of the rest one is chosen by number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from models.solid import Solid
from models.splinters import splinters
from primitives.arrays import Bools
from primitives.errors import PalpateError

_LISTED = 8  # bodies that the line names
_MOST_PAIRS = 20_000  # of solids that are looked at for an overlap
_OVERLAP = 1e-6  # of the smaller volume, from which on two solids are one


@dataclass(frozen=True, eq=False)
class Found:
    """The solids in one mesh of a file."""

    name: str
    solids: tuple[Solid, ...]
    said: tuple[str, ...]  # what was mended
    wrong: str  # why there are none


def united(found: Found, name: str) -> Found:
    """Solids that overlap made one: a mesh without names says nothing of bodies, so it was drawn of pieces."""
    left, out, merged = list(found.solids), list[Solid](), 0
    if not 2 <= len(left) <= np.sqrt(_MOST_PAIRS):
        return found
    while left:
        grown = left.pop(0)
        while (i := next((i for i, other in enumerate(left) if _overlap(grown, other)), None)) is not None:
            grown, merged = grown.boolean(left.pop(i), "union"), merged + 1
        out.append(grown)
    said = (f"{name} had {merged + 1} solids that overlap; they were united",) if merged else ()
    return replace(found, solids=tuple(out), said=(*found.said, *said))


def thin_ones(solids: Sequence[Solid]) -> Bools:
    """(n,) which solids of a file are splinters."""
    return splinters([s.volume for s in solids], [s.area for s in solids], [s.bounds for s in solids])


def without_splinters(found: list[Found], name: str) -> tuple[list[Found], tuple[str, ...]]:
    """A file's meshes without the splinters among their solids, and what to say of it."""
    thin = iter(thin_ones([solid for mesh in found for solid in mesh.solids]))
    kept = [replace(mesh, solids=tuple(s for s in mesh.solids if not next(thin))) for mesh in found]
    lost = sum(len(mesh.solids) for mesh in found) - sum(len(mesh.solids) for mesh in kept)
    if not lost:
        return found, ()
    pieces = "a splinter" if lost == 1 else f"{lost} splinters"
    said = f"{name} also holds {pieces}, as rounding leaves them; left out"
    return [mesh for mesh in kept if mesh.solids or mesh.wrong], (said,)


class SeveralBodies(PalpateError):
    """A file holds more than one, and nobody said which."""

    def __init__(self, held: str, listed: str) -> None:
        super().__init__(f"{held}, choose one with --body: {listed}")
        self.held, self.listed = held, listed

    def __reduce__(self) -> tuple[type[SeveralBodies], tuple[str, str]]:
        """Errors cross to other processes as what they were made of."""
        return type(self), (self.held, self.listed)


def chosen(found: list[Found], body: int | None, name: str) -> tuple[Found, int, tuple[str, ...]]:
    """The mesh and the number in it of the one body, or of number `body` from 1; and what to say of it."""
    whole = [(mesh, i) for mesh in found for i in range(len(mesh.solids))]
    broken = [mesh for mesh in found if not mesh.solids]
    if not whole:
        raise PalpateError(broken[0].wrong)
    if body is not None and not 1 <= body <= len(whole):
        held = "one body" if len(whole) == 1 else f"{len(whole)} bodies: {_listed(whole)}"
        raise PalpateError(f"{name} has no body {body}; it holds {held}")
    if body is None and len(whole) > 1:
        raise SeveralBodies(f"{name} holds {len(whole)} bodies", _listed(whole))
    said = (f"{name} also holds {len(broken)} that do not close; left out",) if broken else ()
    return *whole[(body or 1) - 1], said


def _overlap(a: Solid, b: Solid) -> bool:
    low, high = np.maximum(a.bounds[0], b.bounds[0]), np.minimum(a.bounds[1], b.bounds[1])
    if not (low < high).all():
        return False
    return a.shared_volume(b) > _OVERLAP * min(a.volume, b.volume)


def _listed(whole: list[tuple[Found, int]]) -> str:
    lines = []
    for number, (mesh, i) in enumerate(whole[:_LISTED], 1):
        size = " x ".join(f"{side:.4g}" for side in mesh.solids[i].extent)
        label = " ".join(mesh.name.split())[:24].lstrip("0123456789")
        lines.append(f"{number} {label + ' ' if label else ''}({size} mm)")
    more = f", and {len(whole) - _LISTED} more" if len(whole) > _LISTED else ""
    return ", ".join(lines) + more

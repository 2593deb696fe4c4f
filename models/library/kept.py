"""A solid that is made from a tree, with what recognition asks of it kept in the user's cache, to the bit.

    parts/KEY.solid.npz    and .samples, .pairs, .field, .symmetry: each made when first asked for, then mapped

The key is of the tree alone; inside stands a digest of the code that made it, so that what another version made is
made again in its place and the folder does not grow.  Files appear whole or not at all, so any number of processes
may make the same one.  Where nothing may be written, all is made in memory.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.brep import Brep
from models.csg import Csg
from models.library.entry import Computed
from models.library.field import DistanceField
from models.library.folder import VERSION
from models.library.packed import map_arrays, write_arrays
from models.library.samples import SurfaceSamples
from models.solid import TOLERANCE, Solid
from models.symmetry import SymmetryGroup
from primitives.arrays import frozen
from primitives.errors import NotWritten

_Arrays = Mapping[str, NDArray[Any]]
_MAKERS = ("models", "primitives")  # packages that decide what is made of a tree


class Kept:
    """Implements `models.library.entry.Source`."""

    def __init__(self, tree: Csg) -> None:
        self._tree = tree

    @cached_property
    def _made(self) -> Computed:
        a = self._piece("solid", lambda: _solid_arrays(Solid.from_csg(self._tree)))
        return Computed(Solid.from_kept(self._tree, a["vertices"], a["triangles"], a["labels"]))

    @cached_property
    def _key(self) -> str:
        return hashlib.sha256(f"{TOLERANCE} {self._tree!r}".encode()).hexdigest()[:32]

    def solid(self) -> Solid:
        """See `Source`; its manifold is not kept."""
        return self._made.solid()

    def brep(self) -> Brep:
        """See `Source`; it is not kept."""
        return self._made.brep()

    def samples(self) -> SurfaceSamples:
        """See `Source`."""
        a = self._piece("samples", lambda: vars(self._made.samples()))
        return SurfaceSamples(a["points"], a["normals"], a["face"], a["area"], a["curvatures"])

    def pairs(self) -> NDArray[np.uint8]:
        """See `Source`."""
        return self._piece("pairs", lambda: {"pairs": self._made.pairs()})["pairs"]

    def field(self) -> DistanceField:
        """See `Source`."""
        a = self._piece("field", lambda: _field_arrays(self._made.field()))
        return DistanceField(a["values"], a["origin"], *map(float, a["scale"]))

    def symmetry(self) -> SymmetryGroup:
        """See `Source`."""
        a = self._piece("symmetry", lambda: _symmetry_arrays(self._made.symmetry()))
        axis = None if np.isnan(a["axis"]).any() else frozen(a["axis"])
        name = a["name"].tobytes().decode()
        return SymmetryGroup(name, frozen(a["rotations"]), frozen(a["center"]), axis, float(a["order"][0]))

    def _piece(self, kind: str, make: Callable[[], _Arrays]) -> _Arrays:
        home = user_cache("parts")
        path = None if home is None else home / f"{self._key}.{kind}.npz"
        found = None if path is None else map_arrays(path)
        if found is not None and found.get("made_by", np.empty(0)).tobytes() == made_by():
            return found
        made = make()
        if path is not None:
            with suppress(NotWritten):
                write_arrays(path, {**made, "made_by": np.frombuffer(made_by(), np.uint8)})
        return made


def user_cache(inside: str = "") -> Path | None:
    """`$XDG_CACHE_HOME/palpate` or `~/.cache/palpate`, or a folder in it; None where nothing may be written."""
    told = os.environ.get("XDG_CACHE_HOME")
    home = (Path(told) if told else Path.home() / ".cache") / "palpate" / inside
    try:
        home.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return home if os.access(home, os.W_OK) else None


@cache
def made_by() -> bytes:
    """A digest of the code that decides what is made of a tree."""
    digest, root = hashlib.sha256(bytes([VERSION])), Path(__file__).parents[2]
    for package in _MAKERS:
        for path in sorted((root / package).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


def _solid_arrays(solid: Solid) -> _Arrays:
    few = np.int32  # triangles are never that many
    return {
        "vertices": solid.body.vertices,
        "triangles": solid.triangles.astype(few),
        "labels": solid.face_of_triangle.astype(few),
    }


def _field_arrays(field: DistanceField) -> _Arrays:
    return {"values": field.values, "origin": field.origin, "scale": np.array([field.spacing, field.step])}


def _symmetry_arrays(group: SymmetryGroup) -> _Arrays:
    return {
        "name": np.frombuffer(group.name.encode(), np.uint8),
        "rotations": group.rotations,
        "center": group.center,
        "axis": np.full(3, np.nan) if group.axis is None else group.axis,
        "order": np.array([group.order]),
    }

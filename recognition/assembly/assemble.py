"""Fitted faces -> the body that they bound, as a short tree of named primitives.

The faces' planes, cylinders, cones and spheres are regularized together, tested for closure, and those that
touch the body are named: the body is the intersection of the insides of its convex surfaces, less the holes.
Where contacts lie outside a surface that such a body would be inside of, the body is not convex: then the cells
between the surfaces are labelled solid or free by the contacts' normals, and the body is the shortest list of
primitives that holds the solid ones (`concave`).  That asks for contacts on every face, with outward normals.
The same is tried where a hole, taken to reach through the body, would take contacts away with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from models.csg import Csg
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.plate import Plate
from primitives.shapes import Shape, Torus
from recognition.assembly.closure import ClosureOptions, NotClosed, hull
from recognition.assembly.concave import concave_pieces, contradicts_convex
from recognition.assembly.crumbs import without_crumbs
from recognition.assembly.filleted import FILLETED, filleted
from recognition.assembly.given import FittedFace, Given
from recognition.assembly.hollowed import hollowed
from recognition.assembly.joined import JOINED, joined
from recognition.assembly.limbs import with_limbs
from recognition.assembly.made import Body, Known
from recognition.assembly.outlined import outlined
from recognition.assembly.piece import Piece, tree_of
from recognition.assembly.pieces import pieces
from recognition.assembly.regularities import RegularityOptions, Regularized
from recognition.assembly.rounded import ROUNDED, Rounding, balls, rounded, roundings
from recognition.assembly.rounded_rims import Rim, rims

_LOOKED_AT = 4000  # contacts whose distance to the body is looked at


@dataclass(frozen=True)
class AssemblyOptions:
    """How faces become a body."""

    regularity: RegularityOptions = field(default_factory=RegularityOptions)
    closure: ClosureOptions = field(default_factory=ClosureOptions)
    facet: float = 0.005  # [mm] between the mesh and the surfaces
    reach_sigmas: float = 6.0  # of a contact, past which it is outside a convex body
    least_step: float = 0.1  # [mm] the same, however sure the contact
    off_surface: float = 0.002  # share of the contacts off the body, from which a hole went too far
    on_body: float = 0.5  # [mm] from a surface's contacts to the model, so that it has the surface


@dataclass(frozen=True)
class Assembly:
    """A closed body and where it came from."""

    fits: tuple[Fit, ...]  # as measured, planes turned outward
    regularized: Regularized  # jointly adjusted; `shapes[i]` belongs to fit i
    surface_of_fit: tuple[int | None, ...]  # fit that speaks for fit i (itself, or the first that coincides)
    pieces: tuple[Piece, ...]  # their surfaces are indices of fits
    tree: Csg  # in the world
    solid: Solid  # of the tree
    warnings: tuple[str, ...]
    mesh_sigma: float | None = None  # [mm] standard deviation of a freeform surface along its normal

    def __bool__(self) -> bool:
        return True

    def shape(self, fit: int) -> Shape:
        """The adjusted shape of a fit."""
        return self.regularized.shapes[fit]

    @property
    def dropped(self) -> tuple[int, ...]:
        """Fits whose surface does not touch the body."""
        return tuple(i for i, s in enumerate(self.surface_of_fit) if s is None)


def assemble(
    faces: Sequence[FittedFace],
    box: Floats,
    options: AssemblyOptions | None = None,
    free: Floats | None = None,
    stray: Floats | None = None,
    plates: Sequence[Plate] = (),
) -> Assembly | NotClosed:
    """The body inside all faces, or where they leave the (2, 3) workspace `box` [mm] open.

    Nothing is at (n, 3) places `free` [mm], as where an array went in; (m, 3) `stray` ones were felt on no face.
    Of `plates` the outlines are known.
    """
    options = options or AssemblyOptions()
    given = Given.of(faces, options.regularity, free, stray, plates)
    convex = [given.fits[i].convex for i in given.distinct]
    edges, ends = roundings(given.shapes, convex), rims(given.shapes, convex)
    if edges or ends:
        left = given.without({*_numbers(edges, ends), *balls(given.shapes, convex, edges)})
        sharp = _assembled(left, box, options)
        made = None if isinstance(sharp, NotClosed) else _rounded(given, sharp, edges, ends, options)
        if made is not None:
            return made
    return _assembled(given, box, options)


def _rounded(
    given: Given, sharp: Assembly, edges: Sequence[Rounding], ends: Sequence[Rim], options: AssemblyOptions
) -> Assembly | None:
    """A body with its edges rounded, if contacts of their roundings are nearer to it then."""
    straight = [replace(edge, number=given.distinct[edge.number]) for edge in edges]
    turned = [replace(rim, number=given.distinct[rim.number]) for rim in ends]
    places = np.concatenate([given.touched[number][0] for number in _numbers(edges, ends)])
    whole = rounded(sharp.pieces, straight, turned, places, options.facet)
    if whole is None:
        return None
    on = {*(s for s in sharp.surface_of_fit if s is not None), *_numbers(straight, turned)}
    return replace(
        sharp,
        surface_of_fit=tuple(s if s in on else None for s in given.speaker),
        pieces=whole,
        tree=tree_of(whole),
        solid=Solid.from_csg(tree_of(whole), options.facet),
        warnings=(*sharp.warnings, ROUNDED),
    )


def _numbers(edges: Sequence[Rounding], ends: Sequence[Rim]) -> list[int]:
    return [*(edge.number for edge in edges), *(rim.number for rim in ends)]


def _assembled(given: Given, box: Floats, options: AssemblyOptions) -> Assembly | NotClosed:
    """The body of all faces as they are."""
    faces = given.faces
    fits, regularized, distinct, touched = given.fits, given.regularized, given.distinct, given.touched
    sigma = max((float(np.median(f.contacts.sigma)) for f in faces if len(f.contacts)), default=0.0)
    allowed = max(options.reach_sigmas * sigma, options.least_step)
    if _is_concave(given, allowed):
        whole = _from_cells(given, options)
        if not isinstance(whole, NotClosed) or any(f.kind == "torus" for f in fits):
            return whole
    shells = [i for i in distinct if fits[i].convex]
    holes = [i for i in distinct if not fits[i].convex]
    found = hull([regularized.shapes[i] for i in shells], box, options.closure)
    if isinstance(found, NotClosed):
        return replace(found, open_faces=tuple(shells[k] for k in found.open_faces))
    kept = [i for i, a in zip(shells, found.area, strict=True) if a > 0] + holes
    area = {i: float(a) for i, a in zip(shells, found.area, strict=True)}
    named = pieces(
        [regularized.shapes[i] for i in kept],
        [fits[i].convex for i in kept],
        np.array([area.get(i, 0.0) for i in kept]),
        found.corners,
    )
    made = _finished(given, options, tuple(_renumbered(p, kept) for p in named), set(kept))
    made = replace(made, warnings=(*_unused(given, made.surface_of_fit), *made.warnings))
    if not holes or (off := _off_surface(made.solid, touched, allowed)) <= options.off_surface:
        return made
    whole = _from_cells(given, options)
    better = not isinstance(whole, NotClosed) and _off_surface(whole.solid, touched, allowed) < 0.5 * off
    return whole if better else made


def _off_surface(solid: Solid, touched: Sequence[tuple[Floats, Floats]], allowed: float) -> float:
    """Share of the contacts that the body would leave in the air or bury."""
    points = np.concatenate([p for p, _ in touched])
    some = points[np.unique(np.linspace(0, len(points) - 1, _LOOKED_AT).astype(np.int64))]
    return float(np.mean(np.abs(solid.signed_distance(some)) > allowed))


def _is_concave(given: Given, allowed: float) -> bool:
    """Whether contacts lie where no intersection of insides, less its holes, can have a surface."""
    if any(isinstance(shape, Torus) for shape in given.shapes):
        return True
    if not any(f.contacts.has_normal.any() for f in given.faces):
        return False
    convex = np.array([given.fits[i].convex for i in given.distinct])
    return contradicts_convex(given.shapes, convex, given.touched, allowed)


def _from_cells(given: Given, options: AssemblyOptions) -> Assembly | NotClosed:
    """Any body: the list of primitives that the cells between the surfaces ask for."""
    found = concave_pieces(given.shapes, given.touched, given.free, given.inferred)
    if isinstance(found, NotClosed):
        return found
    made = _finished(given, options, tuple(_renumbered(p, given.distinct) for p in found), None)
    warnings = tuple(
        f"face {i} ({given.fits[i].kind}, {len(given.faces[i].contacts)} contacts) lies on no surface of the model"
        for i, s in enumerate(made.surface_of_fit)
        if s is None and given.speaker[i] in given.distinct
    )
    return replace(made, warnings=(*warnings, *made.warnings))


def _finished(
    given: Given, options: AssemblyOptions, named: tuple[Piece, ...], kept: set[int] | None
) -> Assembly:
    """The body of pieces as all evidence has it, with the surfaces `kept`, or all that it has or nobody felt."""
    known = Known(given.shapes, [points for points, _ in given.touched], given.inferred, given.stray)
    unfelt = {given.distinct[k] for k, told in enumerate(given.inferred) if told}
    whole = joined(named, unfelt, given.free, known.felt, options.facet)
    told = (JOINED,) if any(new is not old for new, old in zip(whole, named, strict=True)) else ()
    named = _filleted(given, whole, known, options)
    told = (*told, *((FILLETED,) if len(named) > len(whole) else ()))
    bare = Body(named, Solid.from_csg(tree_of(named), options.facet), options.facet)
    drawn = outlined(bare, given.plates, given.free, known.felt)
    body = hollowed(with_limbs(drawn, given.free, known), given.free, known)
    body = without_crumbs(body, np.concatenate([known.felt, given.stray]))
    more = tuple(_renumbered(piece, given.distinct) for piece in body.pieces[len(named) :])
    on = _surfaces_of(given, body.solid, options.on_body) if kept is None else kept
    on |= {i for piece in more for i in piece.surfaces}
    return Assembly(
        given.fits,
        given.regularized,
        tuple(s if s in on else None for s in given.speaker),
        (*named, *more),
        tree_of((*named, *more)),
        body.solid,
        (*told, *dict.fromkeys(piece.why for piece in more)),
    )


def _filleted(
    given: Given, named: tuple[Piece, ...], known: Known, options: AssemblyOptions
) -> tuple[Piece, ...]:
    """The pieces with those of fillets, numbered as these."""
    whole = filleted(named, known, options.facet)
    return tuple(p if any(p is old for old in named) else _renumbered(p, given.distinct) for p in whole)


def _surfaces_of(given: Given, solid: Solid, near: float) -> set[int]:
    """The speakers whose contacts a solid has on its surface, and those that nobody felt."""
    away = [np.abs(solid.signed_distance(points)) for points, _ in given.touched]
    felt = zip(given.distinct, away, given.inferred, strict=True)
    return {i for i, far, told in felt if told or (len(far) and np.median(far) < near)}


def _unused(given: Given, surface_of_fit: tuple[int | None, ...]) -> tuple[str, ...]:
    return tuple(
        f"face {i} ({given.fits[i].kind}, {len(contacts)} contacts) does not touch the body; left out"
        for i, s in enumerate(surface_of_fit)
        if s is None
        and given.speaker[i] in given.distinct
        and ((contacts := given.faces[i].contacts).touch != NOT_FELT).any()
    )


def _renumbered(piece: Piece, numbers: Sequence[int]) -> Piece:
    ends = tuple(
        (None if a is None else numbers[a], None if b is None else numbers[b]) for a, b in piece.ends
    )
    return replace(piece, body=None if piece.body is None else numbers[piece.body], ends=ends)

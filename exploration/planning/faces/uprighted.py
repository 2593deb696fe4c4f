"""Round faces of few contacts, taken for cylinders along a direction that the object has already.

A pad that met a round end once or twice felt some ten contacts of it, or many on a narrow band.  They fit what
leans, a cone or a cylinder, as well as the cylinder that stands upright on its plate; what leans ends somewhere
else.  A cylinder along a known direction has three parameters, where a cone has six: Schwarz's criterion says what
the contacts pay for (our derivation).  On a low rim the skin bends over both its edges wherever it lies, as on a
piece of a sphere: what such contacts err by together is added to their own sigmas.  The rim of a plate, which ends
at two flats across it, is a cylinder as long as it bulges no more than that; so is a sliver of a rim that begins
at one flat and looks straight out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit, squares
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder, Plane, Shape

_FEW = 30  # contacts, from which a face tells its own direction
_BAND = 0.5  # of a cylinder's radius, along which it was felt at least where it tells its own direction
_PARAMETERS = 3  # of a cylinder along a given direction
_RESIDUALS = 3  # of a point with its normal
_SLACK = 3.0  # times chi2, by which contacts of one touch err together beyond their frames' noise
_LOW = 8.0  # [mm] along a direction, up to which a face lies beside its edges throughout
_BENT = 0.06, 0.1  # [mm], [rad] that contacts and their normals err by there
_PLATE = 1.5  # [mm] from the flats at both ends of a plate's rim, within which it was felt
_BULGE = 0.07  # [mm] rms from a cylinder, up to which such a rim is one
_LEVEL = 0.1  # most cosine between a direction and the median normal of a rim that looks straight out
_SLIVER = 3.0  # [mm] along a direction, up to which a rim that ends at one flat says nothing of its bulge
_TOGETHER = 0.9  # share of a low face's contacts, at least, that lie so low: one may be of what is beside it
_ACROSS = 0.3  # most cosine between a direction and the median contact's normal
_STEP = 30.0  # [mm] along a cylinder, at which it is the same again
_SAME = 0.995  # cosine from which two directions are one
_UPRIGHT = 0.9998  # cosine from which a cylinder stands along a direction as it is


def uprighted(graph: PatchGraph, before: PatchGraph | None = None) -> PatchGraph:
    """The graph with upright cylinders for its few-contact round faces, where their contacts allow it.

    Faces that it had `before` already are left as they are.
    """
    ways, flats = list(directions(graph)), list(_flats(graph))
    faces = []
    for face in graph.faces:
        same = before is not None and any(face is other for other in before.faces)
        found = None if same else _upright(face, ways, flats)
        faces.append(face if found is None else replace(face, fit=found, ranked=()))
    return replace(graph, faces=tuple(faces))


def directions(graph: PatchGraph) -> Iterator[Floats]:
    """(3,) normals and axes of the faces that tell theirs, each once."""
    found: list[Floats] = []
    for face in graph.faces:
        if not isinstance(own := face.fit, Fit):
            continue
        direction = getattr(own.shape, "direction", None)
        if direction is None or len(face.contacts) < _FEW or _narrow(face, own.shape, direction):
            continue
        if all(abs(direction @ other) < _SAME for other in found):
            found.append(direction)
            yield direction


def _flats(graph: PatchGraph) -> Iterator[Plane]:
    """The planes of its flat faces."""
    for face in graph.faces:
        if isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane):
            yield face.fit.shape


def _upright(face: Face, ways: list[Floats], flats: list[Plane]) -> Fit | None:
    """The cylinder along the direction that its contacts like best; None where its own fit explains more."""
    if not isinstance(face.fit, Fit) or face.fit.kind == "plane":
        return None
    felt = face.weighed.select(face.fit.inliers)
    if not len(felt) or (felt.touch == NOT_FELT).any() or not np.isfinite(felt.normals).all():
        return None
    shape = face.fit.shape
    if isinstance(shape, Cylinder) and (side := _flat_side(face.fit, felt, ways, flats)) is not None:
        return side
    if isinstance(shape, Cylinder) and any(
        abs(float(shape.direction @ way)) > _UPRIGHT and not _narrow(face, shape, way) for way in ways
    ):
        return None
    paid = np.log(_RESIDUALS * len(felt))
    best, most = None, 0.0
    for way in ways:
        if np.median(np.abs(felt.normals @ way)) > _ACROSS:
            continue
        told = bent(felt) if float(np.ptp(felt.points @ way)) < _LOW else felt
        made = fit("cylinder", drawn_out(told, way))
        if not isinstance(made, Fit) or (len(face.contacts) >= _FEW and not _narrow(face, made.shape, way)):
            continue
        own, chi2 = squares(face.fit, told).sum(), squares(made, told).sum()
        gain = float(own - chi2) / _SLACK + (len(face.fit.sigma) - _PARAMETERS) * paid
        if made.rms < _BULGE and all(_at_flats(felt, way, flats)):
            gain = max(gain, paid)
        if gain > most:
            rows = face.fit.inliers
            dof = max(_RESIDUALS * len(felt) - _PARAMETERS, 1)
            best, most = replace(made, inliers=rows, chi2=float(chi2), dof=dof), gain
    return best or next((rim for way in ways if (rim := _sliver(face.fit, felt, way, flats))), None)


def _flat_side(own: Fit, felt: Contacts, ways: list[Floats], flats: list[Plane]) -> Fit | None:
    """The plane along the direction that a cylinder lies across, where it was felt on a low side beside a flat.

    A pad that rocked on the narrow side of a plate reads it round about the plate's own edge.
    """
    paid = np.log(_RESIDUALS * len(felt))
    for way in ways:
        low = float(np.ptp(felt.points @ way)) < _LOW
        if not low or abs(float(own.shape.direction @ way)) > _ACROSS or not any(_at_flats(felt, way, flats)):
            continue
        told = bent(felt)
        made = fit("plane", drawn_out(told, way))
        if not isinstance(made, Fit) or made.rms > _BULGE:
            continue
        own_chi2, chi2 = squares(own, told).sum(), squares(made, told).sum()
        gain = float(own_chi2 - chi2) / _SLACK + (len(own.sigma) - _PARAMETERS + 1) * paid
        if gain > 0.0:
            dof = max(_RESIDUALS * len(felt) - _PARAMETERS + 1, 1)
            return replace(made, inliers=own.inliers, chi2=float(chi2), dof=dof)
    return None


def _sliver(own: Fit, felt: Contacts, way: Floats, flats: list[Plane]) -> Fit | None:
    """The cylinder along a (3,) way through nearly all contacts, where they are of a low rim beside a flat."""
    along = felt.points @ way
    low = np.abs(along - np.median(along)) < 0.5 * _SLIVER
    if float(np.mean(low)) < _TOGETHER:
        return None
    rim = felt.select(low)
    level = float(np.median(np.abs(rim.normals @ way))) < _LEVEL
    if not level or not any(_at_flats(rim, way, flats)):
        return None
    told = bent(rim)
    made = fit("cylinder", drawn_out(told, way))
    if not isinstance(made, Fit) or made.rms > _BULGE:
        return None
    rows = own.inliers.copy()
    rows[np.flatnonzero(rows)[~low]] = False
    dof = max(_RESIDUALS * len(rim) - _PARAMETERS, 1)
    return replace(made, inliers=frozen(rows, bool), chi2=float(squares(made, told).sum()), dof=dof)


def _at_flats(felt: Contacts, way: Floats, flats: list[Plane]) -> tuple[bool, bool]:
    """Whether contacts reach a flat across a (3,) way, at either end."""
    along = felt.points @ way
    levels = [
        float(flat.origin @ flat.normal) * np.sign(flat.normal @ way)
        for flat in flats
        if abs(float(flat.normal @ way)) > _SAME
    ]
    low, high = (any(abs(end - level) < _PLATE for level in levels) for end in (along.min(), along.max()))
    return low, high


def bent(felt: Contacts) -> Contacts:
    """The contacts with what those of a low rim err by together."""
    sigma, normal_sigma = np.hypot(felt.sigma, _BENT[0]), np.hypot(felt.normal_sigma, _BENT[1])
    return replace(felt, sigma=sigma, normal_sigma=normal_sigma)


def _narrow(face: Face, shape: Shape, way: Floats) -> bool:
    """Whether a cylinder along a (3,) way was felt on so narrow a band, as of a flange's rim, that its own blur
    turns its axis or bends it into a piece of a sphere.
    """
    if not isinstance(shape, Cylinder):
        return False
    return float(np.ptp(face.contacts.points @ way)) < _BAND * shape.radius


def drawn_out(felt: Contacts, way: Floats) -> Contacts:
    """The contacts, and the same again far up and far down a (3,) direction."""
    moved = [replace(felt, points=felt.points + step * way) for step in (0.0, _STEP, -_STEP)]
    return Contacts.concatenate(moved)

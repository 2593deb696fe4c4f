"""Any cloud of contacts -> the faces that it lies on, from ten contacts to a million.

Looking for shapes takes more than linear time, so it is done on a bounded choice of the contacts; all others then
join the face that explains them best, and what no face explains is looked at again, until nothing new is found.
How far off normals are no table says: the faces that were found tell it, and are looked for again with it.
Without normals a contact joins only faces that contacts near it lie on, and the faces tell each other's senses.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from primitives.arrays import Floats, Ints, frozen
from primitives.between_flats import BetweenFlatsConfig, between_flats
from primitives.evidence import Contacts
from primitives.fit import Fit, FitOptions, NoFit, refit, squares
from primitives.patch_graph import Face, PatchGraph
from primitives.rounded_ends import RoundedEndsConfig, rounded_ends
from primitives.segment import Segment, segment
from recognition.reconstructing.sides import turned_out


@dataclass(frozen=True)
class SurfaceOptions:
    """How much is looked at."""

    chosen: int = 1000  # contacts among which shapes are looked for
    sounded: int = 300  # contacts that tell how far off normals are
    among: int = 20_000  # contacts from which neighbors are taken where no normal was felt
    near: int = 8  # labeled neighbors whose faces a contact joins, and one without a normal joins no other
    apart: float = 9.0  # chi2 by which a face that none of them lies on must explain a contact better
    fitted: int = 20_000  # contacts of a face to which it is fitted
    rounds: int = 3  # times that unexplained contacts are looked at again
    least: float = 0.002  # of all contacts: fewer that are left unexplained are strays
    outlier_chi2: tuple[float, float] = (10.83, 16.27)  # 99.9 % for a point alone, and with its normal
    slack: float = 1.5  # factor on every sigma, for what the sensor model leaves out
    off: float = 1.4  # factor by which normals' sigma must be wrong for faces to be looked for again
    finest: float = 1e-3  # [rad] no normal is known better
    fit: FitOptions = field(default_factory=lambda: FitOptions(gain=1e-6, iterations=20))


def surfaces(contacts: Contacts, options: SurfaceOptions | None = None) -> PatchGraph:
    """The faces; contacts that lie on none are the last, without a fit."""
    options = options or SurfaceOptions()
    order = np.random.default_rng(0).permutation(len(contacts))
    contacts = _with_normal_sigma(contacts, order, options)
    rest, fits = order, list[Fit]()
    owner = np.full(len(contacts), -1, dtype=np.int64)
    for _ in range(options.rounds + 1):
        rows = rest[: options.chosen]
        found = segment(contacts.select(rows), among=contacts.points[rest[: options.among]])
        if not found:
            break
        for k, one in enumerate(found, len(fits)):
            owner[rows[one.rows]] = k
        fits += [one.fit for one in found]
        if len(contacts) <= options.chosen:
            break
        owner = _owners(contacts, fits, owner, options)
        rest = order[owner[order] < 0]
        if len(rest) < max(5, options.least * len(contacts)):
            break
    faces, kept = _faces(contacts, fits, owner, order, options)
    graph = _with_rest(faces, contacts, np.flatnonzero(~np.isin(owner, kept)))
    return _rounded(graph) if contacts.has_normal.all() else turned_out(graph)


def _rounded(graph: PatchGraph) -> PatchGraph:
    """The pieces that a rounded edge between flat faces, or a rounded end of a bar, was found in as one face."""
    felt = BetweenFlatsConfig(laid=False)
    made = rounded_ends(between_flats(graph, felt), RoundedEndsConfig(replace(felt, few=10)))
    faces = sorted(made.faces, key=lambda face: not isinstance(face.fit, Fit))
    return PatchGraph(tuple(replace(face, id=k) for k, face in enumerate(faces)))


def _with_rest(faces: list[Face], contacts: Contacts, rest: Ints) -> PatchGraph:
    """The faces, and at the end what lies on none."""
    alone = (Face(len(faces), NoFit("no face explains these contacts"), contacts.select(rest)),)
    return PatchGraph((*faces, *(alone if len(rest) else ())))


def _with_normal_sigma(contacts: Contacts, order: Ints, options: SurfaceOptions) -> Contacts:
    """With normals as sure as a few contacts' faces say, where that is not what was said."""
    few = contacts.select(np.sort(order[: options.sounded]))
    if not few.has_normal.any():
        return contacts
    sigma = _normal_sigma(few, list(segment(few)), options)
    if sigma is None:
        return contacts
    return replace(contacts, normal_sigma=frozen(np.full(len(contacts), sigma)))


def _normal_sigma(contacts: Contacts, found: list[Segment], options: SurfaceOptions) -> float | None:
    """[rad] as the faces' contacts scatter, where that is not what was said."""
    table = [(contacts.select(one.rows), one.fit) for one in found if len(one.rows) > one.fit.shape.dof]
    felt = [(c, fit) for c, fit in table if c.has_normal.all()]
    if not felt:
        return None
    turned = np.concatenate([_turned(c, fit) for c, fit in felt])
    said = float(np.median(np.concatenate([c.normal_sigma for c, _ in felt])))
    sigma = max(float(np.sqrt(np.median(turned**2) / _MEDIAN_OF_TWO)), options.finest)
    return None if said / options.off < sigma < said * options.off else sigma


_MEDIAN_OF_TWO = 1.386  # of chi2 with two degrees of freedom


def _turned(contacts: Contacts, fit: Fit) -> Floats:
    """(n,) [rad] between felt normals and the shape's."""
    sign = 1.0 if fit.convex else -1.0
    cosine = sign * (fit.shape.normals(contacts.points) * contacts.normals).sum(axis=1)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _faces(
    contacts: Contacts, fits: list[Fit], owner: Ints, order: Ints, options: SurfaceOptions
) -> tuple[list[Face], list[int]]:
    """Every face fitted to more of its contacts than it was found with; and the fits that have one."""
    out: list[Face] = []
    kept: list[int] = []
    for i, near in enumerate(fits):
        mine = order[owner[order] == i]
        whole = len(contacts) <= options.chosen
        if len(mine) < 5 and not whole:
            continue
        some = contacts.select(np.sort(mine[: options.fitted]))
        again = near if whole else refit(near.shape, near.convex, some, options.fit)
        out.append(Face(len(out), again if isinstance(again, Fit) else near, contacts.select(np.sort(mine))))
        kept.append(i)
    return out, kept


def _owners(contacts: Contacts, fits: list[Fit], before: Ints, options: SurfaceOptions) -> Ints:
    """(n,) the face that explains each contact best; -1 where none does.

    One that none of its neighbors lies on must explain it better by `apart`, and without a normal it cannot: two
    faces of one surface, a groove between them, would share its contacts by the side that noise put them on.
    """
    felt = contacts.has_normal
    bound = options.slack**2 * np.where(felt, options.outlier_chi2[1], options.outlier_chi2[0])
    costs = np.stack([squares(fit, contacts) for fit in fits])
    labeled = np.flatnonzero(before >= 0)
    judged = costs
    if len(labeled):
        near = cKDTree(contacts.points[labeled]).query(contacts.points, k=min(options.near, len(labeled)))[1]
        beside = np.zeros(costs.shape, dtype=bool)
        beside[before[labeled[near.reshape(len(contacts), -1)]].T, np.arange(len(contacts))] = True
        judged = np.where(beside, costs, costs + np.where(felt, options.apart, np.inf))
    judged = np.where(costs < bound, judged, np.inf)
    return np.where(np.isfinite(judged).any(axis=0), judged.argmin(axis=0), -1).astype(np.int64)

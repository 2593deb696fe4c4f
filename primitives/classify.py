"""Which shape a patch has: fits ranked by evidence, the simpler first unless the data pays for more.

Each kind scores  chi2 / s + dof ln(residuals) - 2 ln(prior)  (Schwarz's criterion with the noise known), and its
probability is exp(-score / 2), normalized.  s = 1 where the sensor's sigmas hold; where even the best shape leaves
more than they allow, s is its chi2 per degree of freedom, so that unmodeled error does not buy parameters.
Contacts of one touch share errors: what a slim cone explains better than a cylinder is divided by their design
effect (`shared_error`), so that how the pad lay at a rounded rim does not pass for a radius that grows.
A sphere of huge radius, or a cone of tiny angle, lowers chi2 by about one a parameter and pays more for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit, FitOptions, NoFit, fit
from primitives.shapes import KINDS, Cone, Cylinder, Sphere, Torus
from primitives.shared_error import design_effect

_STEP = 0.35  # [rad] round a ring, over which one contact follows another


@dataclass(frozen=True)
class RankOptions:
    """What is assumed about machined parts before any touch; a kind without prior is not tried."""

    prior: dict[str, float] = field(
        default_factory=lambda: {"plane": 0.5, "cylinder": 0.25, "cone": 0.1, "sphere": 0.08, "torus": 0.07}
    )
    largest_radius: float = 2000.0  # [mm] what is rounder than this is its simpler neighbor
    flattest: float = 40.0  # [extents of the contacts across its axis] likewise, of a cylinder or a sphere
    largest_torus: float = np.inf  # [extents of the contacts] likewise, of either radius of a torus
    least_ring: float = 0.15  # [radii of the tube] a torus whose ring is smaller is a sphere
    least_turn: float = 0.0  # [rad] round the tube of a torus, over which its contacts must reach
    least_arc: float = 0.0  # [rad] round its axis, over which contacts must follow one another
    least_angle: float = 0.004  # [rad] a cone steeper than this is a cylinder
    slim: float = 0.1  # [rad] semi-angle up to which errors that contacts share may make a cone of a cylinder
    blunt: float = 1.3  # [rad] semi-angle from which a cone is nearly a plane; few parts have one,
    blunt_share: float = 0.1  # of the prior of cones
    bluntest: float = 1.5  # [rad] semi-angle from which a cone is a plane that was felt badly
    of_a_line: tuple[int, int] = (
        4,
        8,
    )  # contacts of each of two flat sides that may be a cone's, a cylinder's
    as_near: float = 1.1  # times its misfit, likewise,
    one_way: float = 0.12  # [rad] between the ways that the contacts of one side look, likewise,
    aside: float = 0.2  # but for such a share of them, as of a pad that lay half over its rim
    far_worse: float = 4.0  # times its chi2, from which another shape is none either
    unmodeled: bool = True  # whether to let the best fit's excess chi2 stand for unmodeled error
    fit: FitOptions = field(default_factory=lambda: FitOptions(gain=1e-5, iterations=15, starts=2))


@dataclass(frozen=True)
class RankedFit:
    """One kind's fit among its rivals."""

    fit: Fit
    score: float  # -2 ln of the evidence, up to a constant
    probability: float


def rank(
    contacts: Contacts, kinds: Sequence[str] = tuple(KINDS), options: RankOptions | None = None
) -> tuple[RankedFit, ...]:
    """Fits of the kinds, best first; empty where the contacts determine none."""
    options = options or RankOptions()
    tried = [kind for kind in kinds if options.prior.get(kind, 0.0) > 0.0]
    fits = [found for kind in tried if _usable(found := fit(kind, contacts, options.fit), options, contacts)]
    good = [found for found in fits if isinstance(found, Fit)]
    good = _without_two_flats(good, contacts, options)
    if not good:
        return ()
    if _cylinder_in_disguise(good, contacts, options):
        good = [found for found in good if found.kind != "cone"]
    excess = min(found.chi2 / max(found.dof, 1) for found in good) if options.unmodeled else 1.0
    scores = np.array([score(found, options, max(1.0, excess)) for found in good])
    weights = np.exp(-0.5 * (scores - scores.min()))
    weights = weights / weights.sum()
    order = np.argsort(scores, kind="stable")
    return tuple(RankedFit(good[i], float(scores[i]), float(weights[i])) for i in order)


def score(found: Fit, options: RankOptions, excess: float = 1.0) -> float:
    """-2 ln of one fit's evidence, up to what all fits of the same contacts share."""
    parameters = found.shape.dof
    price = parameters * np.log(max(found.dof + parameters, 2))
    prior = options.prior[found.kind]
    if isinstance(found.shape, Cone) and found.shape.semi_angle > options.blunt:
        prior *= options.blunt_share
    return float(found.chi2 / excess + price - 2.0 * np.log(prior))


def _cylinder_in_disguise(good: Sequence[Fit], contacts: Contacts, options: RankOptions) -> bool:
    """Whether a cone explains no more than a cylinder and errors that contacts share."""
    found = {one.kind: one for one in good}
    if not {"cone", "cylinder"} <= set(found):
        return False
    if isinstance(shape := found["cone"].shape, Cone) and shape.semi_angle > options.slim:
        return False
    cone, cylinder = (score(found[kind], options) for kind in ("cone", "cylinder"))
    gain = found["cylinder"].chi2 - found["cone"].chi2
    return cone + gain * (1.0 - 1.0 / design_effect(contacts)) > cylinder


def _usable(found: Fit | NoFit, options: RankOptions, contacts: Contacts) -> bool:
    """Whether a fit is no simpler shape in disguise."""
    if not isinstance(found, Fit):
        return False
    shape = found.shape
    if isinstance(shape, Torus) and shape.radius < options.least_ring * shape.minor_radius:
        return False
    if isinstance(shape, Torus) and not _ringlike(shape, options, contacts):
        return False
    if isinstance(shape, Cone):
        return options.least_angle < shape.semi_angle < options.bluntest
    if isinstance(shape, Cylinder | Sphere) and shape.radius >= options.flattest * _across(shape, contacts):
        return False
    return not isinstance(shape, Cylinder | Sphere | Torus) or shape.radius < options.largest_radius


def _without_two_flats(good: list[Fit], contacts: Contacts, options: RankOptions) -> list[Fit]:
    """The fits less what two planes explain as well, what has as many parameters as it, and what is far worse."""
    flats = [found for found in good if two_flats(found, contacts, options)]
    if not flats:
        return good
    worst = options.far_worse * max(1.0, min(found.chi2 / max(found.dof, 1) for found in flats))
    fewest = min(found.shape.dof for found in flats)
    return [found for found in good if found.shape.dof < fewest and found.chi2 / max(found.dof, 1) < worst]


def two_flats(found: Fit, contacts: Contacts, options: RankOptions) -> bool:
    """Whether a cone or a cylinder was felt along two narrow strips alone, which two planes explain as well.

    So it is with the narrow sides of a plate: any two planes are tangent to some cone, parallel ones to a
    cylinder.  Where a pad lay on a cylinder, the strip goes round it as far as the skin gives.
    """
    shape = found.shape
    if not isinstance(shape, Cone | Cylinder) or (
        isinstance(shape, Cone) and shape.semi_angle < options.slim
    ):
        return False
    out = (contacts.points - shape.anchor) @ shape.frame[:, :2]
    side = out @ np.linalg.svd(out, full_matrices=False)[2][0] > 0.0
    if min(side.sum(), (~side).sum()) < options.of_a_line[isinstance(shape, Cylinder)]:
        return False  # few contacts on two lines are a cylinder's as often
    if isinstance(shape, Cylinder) and max(_turn(out[lot]) for lot in (side, ~side)) > options.one_way:
        return False
    near = options.as_near * max(found.rms, float(np.median(contacts.sigma)))
    lots = [(contacts.select(lot), out[lot]) for lot in (side, ~side)]
    off = np.sqrt(sum(len(lot) * _off_flat(lot.points) ** 2 for lot, _ in lots) / len(contacts))
    return bool(off < near) and all(_faces_one_way(lot, away, options) for lot, away in lots)


def _turn(out: Floats) -> float:
    """[rad] round an axis, over which four fifths of (n, 2) ways out of it lie about their mean."""
    mean = out.mean(axis=0)
    around = np.arctan2(mean[0] * out[:, 1] - mean[1] * out[:, 0], out @ mean)
    return float(np.subtract(*np.quantile(around, [0.9, 0.1])))


def _faces_one_way(lot: Contacts, out: Floats, options: RankOptions) -> bool:
    """Whether contacts look one way, but for strays; where they do not tell, whether (n, 2) ways `out` are one."""
    told = lot.has_normal
    ways = (
        lot.normals[told]
        if told.any()
        else out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    )
    mean = ways.mean(axis=0)
    length = float(np.linalg.norm(mean))
    unsure = 3.0 * float(np.median(lot.normal_sigma[told])) if told.any() else 0.0
    facing = float(np.quantile(ways @ mean / length, options.aside)) if length > 0.0 else 0.0
    return bool(facing > np.cos(max(options.one_way, unsure)))


def _off_flat(points: Floats) -> float:
    """[mm] rms of (n, 3) points from the plane nearest to them."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(spread[-1] / np.sqrt(len(points)))


def _across(shape: Cylinder | Sphere, contacts: Contacts) -> float:
    """[mm] that contacts extend across a cylinder's axis, or at all on a sphere."""
    points = contacts.points @ shape.frame[:, :2] if isinstance(shape, Cylinder) else contacts.points
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _ringlike(shape: Torus, options: RankOptions, contacts: Contacts) -> bool:
    """Whether contacts reach so far round a torus, and round its tube, that they tell it from a narrow ring."""
    extent = float(np.ptp(contacts.points, axis=0).max())
    away = contacts.points - shape.center
    along = away @ shape.axis
    out = np.linalg.norm(away - along[:, None] * shape.axis, axis=1) - shape.radius
    turn = float(np.ptp(np.arctan2(along, out)))
    small = max(shape.sizes) <= options.largest_torus * extent
    return small and turn >= options.least_turn and _followed(away @ shape.frame) >= options.least_arc


def _followed(local: Floats) -> float:
    """[rad] round the z axis of (n, 3) points, of the longest run of them: two ends far apart make no ring."""
    around = np.sort(np.arctan2(local[:, 1], local[:, 0]))
    runs = np.split(around, np.flatnonzero(np.diff(around) > _STEP) + 1)
    return max(float(np.ptp(run)) for run in runs)

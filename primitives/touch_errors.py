"""What the contacts of one reading, and of one touch, err by together, as their disagreement tells it.

A stage errs too, and nobody says by how much.  Its error while a frame is read moves all contacts of that frame,
and what it is off by throughout a touch moves and turns all contacts of the touch.  With r the residuals of a face
(distances, and the leans of normals), J their derivative by the shape's step x, and G_t that by a small motion of
touch t, a linear mixed model has::

    r = -J x + G_t u_t + v + e,
    u_t ~ N(0, diag(touch^2 / 2, turn^2)),  v ~ N(0, reading^2) for the distances of each reading,  e ~ N(0, S).

Touches move along three axes and along the normals, as a stage errs in its own frame or in that of the pad which
it turns, and turn about their middle.  Of the sensor's own variances S each shares a part (`shared_error`).  The
three deviations are one for all faces: those of greatest restricted likelihood (REML; Patterson and Thompson
1971) with a gamma(2) prior of each, so that few touches, which agree by chance, do not make it nothing (Chung et
al. 2013).  The readings of a touch scatter as their own differences say, as far as these are many, for some are
read while the stage moves and others at rest.

Each shape is then fitted anew with these covariances (generalized least squares, by Woodbury's identity), so that
a long stroke counts as the one touch that it is.  Where touches scatter still more its covariance grows (Birge
1932).  What a fit knows beside its contacts, as that a hole's axis is parallel to another's, it keeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from primitives.arrays import Floats, Ints, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.residuals import Problem, advance, chart, linearize
from primitives.shapes import Shape
from primitives.shared_error import SHARE, with_shared_error

_USUAL = np.array([0.02, 0.02, 3e-4])  # [mm, mm, rad] from which the search starts
_LARGE = np.array([0.05, 0.05, 1e-3])  # [mm, mm, rad] modes of the priors
_LEAST = 1e-7  # [mm, rad]
_OWN = 4.0  # readings' worth of evidence that a touch scatters as all do
_STRAY = 5.0  # standard deviations beyond which a contact tells nothing
_BESIDE = 10.0  # times the information in the contacts, from which a fit knows more than they
_HALF = np.sqrt(0.5)
_SINGULAR = 1e-12  # least over greatest eigenvalue of a scaled information


class Felt(Protocol):
    """A face: its fit, and the contacts behind it."""

    @property
    def fit(self) -> Fit:
        """Its surface."""
        ...

    @property
    def contacts(self) -> Contacts:
        """The evidence for it."""
        ...


@dataclass(frozen=True)
class TouchErrors:
    """Standard deviations of what contacts err by together."""

    reading: float  # [mm] along the normal, of all contacts of a frame
    touch: float  # [mm] per axis, of all of a touch
    turn: float  # [rad] per axis, of all of a touch about its middle


def fits_of_touches(faces: Sequence[Felt]) -> list[Fit]:
    """Every face's fit as its touches tell it, its chi2 as large as its degrees of freedom.

    What was not felt, and contacts that are each their own touch, say nothing of that: see `with_shared_error`.
    """
    equations = _all(faces)
    errors = _restricted_likelihood(list(equations.values()))
    return [
        equations[i].solved(errors) if i in equations else with_shared_error(face.fit, face.contacts)
        for i, face in enumerate(faces)
    ]


def touch_errors(faces: Sequence[Felt]) -> TouchErrors:
    """What touches of these faces err by; `_USUAL` where none was touched by more than a contact at a time."""
    return _restricted_likelihood(list(_all(faces).values()))


def _all(faces: Sequence[Felt]) -> dict[int, _Equations]:
    """The equations of each face that tells of touches."""
    made = {
        i: _Equations(face.fit, _sound(face.fit, face.contacts))
        for i, face in enumerate(faces)
        if _by_touches(face.contacts)
    }
    return {i: equations for i, equations in made.items() if equations.determined}


def _by_touches(contacts: Contacts) -> bool:
    """Whether contacts were felt, several to a touch."""
    return bool((contacts.touch != NOT_FELT).all()) and len(np.unique(contacts.touch)) < len(contacts)


def _sound(fit: Fit, contacts: Contacts) -> Contacts:
    """Contacts less strays, in the order of their touches."""
    side = 1.0 if fit.convex else -1.0
    away = np.abs(fit.shape.signed_distance(contacts.points)) / contacts.sigma
    facing = side * (fit.shape.normals(contacts.points) * np.nan_to_num(contacts.normals)).sum(axis=1)
    lean = np.where(contacts.has_normal, np.arccos(np.clip(facing, -1.0, 1.0)) / contacts.normal_sigma, 0.0)
    kept = np.ones(len(contacts), dtype=bool)
    for off in (away, lean):
        kept &= off <= _STRAY * max(1.0, 1.48 * float(np.median(off)))
    rows = np.flatnonzero(kept)
    return contacts.select(rows[np.argsort(contacts.touch[rows], kind="stable")])


@dataclass(frozen=True)
class _Normal:
    """Normal equations of a shape's step in its chart, all errors weighed."""

    information: Floats  # (p, p)
    slope: Floats  # (p,)
    squares: float  # weighted sum of the squared residuals
    log_determinant: float  # of their covariance


class _Equations:
    """A face about its fit: products of residuals, and of what moves them, by reading and by touch."""

    def __init__(self, fit: Fit, contacts: Contacts) -> None:
        self.fit, self.contacts = fit, contacts
        problem, n = Problem.of(contacts), len(contacts)
        self.center, self.chart = problem.center, chart(fit.shape, problem.center)
        residuals, jacobian = linearize(fit.shape, problem, 1.0 if fit.convex else -1.0)
        steps = jacobian @ self.chart
        self.parameters, self.count = steps.shape[1], len(residuals)
        touch = np.unique(contacts.touch, return_inverse=True)[1]
        distances = np.column_stack([steps[:n], residuals[:n], _moves(fit.shape, contacts, touch)])
        leans = np.column_stack([steps[n:], residuals[n:], _leans(fit.shape, problem)])
        distances[:, : self.parameters + 1] *= contacts.sigma[:, None]
        weight = 1.0 / ((1.0 - SHARE) * contacts.sigma**2)
        self.products = np.zeros(
            (int(touch[-1]) + 1, distances.shape[1], distances.shape[1])
        )  # of each touch
        turned = np.tile(touch[problem.felt], 2)
        for t, product in enumerate(self.products):
            mine, beside = distances[touch == t], leans[turned == t]
            product += (mine * weight[touch == t][:, None]).T @ mine + beside.T @ beside / (1.0 - SHARE)
        firsts = _firsts(_readings(contacts))
        self.weights = np.add.reduceat(weight, firsts)  # of each reading
        self.sums = np.add.reduceat(distances * weight[:, None], firsts)  # of each reading
        self.touch = touch[firsts]  # of each reading
        self.scatter = np.ones(len(firsts))  # of each reading's variance, over what is usual
        self.log_own = float(len(turned) * np.log(1.0 - SHARE) - np.log(weight).sum())
        self.beside = _known_beside(steps.T @ steps, fit, self.chart)
        self.determined = _inverse(steps.T @ steps + self.beside) is not None

    def differences(self) -> tuple[Floats, Ints]:
        """(t,) [mm^2] squares by which each touch's readings differ among themselves, and how many are free to."""
        mean, first = self.sums[:, self.parameters] / self.weights, _firsts(self.touch)
        many = np.diff([*first, len(mean)])
        about = mean - np.repeat(np.add.reduceat(mean, first) / many, many)
        return np.add.reduceat(about**2, first), many - 1

    def weighed(self, errors: TouchErrors) -> _Normal:
        """With what readings scatter by, and each touch's errors weighed against what is expected of them."""
        p, variance = self.parameters, errors.reading**2 * self.scatter
        grown = 1.0 + variance * self.weights
        common = self.sums * np.sqrt(variance / grown)[:, None]
        squares = common[:, :, None] * common[:, None, :]
        products = self.products - np.add.reduceat(squares, _firsts(self.touch))
        expected = np.array([_HALF * errors.touch] * 4 + [errors.turn] * 3 + [1.0] * 4) ** 2
        within = np.diag(1.0 / expected) + products[:, p + 1 :, p + 1 :]
        across = products[:, p + 1 :, : p + 1]
        left = products[:, : p + 1, : p + 1].sum(axis=0) - np.einsum(
            "tij,tik->jk", across, np.linalg.solve(within, across)
        )
        spread = np.linalg.slogdet(within)[1].sum() + len(within) * np.log(expected).sum()
        log_determinant = self.log_own + float(np.log(grown).sum() + spread)
        return _Normal(left[:p, :p] + self.beside, left[:p, p], float(left[p, p]), log_determinant)

    def solved(self, errors: TouchErrors) -> Fit:
        """The fit moved to where its touches put it, with the covariance that they give it."""
        normal, fit = self.weighed(errors), self.fit
        covariance = _inverse(normal.information)
        if covariance is None:
            return with_shared_error(fit, self.contacts)
        step = -covariance @ normal.slope
        left = (normal.squares + float(normal.slope @ step)) / max(self.count - len(step), 1)
        shape = advance(fit.shape, self.center, step) or fit.shape
        again = _Equations(replace(fit, shape=shape), self.contacts)
        again.scatter = self.scatter
        if again.weighed(errors).squares > normal.squares:  # slopes tell nothing as far as that
            shape = fit.shape
        rms = float(np.sqrt(np.mean(shape.signed_distance(self.contacts.points) ** 2)))
        matrix = chart(shape, self.center)
        scaled = max(1.0, left) * matrix @ covariance @ matrix.T
        return replace(fit, shape=shape, covariance=frozen(scaled), rms=rms, chi2=float(fit.dof))


def _moves(shape: Shape, contacts: Contacts, touch: Ints) -> Floats:
    """(n, 11) [mm] by how much contacts leave a face as their touch moves, turns, and errs as its sensor does."""
    out = shape.normals(contacts.points)
    firsts = _firsts(touch)
    size = np.diff([*firsts, len(out)])
    middle = np.add.reduceat(contacts.points, firsts) / size[:, None]
    arm = np.cross(contacts.points - middle[touch], out)
    ones = np.ones(len(out))
    return np.column_stack([out, ones, arm, np.sqrt(SHARE) * contacts.sigma, np.zeros((len(out), 3))])


def _leans(shape: Shape, problem: Problem) -> Floats:
    """(2k, 11) [sigma] by how much normals lean for the same; along the profile, then round the axis."""
    _, radial, field = shape.profile_at(problem.points[problem.felt])
    c, s = field.radial, field.axial
    along = np.column_stack([-s * radial[:, 0], -s * radial[:, 1], c])
    round_ = np.column_stack([-radial[:, 1], radial[:, 0], np.zeros(len(c))])
    out = np.column_stack([c * radial[:, 0], c * radial[:, 1], s])
    leans = np.concatenate([np.cross(out, tangent) @ shape.frame.T for tangent in (along, round_)])
    turned = leans * np.tile(problem.normal_weight, 2)[:, None]
    none = np.zeros((len(leans), 4))
    return np.column_stack([none, turned, none[:, :1], np.sqrt(SHARE) * leans])


def _known_beside(told: Floats, fit: Fit, matrix: Floats) -> Floats:
    """(p, p) information of a fit beyond what its contacts have `told`, where that is most of it."""
    into = np.linalg.inv(matrix)
    known = _inverse(into @ fit.covariance @ into.T)
    if known is None:
        return np.zeros_like(told)
    scale = np.sqrt(np.maximum(np.diag(known), np.diag(told)))
    values, vectors = np.linalg.eigh(known / np.outer(scale, scale))
    asked = np.einsum("ij,ik,kj->j", vectors, told / np.outer(scale, scale), vectors)
    more = np.where(values > _BESIDE * np.maximum(asked, 0.0), values - asked, 0.0)
    return np.asarray((vectors * more) @ vectors.T * np.outer(scale, scale))


def _inverse(matrix: Floats) -> Floats | None:
    """The inverse of a covariance or an information; None where it has none."""
    diagonal = np.diag(matrix)
    if not (np.isfinite(matrix).all() and (diagonal > 0.0).all()):
        return None
    scale = 1.0 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(matrix * np.outer(scale, scale))
    if values[0] < _SINGULAR * values[-1]:
        return None
    return np.asarray((vectors / values) @ vectors.T * np.outer(scale, scale))


def _readings(contacts: Contacts) -> Ints:
    """(n,) which reading, of contacts in the order of their touches: those of a flat frame have one normal."""
    alike = (contacts.normals[1:] == contacts.normals[:-1]).all(axis=1)
    alike &= contacts.touch[1:] == contacts.touch[:-1]
    return np.concatenate([[0], np.cumsum(~alike)])


def _firsts(ordered: Ints) -> Ints:
    """Where each run of equal numbers begins."""
    return np.flatnonzero(np.diff(ordered, prepend=-1))


def _restricted_likelihood(faces: Sequence[_Equations]) -> TouchErrors:
    """The deviations that maximize it, with their priors."""
    start = np.log(_USUAL)
    if not faces:
        return TouchErrors(*_USUAL)
    _by_their_own_scatter(faces)

    def cost(logs: Floats) -> float:
        deviations = np.exp(logs)
        total = 2.0 * float((deviations / _LARGE - logs).sum())
        errors = TouchErrors(*np.maximum(deviations, _LEAST))
        for face in faces:
            normal = face.weighed(errors)
            gain = float(normal.slope @ np.linalg.solve(normal.information, normal.slope))
            total += normal.log_determinant + float(np.linalg.slogdet(normal.information)[1])
            total += normal.squares - gain
        return total

    simplex = np.vstack([start, start + 0.7 * np.eye(3)])
    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={"xatol": 0.05, "fatol": 0.02, "maxfev": 200, "initial_simplex": simplex},
    )
    return TouchErrors(*map(float, np.maximum(np.exp(found.x), _LEAST)))


def _by_their_own_scatter(faces: Sequence[_Equations]) -> None:
    """Let the readings of each touch scatter as their own differences and those of all say together."""
    told = [face.differences() for face in faces]
    free = sum(int(many.sum()) for _, many in told)
    usual = sum(float(squares.sum()) for squares, _ in told) / max(free, 1)
    if usual <= 0.0:
        return
    for face, (squares, many) in zip(faces, told, strict=True):
        own = (_OWN * usual + squares) / (_OWN + many) / usual
        face.scatter = own[face.touch]

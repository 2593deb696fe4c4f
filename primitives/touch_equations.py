"""A face about its fit: what its contacts say of a step of its shape, and of the errors of their touches.

The model is `touch_errors`'.  Everything that is asked of a face are products of columns summed by reading and by
touch, so that other deviations cost no pass over the contacts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from primitives.arrays import Floats, Ints, frozen
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.residuals import Problem, advance, chart, linearize
from primitives.shapes import Shape
from primitives.shared_error import SHARE, with_shared_error

_STRAY = 5.0  # standard deviations beyond which a contact tells nothing
_BESIDE = 10.0  # times the information in the contacts, from which a fit knows more than they
_HALF = np.sqrt(0.5)
_ROUGH = 2.0  # times its misfit, from which a fit was not made with the contacts' own sigmas
_SINGULAR = 1e-12  # least over greatest eigenvalue of a scaled information


@dataclass(frozen=True)
class TouchErrors:
    """Standard deviations of what contacts err by together."""

    reading: float  # [mm] along the normal, of all contacts of a frame
    touch: float  # [mm] per axis, of all of a touch
    turn: float  # [rad] per axis, of all of a touch about its middle


def sound(fit: Fit, contacts: Contacts) -> Contacts:
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
class Normal:
    """Normal equations of a shape's step in its chart, all errors weighed."""

    information: Floats  # (p, p)
    slope: Floats  # (p,)
    squares: float  # weighted sum of the squared residuals
    log_determinant: float  # of their covariance


class Equations:
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
        columns = distances.shape[1]
        self.products = np.zeros((int(touch[-1]) + 1, columns, columns))  # of each touch
        turned = np.tile(touch[problem.felt], 2)
        for t, product in enumerate(self.products):
            mine, beside = distances[touch == t], leans[turned == t]
            product += (mine * weight[touch == t][:, None]).T @ mine + beside.T @ beside / (1.0 - SHARE)
        firsts = first_of_readings(contacts)
        self.weights = np.add.reduceat(weight, firsts)  # of each reading
        self.sums = np.add.reduceat(distances * weight[:, None], firsts)  # of each reading
        self.touch = touch[firsts]  # of each reading
        self.scatter = np.ones(len(firsts))  # of each reading's variance, over what is usual
        self.log_own = float(len(turned) * np.log(1.0 - SHARE) - np.log(weight).sum())
        fitted = Problem.of(_as_fitted(fit, contacts, float(np.mean(residuals**2)) if n else 0.0))
        told = linearize(fit.shape, fitted, 1.0 if fit.convex else -1.0)[1] @ self.chart
        self.beside = _known_beside(told.T @ told, fit, self.chart)
        self.determined = _inverse(told.T @ told + self.beside) is not None

    def differences(self) -> tuple[Floats, Ints]:
        """(t,) [mm^2] squares by which each touch's readings differ among themselves, and how many are free to."""
        mean, first = self.sums[:, self.parameters] / self.weights, _firsts(self.touch)
        many = np.diff([*first, len(mean)])
        about = mean - np.repeat(np.add.reduceat(mean, first) / many, many)
        return np.add.reduceat(about**2, first), many - 1

    def weighed(self, errors: TouchErrors) -> Normal:
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
        return Normal(left[:p, :p] + self.beside, left[:p, p], float(left[p, p]), log_determinant)

    def solved(self, errors: TouchErrors) -> Fit:
        """The fit moved to where its touches put it, with the covariance that they give it."""
        normal, fit = self.weighed(errors), self.fit
        covariance = _inverse(normal.information)
        if covariance is None:
            return with_shared_error(fit, self.contacts)
        step = -covariance @ normal.slope
        left = (normal.squares + float(normal.slope @ step)) / max(self.count - len(step), 1)
        shape = advance(fit.shape, self.center, step) or fit.shape
        again = Equations(replace(fit, shape=shape), self.contacts)
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
    scale = np.sqrt(np.diag(known))
    share, ways = eigh(told / np.outer(scale, scale), known / np.outer(scale, scale))
    half = (known / scale) @ ways  # known = half half'
    more = np.where(share < 1.0 / _BESIDE, 1.0 - np.maximum(share, 0.0), 0.0)
    return np.asarray((half * more) @ half.T)


def _as_fitted(fit: Fit, contacts: Contacts, misfit: float) -> Contacts:
    """Contacts as the fit took them to err: as they say, or, where `misfit` is far beyond its own, as they do.

    `misfit` is their mean squared residual by their own sigmas.
    """
    if misfit < _ROUGH * max(1.0, fit.chi2 / max(fit.dof, 1)):
        return contacts
    beyond = max(0.0, fit.rms**2 - float(np.mean(contacts.sigma**2)))
    return replace(contacts, sigma=frozen(np.sqrt(contacts.sigma**2 + beyond)))


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


def first_of_readings(contacts: Contacts) -> Ints:
    """Where each reading begins, of contacts touch by touch: those of a flat frame have one normal."""
    alike = (contacts.normals[1:] == contacts.normals[:-1]).all(axis=1)
    alike &= contacts.touch[1:] == contacts.touch[:-1]
    return np.flatnonzero(np.concatenate([[True], ~alike]))


def _firsts(ordered: Ints) -> Ints:
    """Where each run of equal numbers begins."""
    return np.flatnonzero(np.diff(ordered, prepend=-1))

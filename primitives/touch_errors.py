"""What the contacts of one reading, and of one touch, err by together, as their disagreement tells it.

A stage errs too, and nobody says by how much.  Its error while a frame is read moves all contacts of that frame,
and what it is off by throughout a touch moves and turns all contacts of the touch.  With J the derivative of the
distances by the shape's step, G_t that by a small motion of touch t (along and about three axes through its
middle), and S the contacts' own variances, the distances r of a face are taken to be::

    r = -J x + G_t u_t + v_reading + e,
    u ~ N(0, diag(touch^2 I, turn^2 I)),  v ~ N(0, reading^2),  e ~ N(0, S),

and of S a share is common to the touch (`shared_error`).  The three deviations are one for all faces: those of
greatest restricted likelihood (Patterson and Thompson 1971), to which their logarithms are added so that few
touches, which agree by chance, do not make them nothing (Chung et al. 2013).  Some touches are read while the
stage moves and others at rest: each one's readings scatter as their own differences say, as far as these are many.

Each shape is then fitted anew with these covariances (generalized least squares, by Woodbury's identity), so that
a long stroke counts as the one touch that it is.  Where touches scatter still more its covariance grows (Birge
1932).
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
from primitives.shared_error import SHARE, with_shared_error

_USUAL = np.array([0.02, 0.02, 3e-4])  # [mm, mm, rad] from which the search starts
_LARGE = np.array([0.05, 0.05, 1e-3])  # [mm, mm, rad] beyond which they become unlikely
_LEAST = 1e-7  # [mm, rad]
_OWN = 4.0  # readings' worth of evidence that a touch scatters as all do
_STRAY = 5.0  # standard deviations beyond which a contact tells nothing


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
    """Every face's fit as its touches tell it.

    What was not felt, and contacts that are each their own touch, say nothing of that: see `with_shared_error`.
    """
    known = {i: _Equations(face) for i, face in enumerate(faces) if _by_touches(face.contacts)}
    errors = _likeliest(list(known.values()))
    return [
        known[i].solved(errors) if i in known else with_shared_error(face.fit, face.contacts)
        for i, face in enumerate(faces)
    ]


def touch_errors(faces: Sequence[Felt]) -> TouchErrors:
    """What touches of these faces err by; `_USUAL` where none was touched by more than a contact at a time."""
    return _likeliest([_Equations(face) for face in faces if _by_touches(face.contacts)])


def _by_touches(contacts: Contacts) -> bool:
    """Whether contacts were felt, several to a touch."""
    return bool((contacts.touch != NOT_FELT).all()) and len(np.unique(contacts.touch)) < len(contacts)


@dataclass(frozen=True)
class _Sums:
    """Normal equations of a face, whose readings scatter and whose touches do not err yet."""

    information: Floats  # (p, p) of the shape's step
    slope: Floats  # (p,)
    square: float  # of the residuals
    log_spread: float  # log of the determinant of their covariance
    within: Floats  # (t, 7, 7) of the errors of each touch
    across: Floats  # (t, 7, p) of these and the step
    pull: Floats  # (t, 7)


@dataclass(frozen=True)
class _Solved:
    """The same with the errors of the touches."""

    information: Floats
    slope: Floats
    square: float
    log_spread: float


class _Equations:
    """A face about its fit: residuals, what moves them, and which readings and touches they belong to."""

    def __init__(self, face: Felt) -> None:
        fit = face.fit
        away = np.abs(fit.shape.signed_distance(face.contacts.points)) / face.contacts.sigma
        sound = np.flatnonzero(away <= _STRAY * max(1.0, 1.48 * float(np.median(away))))
        contacts = face.contacts.select(sound[np.argsort(face.contacts.touch[sound], kind="stable")])
        self.fit, self.contacts, self.problem = fit, contacts, Problem.of(contacts)
        n = len(contacts)
        residuals, jacobian = linearize(fit.shape, self.problem, 1.0 if fit.convex else -1.0)
        self.sigma = contacts.sigma
        self.distance, self.step = residuals[:n] * self.sigma, jacobian[:n] * self.sigma[:, None]
        self.touch = np.unique(contacts.touch, return_inverse=True)[1]
        self.touches = _firsts(self.touch)
        self.reading = _readings(contacts)
        self.readings = _firsts(self.reading)
        self.scatter = np.ones(len(self.readings))  # of each reading, over what is usual
        self.motion = self._motions()
        self.turned = self._of_normals(residuals[n:], jacobian[n:])
        self.count = len(residuals)

    def _motions(self) -> Floats:
        """(n, 7) by how much a contact leaves the face as its touch moves and turns, and by their common share."""
        out = self.fit.shape.normals(self.problem.points)
        size = np.diff([*self.touches, len(out)])
        middle = np.add.reduceat(self.problem.points, self.touches) / size[:, None]
        arm = np.cross(self.problem.points - middle[self.touch], out)
        return np.column_stack([out, arm, np.sqrt(SHARE) * self.sigma])

    def _of_normals(self, residuals: Floats, jacobian: Floats) -> tuple[Floats, Floats, float]:
        """Information, slope and squares of the normals, of which each touch shares a part of their variance."""
        touch, k, p = self.touch[self.problem.felt], len(self.problem.felt), jacobian.shape[1]
        information, slope, square = np.zeros((p, p)), np.zeros(p), 0.0
        size = np.bincount(touch, minlength=len(self.touches))
        weight = SHARE / (1.0 - SHARE + SHARE * size)
        for part in (slice(0, k), slice(k, 2 * k)):
            rows, off = jacobian[part], residuals[part]
            common = np.zeros((len(size), p))
            np.add.at(common, touch, rows)
            beside = np.bincount(touch, off, minlength=len(size))
            information += (rows.T @ rows - (common * weight[:, None]).T @ common) / (1.0 - SHARE)
            slope += (rows.T @ off - (common * weight[:, None]).T @ beside) / (1.0 - SHARE)
            square += float(off @ off - (weight * beside) @ beside) / (1.0 - SHARE)
        return information, slope, square

    def differences(self) -> tuple[Floats, Ints]:
        """(t,) [mm^2] squares by which each touch's readings differ among themselves, and how many are free to."""
        weight = self.sigma**-2
        mean = np.add.reduceat(weight * self.distance, self.readings) / np.add.reduceat(weight, self.readings)
        first = _firsts(self.touch[self.readings])
        many = np.diff([*first, len(mean)])
        about = mean - np.repeat(np.add.reduceat(mean, first) / many, many)
        return np.add.reduceat(about**2, first), many - 1

    def sums(self, reading: float) -> _Sums:
        """With readings that scatter by so much [mm]."""
        p, weight = self.step.shape[1], 1.0 / ((1.0 - SHARE) * self.sigma**2)
        variance = reading**2 * self.scatter
        grown = 1.0 + variance * np.add.reduceat(weight, self.readings)
        columns = np.column_stack([self.step, self.distance, self.motion])
        weighted = columns * weight[:, None]
        common = np.add.reduceat(weighted, self.readings) * (variance / grown)[:, None]
        weighted -= weight[:, None] * common[self.reading]
        by_touch = np.add.reduceat(self.motion[:, :, None] * weighted[:, None, :], self.touches)
        log_spread = float(np.log(grown).sum() - np.log(weight).sum())
        return _Sums(
            self.step.T @ weighted[:, :p],
            self.step.T @ weighted[:, p],
            float(self.distance @ weighted[:, p]),
            log_spread,
            by_touch[:, :, p + 1 :],
            by_touch[:, :, :p],
            by_touch[:, :, p],
        )

    def with_errors(self, errors: TouchErrors) -> _Solved:
        """All of it: each touch's errors weighed against what they are expected to be."""
        s = self.sums(errors.reading)
        expected = np.array([errors.touch] * 3 + [errors.turn] * 3 + [1.0]) ** 2
        within = np.diag(1.0 / expected) + s.within
        across, pull = np.linalg.solve(within, s.across), np.linalg.solve(within, s.pull[:, :, None])[:, :, 0]
        information, slope, square = self.turned
        return _Solved(
            s.information - np.einsum("tij,tik->jk", s.across, across) + information,
            s.slope - np.einsum("tij,ti->j", s.across, pull) + slope,
            s.square - float((s.pull * pull).sum()) + square,
            s.log_spread + float(np.linalg.slogdet(within)[1].sum() + len(within) * np.log(expected).sum()),
        )

    def solved(self, errors: TouchErrors) -> Fit:
        """The fit moved to where its touches put it, with the covariance that they give it."""
        s, fit = self.with_errors(errors), self.fit
        try:
            covariance = np.linalg.inv(s.information)
        except np.linalg.LinAlgError:
            return with_shared_error(fit, self.contacts)
        step = -covariance @ s.slope
        left = (s.square + float(s.slope @ step)) / max(self.count - len(step), 1)
        into_chart = np.linalg.inv(chart(fit.shape, self.problem.center))
        shape = advance(fit.shape, self.problem.center, into_chart @ step)
        covariance *= max(1.0, left)
        return replace(fit, shape=shape or fit.shape, covariance=frozen(covariance))


def _readings(contacts: Contacts) -> Ints:
    """(n,) which reading, of contacts in the order of their touches: those of a frame have one normal."""
    alike = (contacts.normals[1:] == contacts.normals[:-1]).all(axis=1)
    alike &= contacts.touch[1:] == contacts.touch[:-1]
    return np.concatenate([[0], np.cumsum(~alike)])


def _firsts(sorted_: Ints) -> Ints:
    """Where each run of equal numbers begins."""
    return np.flatnonzero(np.diff(sorted_, prepend=-1))


def _likeliest(faces: Sequence[_Equations]) -> TouchErrors:
    """The deviations of greatest restricted likelihood."""
    _by_their_own_scatter(faces)

    def cost(logs: Floats) -> float:
        deviations = np.exp(logs)
        total = 2.0 * float((deviations / _LARGE - logs).sum())
        errors = TouchErrors(*np.maximum(deviations, _LEAST))
        for face in faces:
            s = face.with_errors(errors)
            sign, log_information = np.linalg.slogdet(s.information)
            if sign <= 0.0:
                return np.inf
            gain = float(s.slope @ np.linalg.solve(s.information, s.slope))
            total += s.log_spread + float(log_information) + s.square - gain
        return total

    start = np.log(_USUAL)
    if not faces:
        return TouchErrors(*_USUAL)
    simplex = np.vstack([start, start + 0.7 * np.eye(3)])
    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        options={"xatol": 0.05, "fatol": 0.02, "maxfev": 200, "initial_simplex": simplex},
    )
    return TouchErrors(*np.maximum(np.exp(found.x), _LEAST))


def _by_their_own_scatter(faces: Sequence[_Equations]) -> None:
    """Let the readings of each touch scatter as their own differences and those of all say together."""
    told = [face.differences() for face in faces]
    free = sum(int(many.sum()) for _, many in told)
    usual = sum(float(squares.sum()) for squares, _ in told) / max(free, 1)
    if usual <= 0.0:
        return
    for face, (squares, many) in zip(faces, told, strict=True):
        own = (_OWN * usual + squares) / (_OWN + many) / usual
        face.scatter = own[face.touch[face.readings]]

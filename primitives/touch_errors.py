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

A face that nobody felt, as the wall of a hole, was made out from touches too.  Seen from one or two, as at both
ends, it is moved as a whole by what a touch errs by along every axis, and by half of a reading's variance.  What
the two err by against each other tilts a plane that was drawn between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from primitives.arrays import Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.plane import Plane
from primitives.shared_error import with_shared_error
from primitives.touch_equations import Equations, TouchErrors, sound

_USUAL = np.array([0.02, 0.02, 3e-4])  # [mm, mm, rad] from which the search starts
_LARGE = np.array([0.05, 0.05, 1e-3])  # [mm, mm, rad] modes of the priors
_LEAST = 1e-7  # [mm, rad]
_SPREAD = 1.0  # [mm] that contacts of a face spread at least
_OWN = 4.0  # readings' worth of evidence that a touch scatters as all do


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


def fits_of_touches(faces: Sequence[Felt]) -> list[Fit]:
    """Every face's fit as its touches tell it, its chi2 as large as its degrees of freedom.

    What was not felt, and contacts that are each their own touch, say nothing of that: see `with_shared_error`.
    """
    equations = _all(faces)
    errors = _restricted_likelihood(list(equations.values()))
    if errors is None:
        return [with_shared_error(face.fit, _behind(face)) for face in faces]
    return [
        equations[i].solved(errors) if i in equations else _beside(face, errors)
        for i, face in enumerate(faces)
    ]


def touch_errors(faces: Sequence[Felt]) -> TouchErrors | None:
    """What touches of these faces err by; None where none was touched by more than a contact at a time."""
    return _restricted_likelihood(list(_all(faces).values()))


def _beside(face: Felt, errors: TouchErrors) -> Fit:
    """The fit of a face that tells nothing of touches, moved as a whole where it was made out from them."""
    fit = with_shared_error(face.fit, _behind(face))
    if (face.contacts.touch != NOT_FELT).any():
        return fit
    covariance, moves = np.array(fit.covariance), np.arange(len(fit.shape.translations))
    covariance[moves, moves] += errors.touch**2 + 0.5 * errors.reading**2
    if isinstance(fit.shape, Plane):
        spread = np.maximum(np.std(face.contacts.points @ fit.shape.frame[:, :2], axis=0), _SPREAD)
        tilts = len(moves) + np.arange(2)
        covariance[tilts, tilts] += 0.5 * (errors.touch**2 + errors.reading**2) / spread**2
    return replace(fit, covariance=frozen(covariance))


def _all(faces: Sequence[Felt]) -> dict[int, Equations]:
    """The equations of each face that tells of touches."""
    made = {
        i: Equations(face.fit, sound(face.fit, felt))
        for i, face in enumerate(faces)
        if _by_touches(felt := _behind(face))
    }
    return {i: equations for i, equations in made.items() if equations.determined}


def _behind(face: Felt) -> Contacts:
    """What says where a face is: what was felt of it; of one that nobody felt, all that it was inferred from."""
    felt = face.contacts.touch != NOT_FELT
    return face.contacts.select(felt) if felt.any() else face.contacts


def _by_touches(contacts: Contacts) -> bool:
    """Whether contacts were felt, several to a touch."""
    return bool((contacts.touch != NOT_FELT).all()) and len(np.unique(contacts.touch)) < len(contacts)


def _restricted_likelihood(faces: Sequence[Equations]) -> TouchErrors | None:
    """The deviations that maximize it, with their priors; None of no faces."""
    start = np.log(_USUAL)
    if not faces:
        return None
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


def _by_their_own_scatter(faces: Sequence[Equations]) -> None:
    """Let the readings of each touch scatter as their own differences and those of all say together."""
    told = [face.differences() for face in faces]
    free = sum(int(many.sum()) for _, many in told)
    usual = sum(float(squares.sum()) for squares, _ in told) / max(free, 1)
    if usual <= 0.0:
        return
    for face, (squares, many) in zip(faces, told, strict=True):
        own = (_OWN * usual + squares) / (_OWN + many) / usual
        face.scatter = own[face.touch]

"""The covariance of a fit whose contacts share errors.

Least squares takes every contact's error for its own.  Contacts of one touch also share some: the pad lay against
the face at one attitude, an edge beside it bent all their readings alike, the stage stood a little off.  Let a
share s of each contact's variance be common to its touch, as one error of distance and one of each component of
the normals.  A common error moves the estimate by  C J' e,  with J the whitened Jacobian and e ones on the rows
that share it, so that (our derivation)::

    C' = (1 - s) C + s sum over touches and components of (C J' e)(C J' e)',

which is C again where every contact is its own touch.
Where the residuals scatter more than their sigmas say, both terms grow by chi2 per degree of freedom (Birge 1932).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.arrays import frozen
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.residuals import Problem, linearize

SHARE = 0.5  # of each contact's variance, that is its touch's


def design_effect(contacts: Contacts, share: float = SHARE) -> float:
    """How many contacts count as one that shares no error: 1 + share (m - 1), m in a touch (Kish 1965).

    m is what a contact finds in its own touch in the mean, so that a few long strokes count as what they are.
    """
    _, counts = np.unique(contacts.touch, return_counts=True)
    return 1.0 + share * (float((counts**2).sum()) / max(len(contacts), 1) - 1.0)


def with_shared_error(fit: Fit, contacts: Contacts, share: float = SHARE) -> Fit:
    """The fit with the covariance that holds when a `share` of each contact's variance is its touch's."""
    problem = Problem.of(contacts)
    _, jacobian = linearize(fit.shape, problem, 1.0 if fit.convex else -1.0)
    n, k = len(problem.points), len(problem.felt)
    touches, which = np.unique(contacts.touch, return_inverse=True)
    common = np.zeros_like(fit.covariance)
    for start, of in ((0, which), (n, which[problem.felt]), (n + k, which[problem.felt])):
        shared = np.zeros((len(touches), jacobian.shape[1]))
        np.add.at(shared, of, jacobian[start : start + len(of)])
        moved = shared @ fit.covariance
        common += moved.T @ moved
    scale = max(1.0, fit.chi2 / max(fit.dof, 1))
    return replace(fit, covariance=frozen(scale * ((1.0 - share) * fit.covariance + share * common)))

"""How far contacts scatter about a surface, as they lie round a pose that was fitted to them.

A move x of the pose turns signed distances d into d + J x, and felt normals, off by e, tell of its turn.  Which
pose is true is not known, so it is integrated out, as is whether a contact is off (Laplace's method)::

    p(d | sigma) = integral over x of p(x | normals, bounds) product of (1 - f) N(d + J x; sigma) + f / 2b

A direction that the distances tell more of than the normals and the bounds do costs one contact; one that they do
not see, as turns about a ball's center, costs none.  The pose fitted need not be that of the least squares, for x
makes up for it.  The prior of sigma is even in its logarithm, and its posterior mean is what is told: of m
contacts to spare it is sigma's median times 1.48, 1.15 and 1.05 for m = 2, 4 and 10 (our derivation; the marginal
likelihood of a variance is Harville 1974).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import expit

from models.body import Body
from models.library import Entry
from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from primitives.pose import hat
from recognition.matching.facets import facets_of, is_exact
from recognition.matching.likelihood import NoiseConfig
from recognition.matching.span import bounds
from recognition.matching.target import target_of

_MEDIAN = 1.1774  # of the length of two unit normals
_ASTRAY = 4.0  # sigmas by which a normal is off, from which on it is not the face's
_EXACT = 0.002  # [rad]: no normal is surer, for no mesh is
_TURNS = 3  # numbers of a pose that normals tell,
_FEWEST = 4  # and normals that it takes to tell their scatter, too
_ON_FACE = 0.9  # cosine to the face's normal, below which a contact lies beside an edge


@dataclass(frozen=True)
class LeftOverConfig:
    """Which sigmas are asked, and when contacts tell."""

    steps: int = 60  # sigmas, up to
    widest: float = 2.0  # times what the contacts say themselves,
    rounds: int = 4  # of the pose for each
    spare: float = 1.9  # contacts to spare, below which they tell nothing


class Scatter(NamedTuple):
    """1 sigma of contacts along the surface's normal, and of their own normals to it."""

    sigma: float  # [mm]
    tau: float | None  # [rad]; None where too few were felt


class _Near(NamedTuple):
    """Distances as they change with a move (v, w) about the contacts' middle, and what else is known of it."""

    distances: Floats  # (n,) [mm]
    slopes: Floats  # (n, 6)
    known: Floats  # (6, 6) information of normals and bounds
    pull: Floats  # (6,) the same times the move that they would have
    tau: float | None  # [rad]


def left_over(contacts: Contacts, entry: Entry, pose: Floats, least: float, noise: NoiseConfig,
              config: LeftOverConfig = LeftOverConfig()) -> Scatter | None:  # fmt: skip
    """Of contacts near a world_from_object pose, from `least` [mm] on; None where they tell nothing."""
    target = target_of(entry)
    near = _near(contacts, entry, pose, bounds(target))
    broad = noise.broad * target.size
    stray = float(np.log(noise.outliers / (2.0 * broad)))
    widest = max(broad, 10.0 * least, config.widest * float(np.median(contacts.sigma)))
    sigmas = np.geomspace(least, widest, config.steps)
    logs, spares, x = np.empty(config.steps), np.empty(config.steps), np.zeros(6)
    for k in range(config.steps - 1, -1, -1):  # from wide to narrow, as contacts part
        logs[k], spares[k], x = _log_marginal(near, sigmas[k], noise.outliers, stray, x, config.rounds)
    shares = np.exp(logs - logs.max())
    shares /= shares.sum()
    return Scatter(float(shares @ sigmas), near.tau) if shares @ spares >= config.spare else None


def _log_marginal(
    near: _Near, sigma: float, off: float, stray: float, x: Floats, rounds: int
) -> tuple[float, float, Floats]:
    """Logarithm of p(d | sigma), how many contacts are to spare, and the pose's likeliest move, from x on."""
    usual = float(np.log1p(-off) - np.log(np.sqrt(2.0 * np.pi) * sigma))
    distances, slopes = near.distances / sigma, near.slopes / sigma
    on = usual - 0.5 * (distances + slopes @ x) ** 2
    for _ in range(rounds):
        weight = expit(on - stray)
        felt = (slopes * weight[:, None]).T @ slopes
        x = np.asarray(np.linalg.solve(felt + near.known, near.pull - slopes.T @ (weight * distances)))
        on = usual - 0.5 * (distances + slopes @ x) ** 2
    information = felt + near.known
    known = near.pull @ x - 0.5 * x @ near.known @ x
    log_marginal = np.logaddexp(on, stray).sum() + known - 0.5 * np.linalg.slogdet(information)[1]
    spare = weight.sum() - np.trace(np.linalg.solve(information, felt))
    return float(log_marginal), float(spare), x


def _near(contacts: Contacts, entry: Entry, pose: Floats, bound: Floats) -> _Near:
    points, felt = (contacts.points - pose[:3, 3]) @ pose[:3, :3], contacts.has_normal
    body = entry.solid.body
    found = body.tree.nearest(points)
    normals = body.exact_normals(found.points, found.triangle)
    distances = entry.solid.signed_distance(points)
    away = points - found.points
    along = np.einsum("ij,ij->i", away, normals)
    on_face = np.abs(along) >= _ON_FACE * np.abs(distances)
    unit = np.where(on_face[:, None], normals, away / np.where(on_face, 1.0, distances)[:, None])
    slopes = np.hstack([unit, np.cross(found.points - points.mean(axis=0), unit)])
    known, pull, tau = bound.copy(), np.zeros(6), None
    if felt.sum() >= _FEWEST:
        read = [normals] if is_exact(body) else [normals, _bent(body, found.points, found.triangle)]
        turned = contacts.normals[felt] @ pose[:3, :3]
        tau, information, pull[3:] = min(
            (_of_normals(turned, n[felt]) for n in read), key=lambda told: told[0]
        )
        known[3:, 3:] += information
    return _Near(distances, slopes, known, pull, tau)


def _bent(body: Body, points: Floats, triangles: Ints) -> Floats:
    """(n, 3) normals of the surface that a mesh stands for, at points on its triangles."""
    mesh = facets_of(body)
    corners = mesh.corners[triangles]
    sides = corners[:, 1:] - corners[:, :1]
    to = np.einsum("nij,nj->ni", np.linalg.pinv(np.swapaxes(sides, 1, 2)), points - corners[:, 0])
    shares = np.column_stack([1.0 - to.sum(axis=1), to])
    normals = np.einsum("ni,nij->nj", shares, mesh.normals[triangles])
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _of_normals(felt: Floats, normals: Floats) -> tuple[float, Floats, Floats]:
    """How (n, 3) felt normals scatter [rad], and the information of a turn in them, and it times the turn."""
    off = felt - normals
    size = np.linalg.norm(off, axis=1)
    spent = np.sqrt(2.0 * len(off) / (2.0 * len(off) - _TURNS))
    tau = max(float(np.median(size)) / _MEDIAN * spent, _EXACT)
    kept: Bools = size < _ASTRAY * tau
    turns = -hat(felt[kept])
    information = np.einsum("nij,nik->jk", turns, turns) / tau**2
    return tau, information, -np.einsum("nij,ni->j", turns, off[kept]) / tau**2

"""Weighted least-squares fits of the five shapes to contacts, with covariance.

The sum of squares of `residuals` is minimized by damped Gauss-Newton (Levenberg-Marquardt with Marquardt's
scaling) from the algebraic `starts`; a further start is tried only while the best one explains the contacts
badly.  With the sensor's sigmas this is maximum likelihood, and its covariance the inverse of J'J at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.residuals import Problem, advance, chart, linearize
from primitives.shapes import KINDS, Cylinder, Plane, Shape
from primitives.starts import STARTS


@dataclass(frozen=True)
class FitOptions:
    """Tolerances of a fit."""

    robust: bool = False  # Huber weights, then least squares on the inliers
    huber: float = 2.5  # contacts farther than this many sigmas weigh less
    outlier_chi2: tuple[float, float] = (10.83, 16.27)  # 99.9 % for a point alone, and with its normal
    iterations: int = 40
    gain: float = 1e-7  # converged when a step promises to lower chi2 by less, absolutely and relatively
    plausible: float = 1.6  # chi2 per degree of freedom at which no further start is tried
    starts: int = 4  # most starts that are followed to the end
    tilt: float = 0.5  # [rad] an axis less certain than this was not determined


@dataclass(frozen=True)
class Fit:
    """A shape that explains contacts."""

    shape: Shape
    covariance: Floats  # (dof, dof) of a step of `shape.retract`
    rms: float  # [mm] of the distances of the contacts that were used
    chi2: float  # sum of their squared whitened residuals
    dof: int  # number of those residuals less that of parameters
    inliers: Bools  # (n,) within the shape's 99.9 % bound
    converged: bool
    convex: bool  # whether the material is inside the shape's canonical solid; True where no normal says

    def __bool__(self) -> bool:
        return True

    @property
    def kind(self) -> str:
        """The shape's name."""
        return self.shape.kind

    @property
    def sigma(self) -> Floats:
        """(dof,) standard deviations of a step of `shape.retract`."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True)
class NoFit:
    """Why there is none; false in a condition."""

    reason: str

    def __bool__(self) -> bool:
        return False


def fit(kind: str, contacts: Contacts, options: FitOptions | None = None) -> Fit | NoFit:
    """The shape of a kind ("plane", "cylinder", "cone", "sphere", "torus") that explains contacts best."""
    if kind not in KINDS:
        raise PalpateError(f"no shape '{kind}'; choose one of {', '.join(KINDS)}")
    if not np.isfinite(contacts.points).all() or not (contacts.sigma > 0).all():
        raise PalpateError(
            "contacts to fit need finite points and positive sigmas; drop the rows that lack them"
        )
    options = options or FitOptions()
    problem = Problem.of(contacts)
    if problem.count < KINDS[kind].dof or len(problem.points) < 2:
        return NoFit(f"{len(contacts)} contacts are too few for a {kind}")
    best: _State | None = None
    for shape, sign in _ranked_starts(kind, problem, options):
        state = _minimize(shape, sign, problem, options)
        if best is None or state.cost < best.cost:
            best = state
        if best.cost <= options.plausible * max(problem.count - shape.dof, 1):
            break
    if best is None:
        return NoFit(f"contacts give no {kind} to start from: they are too few or in line")
    if not options.robust:
        return _finish(best, problem, contacts, options)
    kept = _within(best, problem, options)
    trimmed = Problem.of(contacts, kept)
    if trimmed.count < KINDS[kind].dof or len(trimmed.points) < 2:
        return NoFit(f"fewer than the contacts that a {kind} needs agree on one")
    plain = FitOptions(**{**options.__dict__, "robust": False})
    return _finish(_minimize(best.shape, best.sign, trimmed, plain), trimmed, contacts, plain)


FITTERS: dict[str, Callable[[Contacts], Fit | NoFit]] = {kind: partial(fit, kind) for kind in KINDS}


def refit(shape: Shape, convex: bool, contacts: Contacts, options: FitOptions | None = None) -> Fit | NoFit:
    """The fit that is reached from a shape already known to be near."""
    options = options or FitOptions()
    problem = Problem.of(contacts)
    if problem.count < shape.dof or len(problem.points) < 2:
        return NoFit(f"{len(contacts)} contacts are too few for a {shape.kind}")
    state = _minimize(shape, 1.0 if convex else -1.0, problem, options)
    return _finish(state, problem, contacts, options)


def squares(found: Fit, contacts: Contacts) -> Floats:
    """(n,) sum of the squared whitened residuals of each of any contacts."""
    problem = Problem.of(contacts)
    return problem.squares(linearize(found.shape, problem, 1.0 if found.convex else -1.0)[0])


@dataclass(frozen=True)
class _State:
    shape: Shape
    sign: float
    cost: float
    residuals: Floats
    information: Floats  # in the chart's coordinates
    converged: bool


def _ranked_starts(kind: str, problem: Problem, options: FitOptions) -> list[tuple[Shape, float]]:
    starts = list(STARTS[kind](problem))
    if len(starts) > 1:
        costs = [float(np.square(linearize(shape, problem, sign)[0]).sum()) for shape, sign in starts]
        starts = [starts[i] for i in np.argsort(costs)]
    return starts[: options.starts]


def _minimize(shape: Shape, sign: float, problem: Problem, options: FitOptions) -> _State:
    damping, converged = 1e-4, False
    shape = _anchored(shape, problem.center)
    cost, residuals, information, slope = _assemble(shape, sign, problem, options)
    for _ in range(options.iterations):
        scale = np.diag(information) + 1e-30
        try:
            step: Floats = np.negative(np.linalg.solve(information + damping * np.diag(scale), slope))
        except np.linalg.LinAlgError:
            break
        promised = -float(slope @ step)
        converged = promised <= options.gain * (1.0 + cost)
        moved = advance(shape, problem.center, step)
        trial = _assemble(moved, sign, problem, options) if moved is not None else None
        if trial is not None and moved is not None and trial[0] < cost:
            shape, (cost, residuals, information, slope) = moved, trial
            damping = max(damping * 0.1, 1e-12)
        else:
            damping *= 10.0
        if converged or damping > 1e10:
            break
    return _State(shape, sign, cost, residuals, information, converged)


def _assemble(
    shape: Shape, sign: float, problem: Problem, options: FitOptions
) -> tuple[float, Floats, Floats, Floats]:
    """Cost, residuals, J'J and J'r."""
    residuals, jacobian = linearize(shape, problem, sign)
    if shape.kind == "cone":
        jacobian = jacobian @ chart(shape, problem.center)
    if not options.robust:
        return float(residuals @ residuals), residuals, jacobian.T @ jacobian, jacobian.T @ residuals
    size = np.sqrt(problem.squares(residuals))
    k = options.huber
    cost = float(np.where(size < k, size**2, 2 * k * size - k * k).sum())
    weight = problem.spread(k / np.maximum(size, k))
    weighted = jacobian * weight[:, None]
    return cost, residuals, weighted.T @ jacobian, weighted.T @ residuals


def _anchored(shape: Shape, center: Floats) -> Shape:
    """The same plane or cylinder with its origin beside the contacts, where tilts are least correlated."""
    if isinstance(shape, Plane):
        return Plane(center - shape.normal * ((center - shape.origin) @ shape.normal), shape.normal)
    if isinstance(shape, Cylinder):
        height = float((center - shape.origin) @ shape.axis)
        return Cylinder(shape.origin + height * shape.axis, shape.axis, shape.radius)
    return shape


def _within(state: _State, problem: Problem, options: FitOptions) -> Bools:
    bound = np.full(len(problem.points), options.outlier_chi2[0])
    bound[problem.felt] = options.outlier_chi2[1]
    return np.asarray(problem.squares(state.residuals) < bound)


def _finish(state: _State, problem: Problem, contacts: Contacts, options: FitOptions) -> Fit | NoFit:
    shape = state.shape
    scale = 1.0 / np.sqrt(np.maximum(np.diag(state.information), 1e-300))
    values, vectors = np.linalg.eigh(state.information * np.outer(scale, scale))
    if not np.isfinite(values).all() or values[0] < 1e-12 * values[-1]:
        return NoFit(f"degenerate: the contacts do not determine a {shape.kind}")
    inverse = (vectors / values) @ vectors.T * np.outer(scale, scale)
    matrix = chart(shape, problem.center)
    covariance = matrix @ inverse @ matrix.T
    first = len(shape.translations)
    if shape.tilts:
        tilt = float(np.linalg.eigvalsh(covariance[first : first + 2, first : first + 2])[-1])
        if tilt > options.tilt**2:
            return NoFit(f"degenerate: the contacts do not determine the axis of a {shape.kind}")
    n = len(problem.points)
    distance = state.residuals[:n] / problem.weight
    if n == len(contacts):
        inliers = _within(state, problem, options)
    else:
        everything = Problem.of(contacts)
        residuals = linearize(shape, everything, state.sign)[0]
        inliers = _within(_State(shape, state.sign, 0.0, residuals, covariance, True), everything, options)
    chi2 = float(state.residuals @ state.residuals)
    rms = float(np.sqrt((distance**2).mean()))
    left = problem.count - shape.dof
    return Fit(
        shape, frozen(covariance), rms, chi2, left, frozen(inliers, bool), state.converged, state.sign > 0
    )

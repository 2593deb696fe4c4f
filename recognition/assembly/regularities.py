"""Relations that a designer meant, accepted only where the measured uncertainty allows them.

The fitted shapes s_i are retracted by one stacked step x, of prior x ~ N(0, P).  A relation is a constraint
h(x) = 0, for example n_a . n_b = 0.  Given the relations accepted before it, it costs (our derivation; a Kalman
update with a perfect measurement, as in Simon 2010, "Kalman filtering with state constraints")

    chi2 = h' (H P H')^-1 h,    H = dh/dx,

and is refused where chi2 exceeds its quantile.  At the end x is polished by Gauss-Newton onto all accepted
constraints, and its covariance is P conditioned on them, so that sizes which span two faces gain from both.
A misalignment that was really measured is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import block_diag, pinvh
from scipy.special import chdtri

from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.fit import Fit
from primitives.pose import cross, frame_along
from primitives.residuals import advance, chart
from primitives.shapes import Cone, Plane, Shape, Sphere

_TWICE = 2e-6  # [rad, mm] between the two ends of a central difference


@dataclass(frozen=True)
class RegularityOptions:
    """What may be regularized."""

    significance: float = 1e-3  # a true relation is refused this often
    reach: float = 0.1  # [rad] and share of size: never bend by more, however uncertain the fit
    floor: float = 1e-4  # [rad] and, tenfold, [mm]: errors that no covariance knows of
    implied: float = 3e-5  # [rad, mm] a relation as sure as this follows from those before it
    iterations: int = 8
    settled: float = 1e-9  # [rad, mm] of a step, that is no more than differences err by


@dataclass(frozen=True)
class Relation:
    """One accepted relation between two faces."""

    kind: str  # "coincident", "parallel", "perpendicular" or "coaxial"
    a: int
    b: int
    chi2: float  # what it cost, on top of those accepted before


@dataclass(frozen=True)
class Regularized:
    """Shapes adjusted jointly; the fits keep the values as measured."""

    shapes: tuple[Shape, ...]
    covariance: Floats  # (d, d) of the stacked steps of the fits' own `retract`, to first order
    slices: tuple[slice, ...]  # of each shape in the stacked step
    relations: tuple[Relation, ...]
    step: Floats  # (d,) by which the fits were adjusted

    def covariance_of(self, i: int) -> Floats:
        """(dof, dof) of shape i."""
        return np.asarray(self.covariance[self.slices[i], self.slices[i]])


Constraint = Callable[[Shape, Shape], Floats]


def regularize(fits: Sequence[Fit], options: RegularityOptions | None = None) -> Regularized:
    """Accept what the covariances allow, likeliest first, and adjust all shapes to it."""
    state = _State(fits, options or RegularityOptions())
    for stage in (_coincident, _parallel, _perpendicular, _coaxial):
        for kind, a, b, constraint in _by_cost(state, stage(state)):
            state.consider(kind, a, b, constraint)
    state.polish()
    return Regularized(
        tuple(state.shapes()), frozen(state.posterior), state.slices, tuple(state.relations), frozen(state.x)
    )


Proposal = tuple[str, int, int, Constraint]


class _State:
    """The stacked step, its covariance given what is accepted, and the accepted constraints."""

    def __init__(self, fits: Sequence[Fit], options: RegularityOptions) -> None:
        self.stepped, self.options = [_stepper(fit) for fit in fits], options
        ends = np.cumsum([0, *(f.shape.dof for f in fits)])
        self.slices = tuple(slice(int(i), int(j)) for i, j in pairwise(ends))
        floors = [_floor(f.shape, options.floor) for f in fits]
        blocks = [f.covariance + np.diag(s**2) for f, s in zip(fits, floors, strict=True)]
        self.prior: Floats = np.asarray(block_diag(*blocks)) if blocks else np.empty((0, 0))
        self.posterior = self.prior
        self.x = np.zeros(int(ends[-1]))
        self.accepted: list[tuple[int, int, Constraint]] = []
        self.relations: list[Relation] = []
        self._around: dict[int, tuple[Floats, Shape, list[tuple[Shape, Shape]]]] = {}

    def shapes(self) -> list[Shape]:
        return [after(self.x[part]) for after, part in zip(self.stepped, self.slices, strict=True)]

    def _are_shapes(self, x: Floats) -> bool:
        """Whether every shape still is one after a stacked step `x`: no radius is negative, say."""
        try:
            for after, part in zip(self.stepped, self.slices, strict=True):
                after(x[part])
        except PalpateError:
            return False
        return True

    def value_and_slope(self, a: int, b: int, constraint: Constraint) -> tuple[Floats, Floats]:
        """The values h and their (k, d) derivative by central differences."""
        (one, ones), (other, others) = self._nudged(a), self._nudged(b)
        value = constraint(one, other)
        slope = np.zeros((len(value), len(self.x)))
        for j, (plus, minus) in enumerate(ones):
            slope[:, self.slices[a].start + j] = (constraint(plus, other) - constraint(minus, other)) / _TWICE
        for j, (plus, minus) in enumerate(others):
            slope[:, self.slices[b].start + j] = (constraint(one, plus) - constraint(one, minus)) / _TWICE
        return value, slope

    def _nudged(self, i: int) -> tuple[Shape, list[tuple[Shape, Shape]]]:
        """Shape i, and both sides of it along each of its coordinates, which every pair that it is in asks for."""
        part = self.x[self.slices[i]]
        kept = self._around.get(i)
        if kept is None or not np.array_equal(kept[0], part):
            step = self.stepped[i]
            nudges = 0.5 * _TWICE * np.eye(len(part))
            kept = part, step(part), [(step(part + nudge), step(part - nudge)) for nudge in nudges]
            self._around[i] = kept
        return kept[1:]

    def cost(self, value: Floats, slope: Floats) -> float:
        spread = slope @ self.posterior @ slope.T + self.options.implied**2 * np.eye(len(value))
        return float(value @ np.linalg.solve(spread, value))

    def consider(self, kind: str, a: int, b: int, constraint: Constraint) -> None:
        value, slope = self.value_and_slope(a, b, constraint)
        met = float(np.abs(value).max()) <= self.options.implied
        cost = 0.0 if met else self.cost(value, slope)
        if cost > chdtri(len(value), self.options.significance):
            return
        relation, spread = Relation(kind, a, b, cost), slope @ self.posterior @ slope.T
        if met and float(np.diag(spread).max()) <= self.options.implied**2:
            self.relations.append(relation)
            return  # those before it leave it no room, and it adds nothing
        gain = self.posterior @ slope.T @ _pseudo_inverse(spread)
        moved: Floats = self.x - gain @ value
        if not self._are_shapes(moved):
            return  # what is hardly known would be carried past where its slopes tell anything
        self.relations.append(relation)
        self.accepted.append((a, b, constraint))
        self.x = moved
        self.posterior = self.posterior - gain @ slope @ self.posterior

    def polish(self) -> None:
        """Gauss-Newton, x = P H' (H P H')^+ (H x - h), until x is the least step that meets all.

        Where that would leave a shape none, what was met one after the other stands.
        """
        for _ in range(self.options.iterations if self.accepted else 0):
            pairs = [self.value_and_slope(*c) for c in self.accepted]
            value, slope = np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
            gain = self.prior @ slope.T @ _pseudo_inverse(slope @ self.prior @ slope.T)
            moved: Floats = gain @ (slope @ self.x - value)
            if not self._are_shapes(moved):
                break
            done = float(np.abs(moved - self.x).max()) < self.options.settled
            self.x = moved
            self.posterior = self.prior - gain @ slope @ self.prior
            if done:
                break


def _stepper(fit: Fit) -> Callable[[Floats], Shape]:
    """What a step in `retract`'s coordinates makes of a fit.

    A cone that is nearly a cylinder has its apex far from its contacts, and a step of apex, axis and angle that is
    right to first order would carry the surface off them: it is made about the height where the radius is best
    known, where r = h tan(angle) varies least, h = tan cov(z, angle) / (sec^2 var(angle)).
    """
    shape = fit.shape
    variance = float(fit.covariance[-1, -1])
    if not isinstance(shape, Cone) or variance <= 0.0:
        return shape.retract
    tangent = np.tan(shape.semi_angle)
    height = tangent * float(fit.covariance[2, -1]) / ((1.0 + tangent**2) * variance)
    if height <= 0.0:
        return shape.retract
    known = shape.apex + height * shape.axis
    into_chart = np.linalg.inv(chart(shape, known))

    def after(step: Floats) -> Shape:
        moved = advance(shape, known, into_chart @ step)
        return shape.retract(step) if moved is None else moved

    return after


def _pseudo_inverse(matrix: Floats) -> Floats:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return np.asarray(pinvh(matrix * np.outer(scale, scale), rtol=1e-9) * np.outer(scale, scale))


def _floor(shape: Shape, angle: float) -> Floats:
    lengths = np.full(shape.dof, 10.0 * angle)
    first = len(shape.translations)
    lengths[first : first + shape.tilts] = angle
    if shape.kind == "cone":
        lengths[-1] = angle
    return lengths


def _by_cost(state: _State, proposals: list[Proposal]) -> list[Proposal]:
    costs = [state.cost(*state.value_and_slope(a, b, c)) for _, a, b, c in proposals]
    return [proposals[i] for i in np.argsort(costs, kind="stable")]


def _pairs(state: _State) -> list[tuple[int, int, Shape, Shape]]:
    shapes = state.shapes()
    return [(i, j, shapes[i], shapes[j]) for i in range(len(shapes)) for j in range(i + 1, len(shapes))]


def _coincident(state: _State) -> list[Proposal]:
    reach = state.options.reach
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if a.kind != b.kind:
            continue
        if isinstance(a, Plane) and float(a.direction @ b.direction) < 1.0 - reach:
            continue
        if abs(float(a.direction @ b.direction)) < 1.0 - reach:
            continue
        if any(abs(p - q) > reach * p for p, q in zip(a.sizes, b.sizes, strict=True)):
            continue
        out.append(("coincident", i, j, lambda p, q: p.local(q)))  # type: ignore[arg-type]
    return out


def _parallel(state: _State) -> list[Proposal]:
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if a.tilts and b.tilts and np.linalg.norm(np.cross(a.direction, b.direction)) < state.options.reach:
            out.append(("parallel", i, j, _aligned(frame_along(a.direction)[:, :2])))
    return out


def _perpendicular(state: _State) -> list[Proposal]:
    def upright(a: Shape, b: Shape) -> Floats:
        return np.array([a.direction @ b.direction])

    reach = state.options.reach
    return [
        ("perpendicular", i, j, upright)
        for i, j, a, b in _pairs(state)
        if a.tilts and b.tilts and abs(float(a.direction @ b.direction)) < reach
    ]


def _coaxial(state: _State) -> list[Proposal]:
    parallel = {(r.a, r.b) for r in state.relations if r.kind == "parallel"}
    out: list[Proposal] = []
    for i, j, a, b in _pairs(state):
        if isinstance(a, Plane) or isinstance(b, Plane) or (isinstance(a, Sphere) and isinstance(b, Sphere)):
            continue
        if not (isinstance(a, Sphere) or isinstance(b, Sphere) or (i, j) in parallel):
            continue
        axis = b if isinstance(a, Sphere) else a
        across = frame_along(axis.direction)[:, :2]
        out.append(("coaxial", i, j, _on_axis(across, axis_first=axis is a)))
    return out


def _aligned(across: Floats) -> Constraint:
    def constraint(a: Shape, b: Shape) -> Floats:
        out: Floats = cross(a.direction, b.direction) @ across
        return out

    return constraint


def _on_axis(across: Floats, axis_first: bool) -> Constraint:
    def constraint(a: Shape, b: Shape) -> Floats:
        axis, other = (a, b) if axis_first else (b, a)
        offset = other.anchor - axis.anchor
        offset = offset - (offset @ axis.direction) * axis.direction
        out: Floats = offset @ across
        return out

    return constraint

"""The stacked step of all faces, its covariance given what is accepted, and the accepted constraints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations, pairwise

import networkx
import numpy as np
from scipy.linalg import block_diag, pinvh
from scipy.special import chdtri

from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.fit import Fit
from primitives.residuals import advance, chart
from primitives.shapes import Cone, Shape
from recognition.assembly.regularities.relation import Constraint, Proposal, RegularityOptions, Relation

_TWICE = 2e-6  # [rad, mm] between the two ends of a central difference


class State:
    """Where all faces are, and how well that is known."""

    def __init__(self, fits: Sequence[Fit], options: RegularityOptions) -> None:
        self.stepped, self.options = [_stepper(fit) for fit in fits], options
        self.convex = [fit.convex for fit in fits]
        self._measured = [fit.shape for fit in fits]
        ends = np.cumsum([0, *(f.shape.dof for f in fits)])
        self.slices = tuple(slice(int(i), int(j)) for i, j in pairwise(ends))
        floors = [_floor(f.shape, options.floor) for f in fits]
        blocks = [f.covariance + np.diag(s**2) for f, s in zip(fits, floors, strict=True)]
        self.prior: Floats = np.asarray(block_diag(*blocks)) if blocks else np.empty((0, 0))
        self.posterior = self.prior
        self.x = np.zeros(int(ends[-1]))
        self.accepted: list[Proposal] = []
        self.relations: list[Relation] = []
        self._held: set[tuple[str, frozenset[int]]] = set()
        self._around: dict[int, tuple[Floats, Shape, list[tuple[Shape, Shape]]]] = {}

    def shape(self, i: int) -> Shape:
        """One of them, as adjusted so far."""
        return self._nudged(i)[0]

    def shapes(self) -> list[Shape]:
        """As adjusted so far."""
        return [after(self.x[part]) for after, part in zip(self.stepped, self.slices, strict=True)]

    def _are_shapes(self, x: Floats) -> bool:
        """Whether every shape still is one after a stacked step `x`: no radius is negative, say."""
        try:
            for after, part in zip(self.stepped, self.slices, strict=True):
                after(x[part])
        except PalpateError:
            return False
        return True

    def has(self, kind: str, faces: tuple[int, ...]) -> bool:
        """Whether a relation was accepted."""
        return (kind, frozenset(faces)) in self._held

    def groups(self, kind: str) -> list[list[int]]:
        """Faces that a relation joins, in order."""
        joined = networkx.Graph()
        for relation in self.relations:
            if relation.kind == kind:
                joined.add_edges_from(combinations(relation.faces, 2))
        return sorted(sorted(group) for group in networkx.connected_components(joined))

    def value_and_slope(self, faces: tuple[int, ...], constraint: Constraint) -> tuple[Floats, Floats]:
        """The values h and their (k, d) derivative by central differences."""
        nudged = [self._nudged(i) for i in faces]
        now = [shape for shape, _ in nudged]
        value = constraint(*now)
        slope = np.zeros((len(value), len(self.x)))
        for place, (i, (_, moved)) in enumerate(zip(faces, nudged, strict=True)):
            before, after = now[:place], now[place + 1 :]
            for j, (plus, minus) in enumerate(moved):
                rise = constraint(*before, plus, *after) - constraint(*before, minus, *after)
                slope[:, self.slices[i].start + j] = rise / _TWICE
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
        """chi2 of a constraint."""
        spread = slope @ self.posterior @ slope.T + self.options.implied**2 * np.eye(len(value))
        return float(value @ np.linalg.solve(spread, value))

    def consider(self, proposal: Proposal) -> None:
        """Accept a relation where the faces allow it, and move them to it."""
        value, slope = self.value_and_slope(proposal.faces, proposal.constraint)
        met = float(np.abs(value).max()) <= self.options.implied
        cost = 0.0 if met else self.cost(value, slope)
        spread = slope @ self.posterior @ slope.T
        if not cost <= self._dearest(proposal, spread):
            return
        relation = self._relation(proposal, cost, slope)
        if float(np.diag(spread).max()) <= self.options.implied**2:
            self._hold(replace(relation, implied=True))
            return  # those before it leave it no room, and it adds nothing
        gain = self.posterior @ slope.T @ _pseudo_inverse(spread)
        moved: Floats = self.x - gain @ value
        if not self._are_shapes(moved):
            return  # what is hardly known would be carried past where its slopes tell anything
        self._hold(relation)
        self.accepted.append(proposal)
        self.x = moved
        self.posterior = self.posterior - gain @ (slope @ self.posterior)
        if float(np.abs(self.value(proposal)).max()) > self.options.implied:
            self.polish()  # slopes taken far away mislead whatever is considered next

    def value(self, proposal: Proposal) -> Floats:
        """How far the faces are from a relation, as adjusted so far."""
        return proposal.constraint(*(self.shape(i) for i in proposal.faces))

    def unsure(self, proposal: Proposal) -> float:
        """How far off a relation the faces may be, squared."""
        _, slope = self.value_and_slope(proposal.faces, proposal.constraint)
        return float(np.trace(slope @ self.posterior @ slope.T))

    def _dearest(self, proposal: Proposal, spread: Floats) -> float:
        """chi2 up to which a relation is likelier meant than that values at random over `among` come as near."""
        if proposal.among is None:
            return float(chdtri(len(spread), self.options.significance))
        spread = spread + self.options.implied**2 * np.eye(len(spread))
        odds = len(spread) * np.log(proposal.among) + np.log(self.options.odds.get(proposal.kind, 1.0))
        return float(2.0 * odds - np.log(np.linalg.det(2.0 * np.pi * spread)))

    def _relation(self, proposal: Proposal, cost: float, slope: Floats) -> Relation:
        """With what the faces were measured to be."""
        value = proposal.constraint(*(self._measured[i] for i in proposal.faces))[: proposal.told]
        spread = (slope @ self.prior @ slope.T)[: proposal.told, : proposal.told]
        sigma = np.sqrt(max(float(np.linalg.eigvalsh(spread)[-1]), 0.0))
        return Relation(proposal.kind, proposal.faces, cost, float(np.linalg.norm(value)), float(sigma))

    def _hold(self, relation: Relation) -> None:
        self.relations.append(relation)
        self._held.add((relation.kind, frozenset(relation.faces)))

    def put(self, proposal: Proposal, relation: Relation) -> None:
        """A constraint that `polish` shall meet, whatever it costs."""
        self._hold(relation)
        self.accepted.append(proposal)

    def polish(self, sure: bool = True) -> None:
        """Gauss-Newton, x = P H' (H P H')^+ (H x - h), until x is the least step that meets all.

        Where that would leave a shape none, what was met one after the other stands.  The covariance becomes that
        of faces which meet all of them for `sure`, or stays.
        """
        for _ in range(self.options.iterations if self.accepted else 0):
            pairs = [self.value_and_slope(p.faces, p.constraint) for p in self.accepted]
            value, slope = np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])
            gain = self.prior @ slope.T @ _pseudo_inverse(slope @ self.prior @ slope.T)
            moved: Floats = gain @ (slope @ self.x - value)
            if not self._are_shapes(moved):
                break
            done = float(np.abs(moved - self.x).max()) < self.options.settled
            self.x = moved
            if sure:
                self.posterior = self.prior - gain @ (slope @ self.prior)
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

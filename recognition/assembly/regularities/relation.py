"""What relates faces, what of it was accepted, and the shapes that it leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Floats
from primitives.shapes import Shape

Constraint = Callable[..., Floats]  # of the shapes that it relates: (k,) zeros where it holds


@dataclass(frozen=True)
class RegularityOptions:
    """What may be regularized."""

    significance: float = 1e-3  # faces that are one, or on one axis, are refused this often
    odds: Mapping[str, float] = field(  # of the others so many that are near it are meant, to one that is not
        default_factory=lambda: {
            "parallel": 20.0,
            "perpendicular": 20.0,
            "equal radius": 20.0,
            "tangent": 10.0,
            "evenly spaced": 20.0,
        }
    )
    reach: float = 0.1  # [rad] and share of size: never bend by more, however uncertain the fit
    floor: float = 1e-4  # [rad] and, tenfold, [mm]: errors that no covariance knows of
    implied: float = (
        3e-5  # [rad, mm] off it and unsure, up to which a relation is met, and follows from others
    )
    iterations: int = 8
    settled: float = 1e-9  # [rad, mm] of a step, that is no more than differences err by
    round: bool = True  # whether to look for a grid that the sizes lie on


@dataclass(frozen=True)
class Proposal:
    """A relation that may hold."""

    kind: str
    faces: tuple[int, ...]  # fits, each once
    constraint: Constraint
    told: int = 1  # the first so many values say how far the faces are from it
    among: float | None = (
        None  # [mm, rad] over which values lie at random where it does not hold; None: unknown
    )


@dataclass(frozen=True)
class Relation:
    """One accepted relation between faces, with what was measured and what stands in the model."""

    kind: str  # what `proposals` calls it, or "round"
    faces: tuple[int, ...]  # fits
    chi2: float  # what it cost, on top of those accepted before
    measured: float  # how far the faces were from it, or a round size [mm]; of directions [rad]
    sigma: float  # of that
    taken: float = 0.0  # instead
    implied: bool = False  # whether it follows from those accepted before it


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

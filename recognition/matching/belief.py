"""What is believed after matching: hypotheses of (object, pose), and how probable each one is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats

UNKNOWN = "unknown"


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One object at one pose, with the poses beside it that its covariance spans."""

    name: str
    pose: Floats  # (4, 4) world_from_object
    log_weight: float  # logarithm of its probability
    covariance: Floats  # (6, 6) of (v [mm], w [rad]) in the object's frame, about its center
    residual: float  # [mm] mean distance of the contacts from the surface
    log_likelihoods: Floats  # (n,) of each contact; nan of those that were not weighed

    @property
    def probability(self) -> float:
        """Of this object at this pose."""
        return float(np.exp(self.log_weight))

    @property
    def translation_sigma(self) -> float:
        """[mm] root mean square error of the center's place that is to be expected."""
        return float(np.sqrt(max(np.trace(self.covariance[:3, :3]), 0.0)))

    @property
    def rotation_sigma(self) -> float:
        """[rad]."""
        return float(min(np.sqrt(max(np.trace(self.covariance[3:, 3:]), 0.0)), np.pi))


@dataclass(frozen=True, eq=False)
class Belief:
    """Hypotheses, likeliest first, and probabilities by name with "unknown" among them; they sum to one."""

    hypotheses: tuple[Hypothesis, ...]
    probabilities: Mapping[str, float]
    log_evidence: float = 0.0  # logarithm of how probable the contacts were, whatever was touched
    inward: float = 0.0  # probability that the normals given point into the object, and were turned round

    @property
    def decision(self) -> str:
        """The most probable name."""
        return max(self.probabilities, key=lambda name: self.probabilities[name])

    @property
    def confidence(self) -> float:
        """Its probability."""
        return float(self.probabilities[self.decision])

    @property
    def entropy_bits(self) -> float:
        """Of the names."""
        p = np.array([x for x in self.probabilities.values() if x > 0])
        return float(-(p * np.log2(p)).sum()) + 0.0

    def best(self, name: str) -> Hypothesis | None:
        """The likeliest pose of one object."""
        return next((h for h in self.hypotheses if h.name == name), None)

    def separating(self, first: str, second: str, count: int = 5) -> tuple[int, ...]:
        """The contacts that speak most for one object against another."""
        a, b = self.best(first), self.best(second)
        if a is None or b is None:
            return ()
        gain = np.nan_to_num(a.log_likelihoods - b.log_likelihoods)
        order = np.argsort(-gain)[:count]
        return tuple(int(i) for i in order if gain[i] > 0.5)

"""Lists of primitives, added, subtracted and intersected in order, and what one costs.

A list is judged by the cells that it holds: what it gets wrong is counted in nats, as evidence against it, and
each primitive costs what its parameters cost to say (minimum description length; our derivation).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from primitives.arrays import Bools, Floats
from recognition.assembly.vocabulary import Candidate, Vocabulary


@dataclass(frozen=True)
class SearchOptions:
    """How hard to look."""

    beam: int = 6  # lists kept
    tried: int = 6  # candidates tried from each, of each operation
    leaf: float = 20.0  # [nats] of a primitive
    most: int = 80  # leaves at most
    seeds: int = 2  # wrong cells from which prisms are grown, of each operation


@dataclass(frozen=True)
class Step:
    """One entry of a list."""

    operation: str  # "add", "subtract" or "intersect"
    candidate: Candidate


@dataclass(frozen=True)
class Listed:
    """A list and what it holds."""

    steps: tuple[Step, ...]
    held: Bools  # (c,)
    wrong: float  # [nats]
    price: float  # [nats] of the leaves

    @property
    def cost(self) -> float:
        """What is left wrong, and what was said."""
        return self.wrong + self.price


@dataclass(frozen=True)
class Target:
    """The (c,) cells that a list shall hold, and the (c,) nats that a mistake in each costs."""

    vocabulary: Vocabulary
    solid: Bools
    weight: Floats
    options: SearchOptions = field(default_factory=SearchOptions)

    @property
    def empty(self) -> Listed:
        """The list of nothing."""
        return self.listed(())

    def listed(self, steps: Sequence[Step]) -> Listed:
        """A list with what it holds, and its cost."""
        held = held_after(steps, self.vocabulary, np.zeros(len(self.solid), dtype=bool))
        price = self.options.leaf * sum(step.candidate.price for step in steps)
        return Listed(tuple(steps), held, self._wrong(held), price)

    def extended(self, state: Listed, step: Step) -> Listed:
        """The same with one step more."""
        held = held_after((step,), self.vocabulary, state.held)
        price = state.price + self.options.leaf * step.candidate.price
        return Listed((*state.steps, step), held, self._wrong(held), price)

    def missing(self, state: Listed) -> Bools:
        """(c,) solid cells that a list does not hold."""
        return self.solid & ~state.held

    def extra(self, state: Listed) -> Bools:
        """(c,) cells that it holds and that are not solid."""
        return ~self.solid & state.held

    def free(self, state: Listed) -> Bools:
        """(c,) cells that it leaves out and that are not solid: nothing may be added there."""
        return ~self.solid & ~state.held

    def kept(self, state: Listed) -> Bools:
        """(c,) solid cells that it holds: nothing may be taken away there."""
        return self.solid & state.held

    def _wrong(self, held: Bools) -> float:
        return float(self.weight[held != self.solid].sum())


def held_after(steps: Sequence[Step], vocabulary: Vocabulary, held: Bools) -> Bools:
    """(c,) cells held once some steps were taken from (c,) `held`."""
    for step in steps:
        held = _OPERATIONS[step.operation](held, vocabulary.mask(step.candidate))
    return held


_OPERATIONS: dict[str, Callable[[Bools, Bools], Bools]] = {
    "add": lambda held, mask: held | mask,
    "subtract": lambda held, mask: held & ~mask,
    "intersect": lambda held, mask: held & mask,
}

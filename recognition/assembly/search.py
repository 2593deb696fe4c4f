"""The shortest list of primitives, added, subtracted and intersected in order, that holds just the solid cells.

A beam search: a state is the cells that are solid so far; a step adds or subtracts the candidate whose cells lower
the mismatch most, or keeps only what lies in a round one.  Mismatch is counted in nats, as evidence against, and a
leaf costs what its parameters cost to say, so the list is as long as the evidence pays for (minimum description
length; our derivation).  The search subtracts early, because a hole explains much; what would have had to be added
before is then put in before it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from primitives.arrays import Bools, Floats
from recognition.assembly.vocabulary import Candidate, Vocabulary

_SPILT = 0.05  # of a cell's weight, that what is cut off again costs: of equal bodies the tighter stands
_SHUNNED = 20.0  # times its weight, that a cell costs which a list before filled in vain
_DEEP = 1e-4  # of a cell's weight, to lap into what is held: primitives that abut leave a slit


@dataclass(frozen=True)
class SearchOptions:
    """How hard to look."""

    beam: int = 6  # states kept
    tried: int = 6  # candidates tried from each, of each operation
    leaf: float = 20.0  # [nats] of a primitive
    most: int = 80  # leaves at most
    seeds: int = 2  # wrong cells from which prisms are grown, of each operation


@dataclass(frozen=True)
class Step:
    """One entry of the list."""

    operation: str  # "add", "subtract" or "intersect"
    candidate: Candidate


@dataclass(frozen=True)
class State:
    """What a list holds."""

    steps: tuple[Step, ...]
    held: Bools  # (c,)
    wrong: float  # [nats]
    price: float  # [nats] of the leaves

    @property
    def cost(self) -> float:
        """What is left wrong, and what was said."""
        return self.wrong + self.price


def shortest(
    vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions | None = None
) -> State:
    """The cheapest list for (c,) solid cells whose mismatch costs (c,) `weight` [nats] each."""
    options = options or SearchOptions()
    start = State((), np.zeros(len(solid), dtype=bool), float(weight[solid].sum()), 0.0)
    best = _grown(start, vocabulary, solid, weight, options)
    best = min(best, _unfilled(best, vocabulary, solid, weight, options), key=lambda state: state.cost)
    while best.wrong > options.leaf:
        tried = chain(
            _bored(best, vocabulary, solid, weight, options),
            _capped(best, vocabulary, solid, weight, options),
            _rounded(best, vocabulary, solid, weight, options),
        )
        better = min(tried, key=lambda after: after.cost, default=best)
        if better.cost >= best.cost - 1e-9:
            break
        best = _grown(better, vocabulary, solid, weight, options)
    best = _settled(best, vocabulary, solid, weight, options)
    while best.wrong > options.leaf:
        again = _grown(best, vocabulary, solid, weight, options)
        if again.cost >= best.cost - 1e-9:
            break
        best = _settled(again, vocabulary, solid, weight, options)
    return best


def _settled(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """Without what is needless, and with what should have been there before: it may grow again from there."""
    return mended(pruned(state, vocabulary, solid, weight, options), vocabulary, solid, weight, options)


def _grown(
    start: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """The cheapest list that single steps lead to."""
    best, beam = start, [start]
    for _ in range(options.most):
        grown: dict[bytes, State] = {}
        for state in beam:
            for after in _steps(state, vocabulary, solid, weight, options):
                key = np.packbits(after.held).tobytes()
                if key not in grown or after.cost < grown[key].cost - 1e-9:
                    grown[key] = after
        ranked = sorted(grown.values(), key=lambda s: s.cost)
        beam = [s for s in ranked if s.cost < best.cost + 2 * options.leaf][: options.beam]
        if not beam:
            break
        if beam[0].cost < best.cost - 1e-9:
            best = beam[0]
        elif len(beam[0].steps) > len(best.steps) + 2:
            break
    return best


def _unfilled(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """Another list, which leaves free from the first what this one fills and could not take away again.

    The corners of a rounded slab are such: no primitive holds them alone, and two boxes and four cylinders do
    without them.
    """
    extra = ~solid & state.held
    if float(weight[extra].sum()) <= options.leaf:
        return state
    dear = np.where(extra, _SHUNNED * weight, weight)
    start = State((), np.zeros(len(solid), dtype=bool), float(dear[solid].sum()), 0.0)
    other = _grown(start, vocabulary, solid, dear, options)
    return replayed(other.steps, vocabulary, solid, weight, options)


def _bored(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> Iterator[State]:
    """With a primitive added and a round hole through it, where neither of the two pays for itself.

    A bore that was felt is free with much weight, and whoever adds what stands round it fills it first.
    """
    worth = weight * (solid & ~state.held).astype(float) - weight * (~solid & ~state.held)
    for hole in vocabulary.of_each(weight * np.where(solid, -1.0, 1.0), options.tried):
        outside = np.where(vocabulary.mask(hole), 0.0, worth)
        found = [candidate for _, candidate in vocabulary.best(outside, options.tried)]
        for candidate in (*found, *_prisms(outside, np.maximum(outside, 0.0), vocabulary, options)):
            steps = (*state.steps, Step("add", candidate), Step("subtract", hole))
            yield replayed(steps, vocabulary, solid, weight, options)


def _rounded(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> Iterator[State]:
    """With a corner taken off and a round body put there, where neither of the two pays for itself.

    What a rounded edge leaves out of a corner is bounded by the round surface alone, and is no primitive.
    """
    extra, lost = weight * (~solid & state.held), weight * (solid & state.held)
    if float(extra.sum()) <= 2 * options.leaf:
        return
    for body in vocabulary.of_each(np.where(solid, weight, -weight), options.tried):
        inside = vocabulary.mask(body)
        worth = np.where(inside, 0.0, extra - lost)
        for _, corner in vocabulary.best(worth, options.tried):
            steps = (*state.steps, Step("subtract", corner), Step("add", body))
            yield replayed(steps, vocabulary, solid, weight, options)


def _capped(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> Iterator[State]:
    """With what two round surfaces have in common put first, as a flange with a turned edge, or a part of one.

    Added later it would have to be kept by one of them alone, and all that is held before with it; and the ball
    of which a dome is a part would have to be taken away again from under the plate that it is on.
    """
    missing, free = weight * (solid & ~state.held), weight * (~solid & ~state.held)
    for body in vocabulary.rounds(missing - _SPILT * free, options.tried):
        inside = np.where(vocabulary.mask(body), missing - free, 0.0)
        for cap in vocabulary.rounds(inside, options.tried):
            if cap.body != body.body:
                steps = (Step("add", body), Step("intersect", cap), *state.steps)
                yield replayed(steps, vocabulary, solid, weight, options)
        for _, rest in vocabulary.best(-inside, options.tried):
            steps = (Step("add", body), Step("subtract", rest), *state.steps)
            yield replayed(steps, vocabulary, solid, weight, options)


def mended(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """With the additions that were needed before a subtraction, and would undo it at the end."""
    while state.wrong > 0.0:
        tried = _with_one_more(state, vocabulary, solid, weight, options)
        better = min(tried, key=lambda after: after.cost, default=state)
        if better.cost >= state.cost - 1e-9:
            break
        state = pruned(better, vocabulary, solid, weight, options)
    return state


def _with_one_more(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> Iterator[State]:
    """Lists with a primitive more, added before what subtracts or keeps."""
    nothing, everything = np.zeros(len(solid), dtype=bool), np.ones(len(solid), dtype=bool)
    for place, step in enumerate(state.steps):
        if place == 0 or step.operation == "add":
            continue
        before, after = state.steps[:place], state.steps[place:]
        held = _held(before, vocabulary, nothing)
        open_ = _held(after, vocabulary, everything) & ~_held(after, vocabulary, nothing)
        worth = weight * open_ * ((solid & ~held).astype(float) - (~solid & ~held))
        for _, candidate in vocabulary.best(worth, options.tried):
            steps = (*before, Step("add", candidate), *after)
            yield replayed(steps, vocabulary, solid, weight, options)


def _held(steps: Sequence[Step], vocabulary: Vocabulary, held: Bools) -> Bools:
    for step in steps:
        held = _OPERATIONS[step.operation](held, vocabulary.mask(step.candidate))
    return held


def replayed(
    steps: Sequence[Step], vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """What a list holds, and its cost."""
    held = _held(steps, vocabulary, np.zeros(len(solid), dtype=bool))
    price = options.leaf * sum(step.candidate.price for step in steps)
    return State(tuple(steps), held, float(weight[held != solid].sum()), price)


def _steps(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> list[State]:
    missing, extra = solid & ~state.held, ~solid & state.held
    out = []
    if state.steps and extra.any():
        keeps = weight * ((solid & state.held).astype(float) - extra)
        out += [
            after
            for candidate in vocabulary.rounds(keeps, options.tried)
            if (
                after := _after(state, Step("intersect", candidate), vocabulary, solid, weight, options)
            ).wrong
            < state.wrong - 1e-9
        ]
    for operation in ("add", "subtract"):
        adding = operation == "add"
        if not (adding or state.steps) or not (missing if adding else extra).any():
            continue
        right, spoiled = (missing, ~solid & ~state.held) if adding else (extra, solid & state.held)
        deep = (solid & state.held) if adding else (~solid & ~state.held)
        worth = weight * (right.astype(float) - spoiled + _DEEP * deep)
        found = [candidate for _, candidate in vocabulary.best(worth, options.tried)]
        found += _prisms(worth, np.where(right, weight, 0.0), vocabulary, options)
        for candidate in found:
            after = _after(state, Step(operation, candidate), vocabulary, solid, weight, options)
            if after.wrong < state.wrong - 1e-9:
                out.append(after)
    return out


def _prisms(worth: Floats, want: Floats, vocabulary: Vocabulary, options: SearchOptions) -> list[Candidate]:
    """Sides of planes round the cells that are wanted most, by (c,) `want` [nats]."""
    seeds = [int(seed) for seed in np.argsort(-want, kind="stable")[: options.seeds] if want[seed] > 0.0]
    grown = [vocabulary.grown(seed, worth) for seed in seeds]
    return [sides for sides in grown if sides is not None and len(sides.sides) > 1]


def _after(
    state: State, step: Step, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    mask = vocabulary.mask(step.candidate)
    held = _OPERATIONS[step.operation](state.held, mask)
    wrong = float(weight[held != solid].sum())
    return State((*state.steps, step), held, wrong, state.price + options.leaf * step.candidate.price)


_OPERATIONS: dict[str, Callable[[Bools, Bools], Bools]] = {
    "add": lambda held, mask: held | mask,
    "subtract": lambda held, mask: held & ~mask,
    "intersect": lambda held, mask: held & mask,
}


def pruned(
    state: State, vocabulary: Vocabulary, solid: Bools, weight: Floats, options: SearchOptions
) -> State:
    """Without the steps that later ones made needless."""
    improved = True
    while improved and len(state.steps) > 1:
        improved = False
        for skip in range(len(state.steps)):
            steps = [step for k, step in enumerate(state.steps) if k != skip]
            if steps[0].operation != "add":
                continue
            shorter = replayed(steps, vocabulary, solid, weight, options)
            if shorter.cost < state.cost - 1e-9:
                state, improved = shorter, True
                break
    return state

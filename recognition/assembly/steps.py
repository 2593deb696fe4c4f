"""A list one step longer: what mends most is added or subtracted, or only what lies in a round one is kept."""

from __future__ import annotations

import numpy as np

from primitives.arrays import Floats
from recognition.assembly.lists import Listed, Step, Target
from recognition.assembly.vocabulary import Candidate

_DEEP = 1e-4  # of a cell's weight, to lap into what is held: primitives that abut leave a slit


def single_steps(state: Listed, target: Target) -> list[Listed]:
    """Lists with one step more, which get less wrong."""
    weight, tried = target.weight, target.options.tried
    missing, extra = target.missing(state), target.extra(state)
    kept, free = target.kept(state), target.free(state)
    steps = list[Step]()
    if state.steps and extra.any():
        keeps = weight * (kept.astype(float) - extra)
        steps += [Step("intersect", candidate) for candidate in target.vocabulary.rounds(keeps, tried)]
    for operation, right, spoiled, deep in (("add", missing, free, kept), ("subtract", extra, kept, free)):
        if not (operation == "add" or state.steps) or not right.any():
            continue
        worth = weight * (right.astype(float) - spoiled + _DEEP * deep)
        found = [candidate for _, candidate in target.vocabulary.best(worth, tried)]
        found += prisms(worth, np.where(right, weight, 0.0), target)
        steps += [Step(operation, candidate) for candidate in found]
    after = [target.extended(state, step) for step in steps]
    return [longer for longer in after if longer.wrong < state.wrong - 1e-9]


def prisms(worth: Floats, want: Floats, target: Target) -> list[Candidate]:
    """Sides of planes round the cells that are wanted most, by (c,) `want` [nats]."""
    wanted = np.argsort(-want, kind="stable")[: target.options.seeds]
    grown = [target.vocabulary.grown(int(seed), worth) for seed in wanted if want[seed] > 0.0]
    return [sides for sides in grown if sides is not None and len(sides.sides) > 1]

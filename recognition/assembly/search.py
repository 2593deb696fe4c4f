"""The shortest list of primitives, added, subtracted and intersected in order, that holds just the solid cells.

A beam search of single steps: the list is as long as the evidence pays for.  It subtracts early, because a hole
explains much; what would have had to be added before is then put in before it.  Where no single step pays, two at
once are tried (`pairs`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from recognition.assembly.lists import Listed, Step, Target, held_after
from recognition.assembly.pairs import with_two_more
from recognition.assembly.steps import single_steps

_SHUNNED = 20.0  # times its weight, that a cell costs which a list before filled in vain


def shortest(target: Target) -> Listed:
    """The cheapest list that was found."""
    best = _grown(target.empty, target)
    best = min(best, _unfilled(best, target), key=lambda state: state.cost)
    while best.wrong > target.options.leaf:
        better = min(with_two_more(best, target), key=lambda after: after.cost, default=best)
        if better.cost >= best.cost - 1e-9:
            break
        best = _grown(better, target)
    best = _settled(best, target)
    while best.wrong > target.options.leaf:
        again = _grown(best, target)
        if again.cost >= best.cost - 1e-9:
            break
        best = _settled(again, target)
    return best


def _settled(state: Listed, target: Target) -> Listed:
    """Without what is needless, and with what should have been there before: it may grow again from there."""
    return mended(pruned(state, target), target)


def _grown(start: Listed, target: Target) -> Listed:
    """The cheapest list that single steps lead to."""
    options = target.options
    best, beam = start, [start]
    for _ in range(options.most):
        grown: dict[bytes, Listed] = {}
        for state in beam:
            for after in single_steps(state, target):
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


def _unfilled(state: Listed, target: Target) -> Listed:
    """Another list, which leaves free from the first what this one fills and could not take away again.

    The corners of a rounded slab are such: no primitive holds them alone, and two boxes and four cylinders do
    without them.
    """
    extra = target.extra(state)
    if float(target.weight[extra].sum()) <= target.options.leaf:
        return state
    dear = replace(target, weight=np.where(extra, _SHUNNED * target.weight, target.weight))
    return target.listed(_grown(dear.empty, dear).steps)


def mended(state: Listed, target: Target) -> Listed:
    """With the additions that were needed before a subtraction, and would undo it at the end."""
    while state.wrong > 0.0:
        better = min(_with_one_before(state, target), key=lambda after: after.cost, default=state)
        if better.cost >= state.cost - 1e-9:
            break
        state = pruned(better, target)
    return state


def _with_one_before(state: Listed, target: Target) -> Iterator[Listed]:
    """Lists with a primitive more, added before what subtracts or keeps."""
    vocabulary, solid = target.vocabulary, target.solid
    nothing, everything = np.zeros(len(solid), dtype=bool), np.ones(len(solid), dtype=bool)
    for place, step in enumerate(state.steps):
        if place == 0 or step.operation == "add":
            continue
        before, after = state.steps[:place], state.steps[place:]
        held = held_after(before, vocabulary, nothing)
        open_ = held_after(after, vocabulary, everything) & ~held_after(after, vocabulary, nothing)
        worth = target.weight * open_ * ((solid & ~held).astype(float) - (~solid & ~held))
        for _, candidate in vocabulary.best(worth, target.options.tried):
            yield target.listed((*before, Step("add", candidate), *after))


def pruned(state: Listed, target: Target) -> Listed:
    """Without the steps that later ones made needless."""
    improved = True
    while improved and len(state.steps) > 1:
        improved = False
        for skip in range(len(state.steps)):
            steps = [step for k, step in enumerate(state.steps) if k != skip]
            if steps[0].operation != "add":
                continue
            shorter = target.listed(steps)
            if shorter.cost < state.cost - 1e-9:
                state, improved = shorter, True
                break
    return state

"""A list of primitives bettered by another end of one of them, and one primitive more where that leaves a gap.

The search takes what explains most first.  A bar with a round end is then explained by a box open past that end,
and nothing that is added or subtracted later takes the corners away: the box must end at the round end's axis,
and the cylinder be added.  A counterbore taken to go through explains the bore behind it, too: it must end at its
ledge, and the bore be subtracted (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from primitives.shapes import Plane
from recognition.assembly.lists import Listed, Step, Target
from recognition.assembly.search import pruned
from recognition.assembly.vocabulary import Candidate, Slab, Vocabulary

_ROUNDS = 8  # exchanges at most
_GAPS = 240  # that one more primitive is looked for to fill, in each


def exchanged(state: Listed, target: Target) -> Listed:
    """The cheapest list that single exchanges lead to."""
    for _ in range(_ROUNDS):
        if state.wrong <= target.options.leaf:
            break
        better = _bettered(state, target)
        if better.cost >= state.cost - 1e-9:
            break
        state = pruned(better, target)
    return _boxed(state, target)


def _boxed(state: Listed, target: Target) -> Listed:
    """With boxes for the prisms that hold the same cells: a person reads them sooner."""
    for place, step in enumerate(state.steps):
        if step.candidate.kind == "prism":
            inside = np.where(target.vocabulary.mask(step.candidate), 1.0, -1.0)
            for _, candidate in target.vocabulary.best(inside, 1):
                steps = (*state.steps[:place], Step(step.operation, candidate), *state.steps[place + 1 :])
                other = target.listed(steps)
                state = other if other.cost < state.cost - 1e-9 else state
    return state


def _bettered(state: Listed, target: Target) -> Listed:
    """The cheapest list that another end of one primitive leads to, with one more or without.

    One more costs a leaf and mends at most what is missing: where that is not enough none is looked for, nor where
    more gaps than can be gone through promise more.
    """
    leaf, best, gaps = target.options.leaf, state, []
    for place, step in enumerate(state.steps):
        for candidate in _other_ends(step.candidate, target.vocabulary):
            steps = (*state.steps[:place], Step(step.operation, candidate), *state.steps[place + 1 :])
            other = target.listed(steps)
            best = min(best, other, key=lambda after: after.cost)
            for more, lot in (("add", target.missing(other)), ("subtract", target.extra(other))):
                if (mended := float(target.weight[lot].sum())) > leaf:
                    gaps.append((other.cost + leaf - mended, place, more, other))
    for least, place, more, other in sorted(gaps, key=lambda gap: gap[0])[:_GAPS]:
        if least >= best.cost - 1e-9:
            break
        tried = _with_one_more(other, (place, more), target)
        best = min((best, *tried), key=lambda after: after.cost)
    return best


def _with_one_more(state: Listed, more: tuple[int, str], target: Target) -> Iterator[Listed]:
    """With one added right after a place, that holds most of what is missing, or one subtracted at the end."""
    place, operation = more
    if operation == "add":
        right, wrong, place = target.missing(state), target.free(state), place + 1
    else:
        right, wrong, place = target.extra(state), target.kept(state), len(state.steps)
    worth = target.weight * (right.astype(float) - wrong)
    for _, candidate in target.vocabulary.best(worth, 2):
        steps = (*state.steps[:place], Step(operation, candidate), *state.steps[place:])
        yield target.listed(steps)


def _other_ends(candidate: Candidate, vocabulary: Vocabulary) -> Iterator[Candidate]:
    """The same with one end at another plane of its direction, or open; a prism is cut once more."""
    if candidate.kind == "prism":
        bounding = {plane for plane, _ in candidate.sides}
        for plane, shape in enumerate(vocabulary.shapes):
            if isinstance(shape, Plane) and plane not in bounding:
                yield from (
                    replace(candidate, sides=(*candidate.sides, (plane, outside)))
                    for outside in (False, True)
                )
    for k, (slab, planes) in enumerate(zip(candidate.slabs, _planes(candidate, vocabulary), strict=True)):
        for other in _other_slabs(slab, planes):
            yield replace(candidate, slabs=(*candidate.slabs[:k], other, *candidate.slabs[k + 1 :]))


def _planes(candidate: Candidate, vocabulary: Vocabulary) -> list[Sequence[int]]:
    """The planes, in order, that each slab may end at."""
    if candidate.frame is None:
        return [vocabulary.across(candidate.body)] if candidate.slabs and candidate.body is not None else []
    axes = vocabulary.frames[candidate.frame]
    return [() if axis is None else vocabulary.directions[axis].planes for axis in axes]


def _other_slabs(slab: Slab, planes: Sequence[int]) -> Iterator[Slab]:
    order = {plane: k for k, plane in enumerate(planes)}
    low, high = slab
    first = -1 if low is None else order[low]
    last = len(planes) if high is None else order[high]
    yield from ((p, high) for p in (None, *planes[:last]) if p != low and (p is None or order[p] < last))
    yield from ((low, p) for p in (*planes[first + 1 :], None) if p != high)

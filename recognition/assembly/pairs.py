"""Two primitives at once, where neither of the two pays for itself (our derivation)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

import numpy as np

from recognition.assembly.lists import Listed, Step, Target
from recognition.assembly.steps import prisms

_SPILT = 0.05  # of a cell's weight, that what is cut off again costs: of equal bodies the tighter stands


def with_two_more(state: Listed, target: Target) -> Iterator[Listed]:
    """Lists that a pair of steps leads to."""
    return chain(bored(state, target), capped(state, target), rounded(state, target))


def bored(state: Listed, target: Target) -> Iterator[Listed]:
    """With a primitive added and a round hole through it.

    A bore that was felt is free with much weight, and whoever adds what stands round it fills it first.
    """
    vocabulary, weight, tried = target.vocabulary, target.weight, target.options.tried
    worth = weight * target.missing(state) - weight * target.free(state)
    for hole in vocabulary.of_each(np.where(target.solid, -weight, weight), tried):
        outside = np.where(vocabulary.mask(hole), 0.0, worth)
        found = [candidate for _, candidate in vocabulary.best(outside, tried)]
        for candidate in (*found, *prisms(outside, np.maximum(outside, 0.0), target)):
            yield target.listed((*state.steps, Step("add", candidate), Step("subtract", hole)))


def rounded(state: Listed, target: Target) -> Iterator[Listed]:
    """With a corner taken off and a round body put there.

    What a rounded edge leaves out of a corner is bounded by the round surface alone, and is no primitive.
    """
    vocabulary, weight, tried = target.vocabulary, target.weight, target.options.tried
    extra, lost = weight * target.extra(state), weight * target.kept(state)
    if float(extra.sum()) <= 2 * target.options.leaf:
        return
    for body in vocabulary.of_each(np.where(target.solid, weight, -weight), tried):
        worth = np.where(vocabulary.mask(body), 0.0, extra - lost)
        for _, corner in vocabulary.best(worth, tried):
            yield target.listed((*state.steps, Step("subtract", corner), Step("add", body)))


def capped(state: Listed, target: Target) -> Iterator[Listed]:
    """With what two round surfaces have in common put first, as a flange with a turned edge, or a part of one.

    Added later it would have to be kept by one of them alone, and all that is held before with it; and the ball
    of which a dome is a part would have to be taken away again from under the plate that it is on.
    """
    vocabulary, tried = target.vocabulary, target.options.tried
    missing, free = target.weight * target.missing(state), target.weight * target.free(state)
    for body in vocabulary.rounds(missing - _SPILT * free, tried):
        inside = np.where(vocabulary.mask(body), missing - free, 0.0)
        for cap in vocabulary.rounds(inside, tried):
            if cap.body != body.body:
                yield target.listed((Step("add", body), Step("intersect", cap), *state.steps))
        for _, rest in vocabulary.best(-inside, tried):
            yield target.listed((Step("add", body), Step("subtract", rest), *state.steps))

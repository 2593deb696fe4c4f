"""Labels that contacts' costs and their neighbors make likeliest: iterated conditional modes (Besag 1986)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class LabelOptions:
    """How strongly neighbors agree."""

    coupling: float = 0.7  # [nats] of two neighbors with different labels
    sweeps: int = 20


def labeled(
    unary: Floats, links: csr_array, start: Ints | None = None, options: LabelOptions | None = None
) -> Ints:
    """(n,) labels for (labels, n) costs [nats]; the last label is -1, and nobody's neighbor."""
    options = options or LabelOptions()
    count, n = unary.shape
    last = count - 1
    label = unary.argmin(axis=0) if start is None else np.where(start < 0, last, start)
    half = np.random.default_rng(0).random(n) < 0.5
    degree = np.asarray(links.sum(axis=1)).ravel()
    for sweep in range(options.sweeps):
        held = np.zeros((n, count))
        held[np.arange(n), label] = 1.0
        held[:, last] = 0.0
        agree = (links @ held).T
        cost = unary + options.coupling * (degree - agree)
        wanted = cost.argmin(axis=0)
        turn = half if sweep % 2 == 0 else ~half
        moved = turn & (wanted != label)
        if not (wanted != label).any():
            break
        label = np.where(moved, wanted, label)
    return np.where(label == last, -1, label).astype(np.int64)

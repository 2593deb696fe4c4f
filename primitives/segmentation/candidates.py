"""Which shapes a cloud of oriented contacts could have: proposed by neighbors, kept where they agree with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from primitives.arrays import Floats, Ints
from primitives.segmentation.misfit import Oriented
from primitives.segmentation.neighbors import nearest
from primitives.segmentation.proposals import Proposals, proposals
from primitives.shapes import Shape

_FAR = 1e9  # chi2 that no contact of a face has


@dataclass(frozen=True)
class CandidateOptions:
    """How many are looked at."""

    groups: tuple[int, ...] = (4, 7, 12, 20)  # neighbors in one
    seeds: int = 450  # contacts round which groups are formed, of each size
    pairs: int = 1000  # of contacts near each other
    agreeing: float = 3.0  # chi2 of a contact, per residual, up to which a group agrees with its shape
    most: int = 1500  # kept, the most agreeable first
    block: int = 200_000  # shapes times contacts that are compared at a time


@dataclass(frozen=True)
class Candidates:
    """Shapes, and what each contact would cost on each."""

    of: tuple[tuple[Proposals, int], ...]
    kinds: tuple[str, ...]
    chi2: NDArray[np.float32]  # (c, n)

    def __len__(self) -> int:
        return len(self.of)

    def shape(self, row: int) -> tuple[Shape, float]:
        """One of them, and its sign."""
        made, k = self.of[row]
        return made.shape(k)


def candidates(
    felt: Oriented,
    apart: Floats,
    among: Ints,
    rng: np.random.Generator,
    options: CandidateOptions | None = None,
) -> Candidates:
    """Proposed by the contacts `among` (m,) alone, and compared with all."""
    options = options or CandidateOptions()
    table = felt.contacts
    sigma, turn = float(np.median(table.sigma)), float(np.median(table.normal_sigma))
    kept: list[tuple[Proposals, Floats]] = []
    for rows in (among[g] for g in _groups(table.points[among], apart[among], rng, options)):
        points, normals = table.points[rows], table.normals[rows]
        for made in proposals(points, normals, sigma, turn):
            g = made.group
            own = made.misfit(
                points[g], normals[g], felt.weight[rows][g], felt.turn_weight[rows][g], felt.felt[rows][g]
            )
            score = np.where(np.isfinite(own).all(axis=1), own.mean(axis=1), np.inf)
            good = score < 3.0 * options.agreeing
            kept.append((made.select(good), score[good] / rows.shape[1]))
    return _evaluated(kept, felt, options)


def _groups(points: Floats, apart: Floats, rng: np.random.Generator, options: CandidateOptions) -> list[Ints]:
    """(g, k) rows of contacts near each other, for every k; pairs besides."""
    n = len(points)
    sizes = sorted({min(k, n) for k in options.groups if min(k, n) >= 2})
    seeds = np.arange(n) if n <= options.seeds else np.sort(rng.choice(n, options.seeds, replace=False))
    near = nearest(apart, min(max(sizes, default=1), n))[1]
    out = [near[seeds][:, :k] for k in sizes]
    around = nearest(points, min(24, n))[1]
    if around.shape[1] > 1:
        first = rng.integers(0, n, options.pairs)
        second = around[first, rng.integers(1, around.shape[1], options.pairs)]
        out.append(np.unique(np.stack([first, second], axis=1), axis=0))
    return out


def _evaluated(kept: list[tuple[Proposals, Floats]], felt: Oriented, options: CandidateOptions) -> Candidates:
    scores = np.concatenate([score for _, score in kept]) if kept else np.empty(0)
    bound = np.inf if len(scores) <= options.most else np.partition(scores, options.most)[options.most]
    chosen: list[tuple[Proposals, int]] = []
    kinds: list[str] = []
    costs: list[NDArray[np.float32]] = []
    table = felt.contacts
    step = max(1, options.block // max(len(felt), 1))
    for made, score in kept:
        some = made.select(score <= bound)
        for begin in range(0, len(some), step):
            part = some.select(np.arange(begin, min(begin + step, len(some))))
            cost = part.misfit(table.points, table.normals, felt.weight, felt.turn_weight, felt.felt)
            costs.append(np.minimum(cost, _FAR).astype(np.float32))
        chosen += [(some, k) for k in range(len(some))]
        kinds += [some.kind] * len(some)
    return Candidates(
        tuple(chosen), tuple(kinds), np.concatenate(costs) if costs else np.empty((0, len(felt)), np.float32)
    )

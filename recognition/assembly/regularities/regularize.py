"""Relations that a designer meant, accepted only where the measured uncertainty allows them.

The fitted shapes s_i are retracted by one stacked step x, of prior x ~ N(0, P).  A relation is a constraint
h(x) = 0, for example n_a . n_b = 0.  Given the relations accepted before it, it costs (our derivation; a Kalman
update with a perfect measurement, as in Simon 2010, "Kalman filtering with state constraints")

    chi2 = h' (H P H')^-1 h,    H = dh/dx,

and is accepted where h is likelier, with the spread S = H P H' that it has where the relation was meant, than
among k values drawn at random within the range w that is looked at, given the odds b that one so near is meant:

    chi2 <= 2 (k ln w + ln b) - ln det(2 pi S).

Two directions that nearly agree are thus allowed more deviations than two radii: they rarely do by chance, and the
lean of a narrow side is known less well than is stated.  Of faces that may be one or share an axis chi2 is held
against its quantile.  At the end, and wherever a step left what it should meet, x is polished by Gauss-Newton onto
all accepted constraints, and its covariance is P conditioned on them, so that sizes which span two faces gain from
both.  A misalignment that was really measured is kept.  Sizes that together lie on one grid of round numbers are
then put on it, and keep their covariance: no workshop meets a number.
"""

from __future__ import annotations

from collections.abc import Sequence

from primitives.arrays import frozen
from primitives.fit import Fit
from recognition.assembly.regularities import patterns, proposals
from recognition.assembly.regularities.relation import Proposal, RegularityOptions, Regularized
from recognition.assembly.regularities.round_sizes import put_on_grid
from recognition.assembly.regularities.state import State

_STAGES = (
    proposals.coincident,
    proposals.parallel,
    proposals.perpendicular,
    proposals.coaxial,
    proposals.equal_radius,
    proposals.tangent,
    patterns.evenly_spaced,
)


def regularize(fits: Sequence[Fit], options: RegularityOptions | None = None) -> Regularized:
    """Accept what the covariances allow, the best known first, and adjust all shapes to it."""
    state = State(fits, options or RegularityOptions())
    for stage in _STAGES:
        for proposal in _surest_first(state, stage(state)):
            state.consider(proposal)
    state.polish()
    if state.options.round:
        put_on_grid(state)
    return Regularized(
        tuple(state.shapes()), frozen(state.posterior), state.slices, tuple(state.relations), frozen(state.x)
    )


def _surest_first(state: State, found: list[Proposal]) -> list[Proposal]:
    """By how well they are known, and not by how well they hold.

    Those that hold best first would gather what is alike in several clusters, each too sure to join another.
    """
    unsure = [state.unsure(proposal) for proposal in found]
    return [found[i] for i in sorted(range(len(found)), key=unsure.__getitem__)]

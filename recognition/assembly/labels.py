"""Which cells are solid: the labels that contacts make likeliest, by a minimum cut.

With contacts at a density rho over the felt surface, a boundary of area a without a contact has the probability
exp(-rho a); a contact whose inner side is free, or whose outer side is solid, is a stray, of a fixed small
probability.  So, with s of {0, 1} the labels (our derivation)::

    -ln p = stray * (votes against) + sum over facets rho a [s_inner != s_outer],

which is submodular: its minimum is a minimum cut (Greig, Porteous and Seheult 1989).  Where all contacts of a
surface look one way, a boundary on it that looks the other way is another face, of which nobody felt anything.  A
body that ends at a plane which is no face's has a face there that nobody felt, too.

A cell with contacts that say solid, and places that something went through, is no one thing: a surface is missing
that would part it, as of a bore whose wall nobody felt.  It is what its greater part is: the votes for the lesser
cost no more than a missing surface does, and the volume that is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from primitives.arrays import Bools, Floats, Ints
from recognition.assembly.arrangement import Arrangement

_SCALE = 1000.0  # of nats, for a flow of whole numbers
_MOST = 1_000_000_000  # capacity that nothing cuts


@dataclass(frozen=True)
class LabelOptions:
    """Probabilities, in nats."""

    stray: float = 6.0  # of a contact that lies on no boundary, or on one turned the other way
    missing: float = 40.0  # of a surface that parts a cell and was not recognized
    space: float = 10.0  # per contact, of the whole volume wrongly filled
    sparse: float = 1.5  # times the contacts per area of a surface, that are expected of every part of it
    turned: float = (
        2.0  # times the mean, expected of a boundary that looks as none of its surface's contacts do
    )
    stop: float = 2.0  # the same, of one at a plane that is no face's
    outside: float = 50.0  # of material past all contacts, for a cell of which all lies there


def solid_cells(found: Arrangement, options: LabelOptions | None = None) -> Bools:
    """(c,) whether a cell is solid."""
    options = options or LabelOptions()
    touched = float(found.solid_votes.sum())
    material, empty = found.solid_votes > 0, found.free_votes + found.swept_votes > 0
    supported = material[found.pairs[:, 0]] & empty[found.pairs[:, 1]]
    supported |= material[found.pairs[:, 1]] & empty[found.pairs[:, 0]]
    mean = touched / max(float(found.area[supported].sum()), 1e-9)
    density = _densities(found, supported, mean, options.sparse)
    density = np.where(found.stops[_surfaces(found)], np.maximum(density, options.stop * mean), density)
    volume = max(float(found.volume.sum()), 1e-9)
    whole = found.beyond > 0.5
    parted = (found.solid_votes > 0) & (found.swept_votes > 0)
    room = options.space * touched * found.volume / volume
    swept, solid = options.stray * found.swept_votes, options.stray * found.solid_votes
    lesser = options.missing + room * np.minimum(found.swept_share, 1.0 - found.swept_share)
    swept = np.where(parted & (found.swept_share < 0.5), np.minimum(swept, lesser), swept)
    to_solid = np.where(parted & (found.swept_share > 0.5), np.minimum(solid, lesser), solid)
    to_free = options.stray * found.free_votes + swept + np.where(whole, options.outside, 0.0)
    to_free = to_free + touched * found.beyond * found.volume / volume
    either = np.where(_turned(found), np.maximum(density, options.turned * mean), density)
    return _cut(to_solid, to_free, found, either * found.area)


def _surfaces(found: Arrangement) -> Ints:
    """(f,) which surface each facet lies on."""
    inner, outer = found.outside[found.pairs[:, 0]], found.outside[found.pairs[:, 1]]
    return np.asarray((inner != outer).argmax(axis=1))


def _turned(found: Arrangement) -> Bools:
    """(2, f) whether all contacts of a facet's surface look the other way, were it solid inside it, or outside."""
    none, some = found.facing == 0, found.facing[::-1] > 0
    return np.asarray((none & some)[:, _surfaces(found)])


def _densities(found: Arrangement, supported: Bools, mean: float, sparse: float) -> Floats:
    """(f,) contacts to be expected per area of a facet: the mean of all, but where its own surface has far fewer.

    Of a surface that is inferred all area counts: nobody was there, and no more are to be expected anywhere.
    What a surface has is shrunk to the mean by one contact, and `sparse` times that is expected, for none has the
    same everywhere; one that nobody felt counts as the mean.
    """
    surface = _surfaces(found)
    counts = supported | found.inferred[surface]
    area = np.bincount(surface, np.where(counts, found.area, 0.0), minlength=found.outside.shape[1])
    own = (found.touched + 1.0) / (area + 1.0 / max(mean, 1e-9))
    own = np.where(found.touched > 0, np.minimum(sparse * own, mean), mean)
    return np.asarray(own[surface])


def _cut(to_solid: Floats, to_free: Floats, found: Arrangement, cost: Floats) -> Bools:
    """(c,) the labels of least cost: (2, f) that of a facet solid inside its surface, and outside it."""
    count = len(found)
    source, sink = count, count + 1
    everyone = np.arange(count)
    a, b = found.pairs.T
    rows = np.concatenate([np.full(count, source), everyone, a, b])
    columns = np.concatenate([everyone, np.full(count, sink), b, a])
    weight = np.concatenate([to_solid, to_free, cost[0], cost[1]])
    top = max(float(to_solid.sum() + to_free.sum()), 1.0)
    scale = min(_SCALE, _MOST / top)
    capacity = np.minimum(np.round(weight * scale), _MOST).astype(np.int32)
    network = csr_array(coo_array((capacity, (rows, columns)), shape=(count + 2, count + 2)))
    network.sum_duplicates()
    flow = maximum_flow(network, source, sink).flow
    left = csr_array(network - flow)
    left.data = np.where(left.data > 0, left.data, 0)
    left.eliminate_zeros()
    reached = breadth_first_order(left, source, return_predecessors=False)
    solid = np.zeros(count + 2, dtype=bool)
    solid[reached] = True
    return np.asarray(solid[:count])

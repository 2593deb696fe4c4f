"""How far contacts lie off the faces that they are of, where nobody says: as far as makes the faces likeliest.

With the energy of the likeliest faces at a sigma (`faces`), which leaves out what each contact's density is
divided by, minus the logarithm of the evidence of n contacts is (type II maximum likelihood; our derivation)::

    -ln p(contacts | sigma) = energy(sigma) + n ln sigma.

Too small a sigma leaves contacts on faces of their own, too large a one pays ln sigma for every contact.  Between
sigmas that are tried, each half the one before, it is taken to be a parabola of ln sigma.  Contacts so few that
faces go through all of them say nothing of small sigmas: the largest that is as good as the likeliest is said.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.segmentation.faces import Search
from primitives.segmentation.normals import with_normals
from primitives.segmentation.terms import FacesOptions


@dataclass(frozen=True)
class ScatterOptions:
    """Where it is looked for."""

    step: float = 2.0  # factor between sigmas that are tried
    worse: int = 2  # sigmas in a row that are worse than the best, after which no smaller one is tried
    most: int = 12  # sigmas
    doubt: float = 2.0  # [nats] by which one may be less likely than the likeliest, and as good
    faces: FacesOptions = field(default_factory=FacesOptions)


def likeliest_sigma(
    contacts: Contacts, largest: float, among: Floats | None = None, options: ScatterOptions | None = None
) -> float:
    """[mm] at most `largest`; `among` as in `segment`, from which normals are taken where none was felt."""
    options = options or ScatterOptions()
    tried = [largest]
    costs = [_cost(contacts, largest, among, options)]
    while len(tried) < options.most and len(costs) - 1 - int(np.argmin(costs)) < options.worse:
        tried.append(tried[-1] / options.step)
        costs.append(_cost(contacts, tried[-1], among, options))
    best = int(np.argmax(np.array(costs) <= min(costs) + options.doubt))
    if not 0 < best < len(costs) - 1:
        return tried[best]
    before, here, after = costs[best - 1 : best + 2]
    if after < here:
        return tried[best]
    return float(tried[best] * options.step ** (0.5 * (after - before) / (before - 2 * here + after)))


def _cost(contacts: Contacts, sigma: float, among: Floats | None, options: ScatterOptions) -> float:
    """[nats] minus the logarithm of the evidence."""
    table = replace(contacts, sigma=frozen(np.full(len(contacts), sigma)))
    search = Search(table, with_normals(table, among), options.faces)
    return search.energy(*search.run()) + len(table) * float(np.log(sigma))

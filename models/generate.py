"""Random parts that a shop could make: a base body with features on its free faces.

A base is a block, plate, round body, flange, bracket, channel, frustum or post; features are holes, slots,
pockets, bosses, domes, grooves and patterns of holes.  Sizes are those that a designer would write.  A part is
one connected body without hollows, by construction: features never meet, and no flat face and no wall is
narrower than `least`.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from models.csg import Csg
from models.generation.bases import BASES
from models.generation.features import FEATURES, Feature
from models.generation.sites import Site
from primitives.errors import PalpateError

Maker = TypeVar("Maker")
_TRIES = 6  # features that are drawn for one site before it is cut or left


@dataclass(frozen=True)
class GenerateConfig:
    """What limits the sizes."""

    largest: float = 160.0  # [mm] of the base; what is added to it may reach 40 mm farther
    least: float = 2.0  # [mm] no face and no wall is thinner


def generate(rng: np.random.Generator, complexity: int = 4, config: GenerateConfig | None = None) -> Csg:
    """A random part with at most `complexity` features."""
    if complexity < 0:
        raise PalpateError(f"a part has no fewer than 0 features, not {complexity}")
    limits = config or GenerateConfig()
    part, free = _chosen(rng, BASES)(rng, limits.largest, limits.least)
    sites = list(free)
    for _ in range(complexity):
        if not sites:
            break
        areas = np.array([site.width * site.length for site in sites])
        site = sites.pop(int(rng.choice(len(sites), p=areas / areas.sum())))
        if site.room >= 15 and max(site.width, site.length) >= 30 and rng.random() < 0.7:
            site, other = site.halves(float(rng.uniform(0.35, 0.65)))
            sites.append(other)
        feature = _drawn(rng, site, limits.least)
        if feature:
            part = _with(part, feature, site)
    return part


def _drawn(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    for _ in range(_TRIES):
        feature = _chosen(rng, FEATURES)(rng, site, least)
        if feature:
            return feature
    return None


def _chosen(rng: np.random.Generator, table: tuple[tuple[Maker, float], ...]) -> Maker:
    """One of a table's first column, each as likely as its second says."""
    weights = np.array([weight for _, weight in table])
    return table[int(rng.choice(len(table), p=weights / weights.sum()))][0]


def _with(part: Csg, feature: Feature, site: Site) -> Csg:
    if feature.adds is not None:
        part = part | feature.adds.placed(site.part_from_site)
    if feature.cuts is not None:
        part = part - feature.cuts.placed(site.part_from_site)
    return part

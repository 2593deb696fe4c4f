"""What a labeling of contacts by faces costs, in nats, and the likeliest face through some of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array

from primitives.arrays import Floats, Ints
from primitives.classify import RankOptions
from primitives.evidence import Contacts
from primitives.fit import Fit, FitOptions, fit, refit
from primitives.segmentation.candidates import CandidateOptions
from primitives.segmentation.evidence import alone, alone_without_normal, price
from primitives.segmentation.labels import LabelOptions
from primitives.segmentation.misfit import Oriented
from primitives.segmentation.neighbors import lifted, linked, nearest
from primitives.segmentation.proposals import proposals
from primitives.shapes import Cone, Cylinder, Shape, Sphere, Torus

_UNFELT = 0.05  # [rad] to which a face's direction is known, roughly, where no normal is felt


@dataclass(frozen=True)
class FacesOptions:
    """How hard to look."""

    links: int = 8  # nearest contacts to which a face may spread
    tried: int = 6  # candidates fitted for each face
    turns: int = 3  # of labels, fits, merges and deletions
    most: int = 250  # faces
    hopeless: float = 8.0  # times what is allowed: a start that is worse is not followed
    ring: int = 6  # contacts through which a torus is looked for
    rings: int = 8  # tori at most that are looked for through neighbors
    ring_group: int = 16  # neighbors through which one goes
    ring_seeds: int = 8  # such groups
    poor: float = 0.5  # of the cost of a contact alone, from which one is explained badly
    plausible: float = 3.0  # chi2 per degree of freedom of a group that lies on a torus
    largest: float = 5.0  # radius of a face, in extents of the contacts; what is rounder is flat
    candidates: CandidateOptions = field(default_factory=CandidateOptions)
    labels: LabelOptions = field(default_factory=LabelOptions)
    fit: FitOptions = field(default_factory=lambda: FitOptions(gain=1e-4, iterations=8, starts=2))
    rank: RankOptions = field(default_factory=RankOptions)


@dataclass(frozen=True)
class Model:
    """One face: its fit, and what it costs to have it."""

    fit: Fit
    price: float  # [nats]
    cost: float  # [nats] with that of the contacts that it was fitted to

    @property
    def sign(self) -> float:
        """-1 where the material is outside."""
        return 1.0 if self.fit.convex else -1.0


class Terms:
    """The energy of one cloud."""

    def __init__(self, contacts: Contacts, oriented: Contacts, options: FacesOptions | None = None) -> None:
        """Contacts as felt, and the same with a normal each."""
        self.options = options or FacesOptions()
        felt = contacts.has_normal
        self.felt = Oriented.of(oriented, felt)
        self.contacts = contacts
        self.extent = max(float(np.linalg.norm(np.ptp(contacts.points, axis=0))), 1e-6)
        sigma, turn = float(np.median(contacts.sigma)), contacts.normal_sigma[felt]
        self.start = alone(sigma, float(np.median(turn)) if len(turn) else _UNFELT, self.extent)
        self.single: Floats = np.where(felt, self.start, alone_without_normal(sigma, self.extent))
        apart = lifted(oriented.points, oriented.normals)
        count = min(self.options.links + 1, len(contacts))
        self.links: csr_array = linked(nearest(apart, count)[1])
        self.apart = apart

    def energy(self, models: list[Model], label: Ints) -> float:
        """[nats] of a labeling."""
        cost = self.unary(models)[label, np.arange(len(label))].sum() + sum(m.price for m in models)
        rows, columns = self.links.nonzero()
        cut = float((label[rows] != label[columns]).sum()) / 2
        return float(cost) + self.options.labels.coupling * cut

    def unary(self, models: list[Model]) -> Floats:
        """(faces + 1, n) nats of each contact on each face, the last for standing alone."""
        rows = [0.5 * self.felt.chi2(m.fit.shape, m.sign) for m in models]
        return np.stack([*rows, self.single])

    def model(self, found: Fit, mine: Ints) -> Model:
        """A fit to some contacts, with its price."""
        said = price(found, self.extent, self.contacts.points[mine].mean(axis=0))
        return Model(found, said, 0.5 * self._misfit(found.shape, found.convex, mine) + said)

    def usable(self, shape: Shape) -> bool:
        """Whether a shape is not in truth a simpler one."""
        if isinstance(shape, Cylinder | Sphere | Torus):
            return shape.radius < self.options.largest * self.extent
        return not isinstance(shape, Cone) or shape.semi_angle > self.options.rank.least_angle

    def _misfit(self, shape: Shape, convex: bool, mine: Ints) -> float:
        return float(self.felt.select(mine).chi2(shape, 1.0 if convex else -1.0).sum())

    def best(
        self, mine: Ints, near: list[Model], kinds: Sequence[str], bound: float = np.inf
    ) -> Model | None:
        """The likeliest face through some contacts, below a bound of its cost [nats].

        Looked for from faces that are near it, and from what a closed form of each kind gives.
        """
        table = self.contacts.select(mine)
        worst = self.options.hopeless * (min(bound, float(self.single[mine].sum())))
        starts = [
            (m.fit.shape, m.sign) for m in near if 0.5 * self._misfit(m.fit.shape, m.fit.convex, mine) < worst
        ]
        group = table.points[None], self.felt.contacts.normals[mine][None]
        for made in proposals(*group, float(np.median(table.sigma)), float(np.median(table.normal_sigma))):
            if made.kind not in kinds or not len(made) or not np.isfinite(made.anchor).all():
                continue
            off = made.misfit(
                *group, self.felt.weight[mine], self.felt.turn_weight[mine], self.felt.felt[mine]
            )
            if 0.5 * float(off.sum()) < worst:
                starts.append(made.shape(0))
        fits = [refit(shape, sign > 0, table, self.options.fit) for shape, sign in starts]
        models = [self.model(found, mine) for found in fits if isinstance(found, Fit)]
        likeliest = min(models, key=lambda m: m.cost, default=None)
        if "torus" in kinds and likeliest is not None and likeliest.fit.kind == "cylinder":
            opened = fit("cone", table, self.options.fit)  # no closed form finds one that hardly opens
            models += [self.model(opened, mine)] if isinstance(opened, Fit) else []
        if "torus" in kinds and len(mine) >= self.options.ring and not any(_settled(m) for m in models):
            ring = fit("torus", table, self.options.fit)
            models += [self.model(ring, mine)] if isinstance(ring, Fit) else []
        good = [m for m in models if self.usable(m.fit.shape) and m.cost < bound]
        return min(good, key=lambda m: m.cost, default=None)


def _settled(model: Model) -> bool:
    """Whether a face leaves no more than noise does."""
    return model.fit.kind == "plane" and model.fit.chi2 < 1.5 * max(model.fit.dof, 1)

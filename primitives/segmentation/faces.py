"""The faces of a cloud of oriented contacts: the fewest and simplest that explain it (maximum posterior).

The energy of a labeling, in nats, with one label per face and one for contacts that stand alone (after Isack and
Boykov 2012, "Energy-based geometric multi-model fitting", with evidence in place of fixed label costs)::

    sum over contacts chi2 / 2 + sum over faces price + coupling * (neighbors with different labels).

It is lowered by turns: take the candidate that explains most, again and again; then tori, which no closed form
through a few neighbors gives, through contacts that are explained badly or by a face of few; then labels, fits,
merges and deletions until none pays.
"""

from __future__ import annotations

import numpy as np

from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import Contacts
from primitives.fit import Fit, fit, refit
from primitives.segmentation.candidates import candidates
from primitives.segmentation.evidence import rough_price
from primitives.segmentation.labels import labeled
from primitives.segmentation.neighbors import heaviest_part, nearest
from primitives.segmentation.terms import FacesOptions, Model, Terms
from primitives.shapes import KINDS, Shape

_QUICK = ("plane", "sphere", "cylinder", "cone")
_FEWEST = 2  # contacts through which a face is looked for


class Search(Terms):
    """The moves that lower the energy."""

    def __init__(self, contacts: Contacts, oriented: Contacts, options: FacesOptions | None = None) -> None:
        super().__init__(contacts, oriented, options)
        self.rng = np.random.default_rng(0)

    def run(self) -> tuple[list[Model], Ints]:
        """The faces, and the (n,) one of each contact; -1 where it stands alone."""
        models = self.chosen(np.ones(len(self.contacts), dtype=bool))
        label = self.labels(models)
        models, label = self.ringed(models, label)
        for turn in range(self.options.turns):
            before = self.energy(models, label)
            models, label = self.refitted(models, label, every_kind=turn > 0)
            models, label = self.merged(models, label)
            models, label = self.thinned(models, label)
            loose = label < 0
            more = self.chosen(loose)
            if more:
                models = [*models, *more]
                label = self.labels(models)
            elif turn > 0 and self.energy(models, label) > before - 1.0:
                break
        models, label = self.thinned(*self.refitted(models, label, every_kind=True))
        return models, label

    def chosen(self, free: Bools) -> list[Model]:
        """Greedily, the candidates among the free contacts that explain most of them, until none pays."""
        free = free.copy()
        if free.sum() < _FEWEST:
            return []
        found = candidates(self.felt, self.apart, np.flatnonzero(free), self.rng, self.options.candidates)
        worth = np.maximum(self.single.astype(np.float32) - np.float32(0.5) * found.chi2, 0)
        prices = np.array([rough_price(kind, self.start) for kind in found.kinds])
        models: list[Model] = []
        while free.any() and len(models) < self.options.most and len(worth):
            gains = worth @ free.astype(np.float32) - prices
            order = np.argsort(-gains, kind="stable")[: self.options.tried]
            tried = [self._followed(*found.shape(int(c)), free, self.single) for c in order if gains[c] > 0]
            good = [one for one in tried if one is not None and one[0] > 0]
            if not good:
                worth[order] = 0.0
                if not len(order) or gains[order[0]] <= 0:
                    break
                continue
            _, model, mine = max(good, key=lambda one: one[0])
            models.append(model)
            free[mine] = False
        return models

    def ringed(self, models: list[Model], label: Ints) -> tuple[list[Model], Ints]:
        """With the tori that cost less than what explains their contacts now."""
        options = self.options
        for _ in range(options.rings):
            count = np.bincount(label[label >= 0], minlength=len(models))
            share = [*(m.price / max(k, 1) for m, k in zip(models, count, strict=True)), 0.0]
            worth = self.unary(models)[label, np.arange(len(label))] + np.array(share)[label]
            poor = np.flatnonzero(worth > options.poor * self.single)
            if len(poor) < options.ring_group:
                break
            near = nearest(self.apart[poor], options.ring_group)[1]
            seeds = np.unique(np.linspace(0, len(poor) - 1, options.ring_seeds).astype(np.int64))
            fits = [fit("torus", self.contacts.select(poor[near[k]]), options.fit) for k in seeds]
            free = np.ones(len(label), dtype=bool)
            tried = [
                self._followed(found.shape, 1.0 if found.convex else -1.0, free, worth)
                for found in fits
                if isinstance(found, Fit) and found.chi2 < options.plausible * max(found.dof, 1)
            ]
            good = [found for found in tried if found is not None and found[0] > 0]
            if not good:
                break
            models, label = self.thinned([*models, max(good, key=lambda found: found[0])[1]], None)
        return models, label

    def _followed(
        self, shape: Shape, sign: float, free: Bools, worth: Floats
    ) -> tuple[float, Model, Ints] | None:
        """What a shape gains once fitted to the connected contacts that it explains for less than `worth`."""
        cost = 0.5 * self.felt.chi2(shape, sign)
        model = None
        for _ in range(2):
            mine = self._explained(cost, free, worth)
            if len(mine) < 2:
                return None
            found = refit(shape, sign > 0, self.contacts.select(mine), self.options.fit)
            if not isinstance(found, Fit) or not self.usable(found.shape):
                return None
            shape, sign = found.shape, 1.0 if found.convex else -1.0
            model = self.model(found, mine)
            cost = 0.5 * self.felt.chi2(shape, sign)
        mine = self._explained(cost, free, worth)
        if model is None or len(mine) < 2:
            return None
        return float((worth - cost)[mine].sum()) - model.price, model, mine

    def _explained(self, cost: Floats, free: Bools, worth: Floats) -> Ints:
        return heaviest_part(free & (cost < worth), worth - cost, self.links)

    def labels(self, models: list[Model], start: Ints | None = None) -> Ints:
        """(n,) the face of each contact, as the energy asks."""
        return self._labeled(self.unary(models), start)

    def _labeled(self, cost: Floats, start: Ints | None = None) -> Ints:
        return labeled(cost, self.links, start, self.options.labels)

    def refitted(self, models: list[Model], label: Ints, every_kind: bool) -> tuple[list[Model], Ints]:
        """Each face fitted to its contacts anew, those without enough gone; and labels."""
        out: list[Model] = []
        for k, model in enumerate(models):
            mine = np.flatnonzero(label == k)
            if len(mine) < 2:
                continue
            best = self.best(mine, [model], tuple(KINDS) if every_kind else ())
            if best is not None:
                out.append(best)
        return out, self.labels(out)

    def thinned(self, models: list[Model], label: Ints | None) -> tuple[list[Model], Ints]:
        """Without the faces whose contacts others explain nearly as well."""
        cost, n = self.unary(models), np.arange(len(self.single))
        label = self._labeled(cost) if label is None else label
        while models:
            saved = []
            for k, model in enumerate(models):
                mine = n[label == k]
                others = np.delete(cost[:, mine], k, axis=0).min(axis=0)
                saved.append(model.price - float((others - cost[k, mine]).sum()))
            worst = int(np.argmax(saved))
            if saved[worst] <= 0:
                return models, label
            models, cost = [m for k, m in enumerate(models) if k != worst], np.delete(cost, worst, axis=0)
            label = self._labeled(cost)
        return models, label

    def merged(self, models: list[Model], label: Ints) -> tuple[list[Model], Ints]:
        """With neighbors made one where one face costs less than two."""
        changed = True
        refused: set[tuple[int, int]] = set()
        while changed:
            changed = False
            for a, b in self._neighbors(label, len(models)):
                key = (id(models[a]), id(models[b]))
                if key in refused:
                    continue
                one = self._joined(models[a], models[b], label, a, b)
                if one is None:
                    refused.add(key)
                    continue
                label = np.where(label == b, a, label)
                label = np.where(label > b, label - 1, label)
                models = [one if k == a else m for k, m in enumerate(models) if k != b]
                changed = True
                break
        return models, self.labels(models, label)

    def _neighbors(self, label: Ints, count: int) -> list[tuple[int, int]]:
        rows, columns = self.links.nonzero()
        a, b = label[rows], label[columns]
        both = (a >= 0) & (b > a)
        keys, often = np.unique(a[both] * count + b[both], return_counts=True)
        return [(int(k // count), int(k % count)) for k in keys[np.argsort(-often, kind="stable")]]

    def _joined(self, first: Model, second: Model, label: Ints, a: int, b: int) -> Model | None:
        mine = np.flatnonzero((label == a) | (label == b))
        return self.best(
            mine, [first, second], _QUICK, first.cost + second.cost + self.options.labels.coupling
        )

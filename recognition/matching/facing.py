"""Contacts whose normals point into the object, or lie in a hollow of it (`primitives.facing`), matched both ways.

The two are weighed against each other by how probable the contacts are either way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.arrays import frozen
from recognition.matching.belief import Belief
from recognition.matching.evidence import Evidence


def turned(evidence: Evidence) -> Evidence:
    """The same with all normals turned round."""
    return replace(evidence, contacts=replace(evidence.contacts, normals=frozen(-evidence.contacts.normals)))


def either(as_given: Belief, turned_round: Belief, prior: float) -> Belief:
    """Both beliefs together, where `prior` is how often normals point in."""
    odds = turned_round.log_evidence - as_given.log_evidence + np.log(prior / (1.0 - prior))
    inward = float(1.0 / (1.0 + np.exp(-np.clip(odds, -700.0, 700.0))))
    parts = [(b, p) for b, p in ((as_given, 1.0 - inward), (turned_round, inward)) if p > 0.0]
    hypotheses = [
        replace(h, log_weight=h.log_weight + float(np.log(p))) for b, p in parts for h in b.hypotheses
    ]
    names = {name: sum(p * b.probabilities[name] for b, p in parts) for name in as_given.probabilities}
    ranked = sorted(hypotheses, key=lambda h: -h.log_weight)
    log_evidence = np.logaddexp(
        as_given.log_evidence + np.log1p(-prior), turned_round.log_evidence + np.log(prior)
    )
    return Belief(tuple(ranked), names, float(log_evidence), inward)

"""Whether the normals of contacts point out of the object, as they should, or into it, as forces do.

For every point c, and every closed surface of area A round a volume V, the mean of (p - c) . n over the surface is
3 V / A (divergence theorem), so that contacts all round whose normals point in have it below zero, whatever the
object; those of one side nearly always.  A hollow felt from within looks the same: so both are matched there, and
weighed against each other by how probable the contacts are either way.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from primitives.arrays import frozen
from recognition.matching.belief import Belief
from recognition.matching.evidence import Evidence

_SIGMAS = 3.0  # below zero, that noise does not explain
_SLIGHT = 0.02  # of the contacts' distances from their middle, as good as zero where noise is not known


def may_face_in(evidence: Evidence) -> bool:
    """Whether the sum of (p - c) . n, with c the middle of the contacts, is below zero."""
    contacts = evidence.contacts
    felt = contacts.has_normal
    if not felt.any():
        return False
    arms, normals = contacts.points[felt] - contacts.points[felt].mean(axis=0), contacts.normals[felt]
    away = np.linalg.norm(arms, axis=1)
    noise = _SLIGHT * float(away.sum())
    if evidence.scale_known:
        turned_by = away * contacts.normal_sigma[felt]
        noise = _SIGMAS * float(np.sqrt((contacts.sigma[felt] ** 2 + turned_by**2).sum()))
    return bool((arms * normals).sum() < -noise)


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

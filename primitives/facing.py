"""Whether the normals of contacts point out of the object, as they should, or into it, as forces do.

For every point c, and every closed surface of area A round a volume V, the mean of (p - c) . n over the surface is
3 V / A (divergence theorem), so that contacts all round whose normals point in have it below zero, whatever the
object; those of one side nearly always.  A hollow felt from within looks the same.
"""

from __future__ import annotations

import numpy as np

from primitives.evidence import Contacts

_SIGMAS = 3.0  # below zero, that noise does not explain
_SLIGHT = 0.02  # of the contacts' distances from their middle, as good as zero where noise is not known


def may_face_in(contacts: Contacts, noise_known: bool) -> bool:
    """Whether the sum of (p - c) . n, with c the middle of the contacts, is below zero."""
    felt = contacts.has_normal
    if not felt.any():
        return False
    arms, normals = contacts.points[felt] - contacts.points[felt].mean(axis=0), contacts.normals[felt]
    away = np.linalg.norm(arms, axis=1)
    noise = _SLIGHT * float(away.sum())
    if noise_known:
        turned_by = away * contacts.normal_sigma[felt]
        noise = _SIGMAS * float(np.sqrt((contacts.sigma[felt] ** 2 + turned_by**2).sum()))
    return bool((arms * normals).sum() < -noise)

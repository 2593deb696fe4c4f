"""The end of every rival: poses refined by point-to-plane ICP on the exact surface, the least residual first."""

from __future__ import annotations

import numpy as np

from models.library import Entry
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import inverse, pose
from recognition.matching.align import refine
from recognition.matching.facets import facets_of

_FAR = 5.0  # [mm] a residual counts no more


def by_residual(entry: Entry, contacts: Contacts, starts: Floats, wider: float = 8.0) -> tuple[float, Floats]:
    """Mean distance [mm] and world_from_object of the best of (k, 3, 4) object_from_world."""
    felt = contacts.has_normal
    normals = np.where(felt[:, None], contacts.normals, 0.0)
    done = refine(
        np.ascontiguousarray(starts), np.ascontiguousarray(contacts.points), np.ascontiguousarray(normals),
        felt, np.array(contacts.sigma), np.array(contacts.normal_sigma), np.ones(len(contacts)),
        facets_of(entry.solid.body), wider,
    )  # fmt: skip
    off = np.minimum(done.distances, _FAR).mean(axis=1)
    k = int(np.argmin(off))
    return float(off[k]), inverse(pose(done.poses[k][:, :3], done.poses[k][:, 3]))

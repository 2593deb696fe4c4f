"""How right a segmentation is: every true face with a contact is paired with at most one found face.

With I(k, j) the intersection over union of their contacts, and the pairing that makes its sum greatest (Kuhn and
Munkres)::

    instance mIoU = sum of I over the pairs / number of true faces,

and the shape accuracy is the share of contacts whose found face has the kind of their true one; a contact in no
found face counts as wrong in both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from primitives.arrays import Ints


def instance_miou(true: Ints, found: Ints) -> float:
    """Of (n,) labels; -1 in `found` is no face."""
    faces, mine = np.unique(true, return_inverse=True)
    segments = np.unique(found[found >= 0])
    both = np.zeros((len(faces), len(segments)))
    for j, segment in enumerate(segments):
        both[:, j] = np.bincount(mine[found == segment], minlength=len(faces))
    size = np.bincount(mine)[:, None] + np.array([(found == s).sum() for s in segments])[None] - both
    share = both / np.maximum(size, 1)
    return float(share[linear_sum_assignment(-share)].sum() / len(faces))


def shape_accuracy(true: Ints, kinds: Sequence[str], found: Ints, found_kinds: Sequence[str]) -> float:
    """Share of contacts with the right kind, of those on a face that has one."""
    judged = [k for k in range(len(true)) if kinds[true[k]] != "freeform"]
    right = sum(found[k] >= 0 and found_kinds[found[k]] == kinds[true[k]] for k in judged)
    return right / max(len(judged), 1)

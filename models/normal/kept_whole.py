"""A tree in few digits that draws no more bodies: rounding may part two that end flush with one another."""

import numpy as np

from models.csg import Csg
from models.normal.rounding import rounded
from models.solid import Solid
from primitives.errors import PalpateError

_MORE = 5  # digits that may be needed beyond those which sigma supports


def rounded_whole(tree: Csg, sigma: float) -> Csg:
    """As `rounded` to `sigma` [mm], in more digits where fewer part the tree; as it is where none hold it."""
    whole = _bodies(tree)
    for more in range(_MORE):
        made = rounded(tree, sigma * 0.1**more)
        if _bodies(made) <= whole:
            return made
    return tree


def _bodies(tree: Csg) -> float:
    """How many bodies a tree draws; without end where nothing is left of it."""
    try:
        return Solid.from_csg(tree).parts
    except PalpateError:
        return np.inf

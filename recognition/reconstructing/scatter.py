"""How much the contacts of a cloud scatter, where nobody said.

Where they are many, neighbors lie on one face and tell it.  Few lie so far apart that edges and bends part most
neighbors, which then seem to scatter by millimeters: of them it is asked which sigma makes their faces likeliest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.evidence import Contacts
from primitives.segmentation.scatter import likeliest_sigma
from recognition.sources.noise import estimated_sigma


@dataclass(frozen=True)
class CloudScatterOptions:
    """When neighbors are believed."""

    many: int = 3000  # contacts whose neighbors tell it
    sounded: int = 300  # contacts whose faces are asked
    fewest: int = 8  # that have faces to ask
    largest: float = 0.01  # of the contacts' extent: nobody feels less surely
    least: float = 1e-5  # of it, below which no sigma is believed


def scatter(contacts: Contacts, options: CloudScatterOptions | None = None) -> float:
    """[mm] one standard deviation along the normal."""
    options = options or CloudScatterOptions()
    near = estimated_sigma(contacts)
    extent = float(np.linalg.norm(np.ptp(contacts.points, axis=0))) if len(contacts) else 0.0
    if len(contacts) > options.many or extent <= 0.0:
        return near
    largest = min(near, options.largest * extent)
    if len(contacts) < options.fewest:
        return largest
    order = np.random.default_rng(0).permutation(len(contacts))
    few = contacts.select(order[: options.sounded])
    sigma = likeliest_sigma(few, largest, contacts.points[order])
    return max(sigma, options.least * extent)

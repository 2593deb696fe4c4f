"""How much the contacts of a cloud scatter, where nobody said.

Where they are many, neighbors lie on one face and tell it, but for bends and edges between them, which only add to
it.  Few lie so far apart that edges and bends part most neighbors: of them it is asked which sigma makes their
faces likeliest.  Either is where to begin: the faces found with it tell it better, by what they leave over
(the median of |r| over that of a normal variable, each face's raised by what its parameters took up).  With a
smaller sigma finer faces are found, so they are asked again until it falls no more (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from primitives.segment import segment
from primitives.segmentation.scatter import likeliest_sigma
from recognition.sources.noise import sigma_of_places
from recognition.sources.places import one_a_place

_AMONG = 20_000  # contacts from which neighbors are taken where no normal was felt
_MEDIAN = 0.6745  # of |r| of a unit normal


@dataclass(frozen=True)
class CloudScatterOptions:
    """When neighbors are believed, and how often faces are asked."""

    many: int = 1000  # contacts whose neighbors are where to begin
    sounded: int = 300  # contacts whose faces are asked
    fewest: int = 8  # that have faces to ask
    largest: float = 0.01  # of the contacts' extent: nobody feels less surely
    least: float = 1e-5  # of it, below which no sigma is believed
    rounds: int = 6  # times that faces are found
    falls: float = 1.2  # factor by which sigma falls while it is not settled


def scatter(contacts: Contacts, options: CloudScatterOptions | None = None) -> float:
    """[mm] one standard deviation along the normal."""
    options = options or CloudScatterOptions()
    contacts = one_a_place(contacts)
    near = sigma_of_places(contacts)
    extent = float(np.linalg.norm(np.ptp(contacts.points, axis=0))) if len(contacts) else 0.0
    if extent <= 0.0:
        return near
    largest, least = min(near, options.largest * extent), options.least * extent
    if len(contacts) < options.fewest:
        return largest
    order = np.random.default_rng(0).permutation(len(contacts))
    few, among = contacts.select(order[: options.sounded]), contacts.points[order[:_AMONG]]
    many = len(contacts) > options.many
    sigma = largest if many else likeliest_sigma(few, largest, among)
    for _ in range(options.rounds):
        told = _as_faces_say(few, sigma, among)
        if told is None:
            break
        before, sigma = sigma, max(min(told, largest), least)
        if sigma > before / options.falls:
            break
    return max(sigma, least)


def _as_faces_say(contacts: Contacts, sigma: float, among: Floats) -> float | None:
    """[mm] as contacts lie off the faces that are found with `sigma`; None where no face has contacts to spare."""
    table = replace(contacts, sigma=frozen(np.full(len(contacts), sigma)))
    off = []
    for face in segment(table, among=among):
        count, spent = len(face.rows), face.fit.shape.dof
        if count > spent:
            away = np.abs(face.fit.shape.signed_distance(table.points[face.rows]))
            off.append(away * np.sqrt(count / (count - spent)))
    return float(np.median(np.concatenate(off))) / _MEDIAN if off else None

"""How curved surfaces are looked for among triangles."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from models.recovery.fits import FacetFitOptions


@dataclass(frozen=True)
class CurvedOptions:
    """How patches are chosen and regions judged."""

    smooth: float = np.deg2rad(32.0)  # [rad] the greatest turn between facets of one curved surface
    alike: float = 6.0  # the greatest ratio of areas between neighbors of one patch
    smoothly: float = 20.0  # and between neighbors that may be of one face
    patches: tuple[int, ...] = (12, 5)  # facets of a patch, the larger tried first
    span: float = 0.3  # [rad] that a patch bends from its seed, of fewer facets a larger one is tried before,
    largest: int = 400  # of so many facets at most
    along: int = 6  # facets of a patch along the longest rims, tried last
    fewest: dict[str, int] = field(
        default_factory=lambda: {"cylinder": 3, "cone": 3, "sphere": 4, "torus": 6}
    )
    few: int = 5  # a region of no more facets needs to be regular or tangent to a neighbor
    regular: float = 1.6  # ratio of widths of regular facets
    gentle: float = np.deg2rad(16.0)  # [rad] the greatest turn between regular facets that are only three
    tangent: float = np.deg2rad(5.0)  # [rad] between a neighbor's normal and the surface's at their rim
    on_circle: tuple[float, float] = (
        0.02,
        0.25,
    )  # spread of normals off a circle, that of sides and of domes
    simpler: float = 0.97  # a simpler shape with this share of the best one's area is preferred
    whole: float = 0.95  # a shape that covers this share of its neighborhood is not challenged
    rounds: int = 5  # of growing and fitting again
    failures: int = (
        12  # patches that may lead nowhere before a neighborhood is given up; and one in 100 facets; in a row
    )
    patient: int = 40  # the most that a large neighborhood adds to them
    failures_late: int = 3  # the same, among facets that a surface found before may explain
    crumbs: int = 10  # surfaces found in a neighborhood, after which it is asked whether they are but crumbs
    crumbs_to_cover: int = 60  # as large as these, that it would take to cover one that is freeform
    crumbs_facets: int = 1500  # of a neighborhood that is asked for crumbs, at least
    slack: float = 1.2  # how far corners may be off where chords were cut, in units of the chords' sag
    together: int = 3  # surfaces that may explain a neighborhood of cut chords
    fit: FacetFitOptions = field(default_factory=FacetFitOptions)

"""A trace with what the face behind its edge did to it taken off.

Rubber that is pressed d deep over an edge of dihedral angle a above 90 degrees still touches the falling face,
for d / tan(180 degrees - a) past the edge.  A tracker fits a sharp edge (its line, the face's depth and slope) by
least squares to what the skin shows; how far outward of the edge that line comes to lie, and by how much the face
seems less deep than it is, follow from fitting the same to the profile that the two faces make (our derivation).
To first order the line lies half of where the falling face is d deep, and the depth is right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from exploration.sensing.response import Response
from primitives.arrays import Floats, frozen
from primitives.evidence import EdgeTrace

SHARP = 0.5 * np.pi  # [rad] of an edge behind which nothing is touched


@dataclass(frozen=True)
class FallingFaceConfig:
    """Where a frame is fitted, and how often the depth is found from what seems so."""

    outside: float = 8.0  # [mm] past the line
    inside: float = 10.0  # [mm] of the face
    step: float = 0.2  # [mm]
    slivers: int = 80  # of a sloping face
    rounds: int = 3


@dataclass(frozen=True)
class Seeming:
    """What a sharp edge that is fitted to a blunter one misses."""

    aside: float  # [mm] the line lies outward of the edge
    shallow: float  # [mm] the face is deeper than it seems


def seeming(
    dihedral: float,
    press: float,
    response: Response,
    width: float,
    config: FallingFaceConfig = FallingFaceConfig(),
) -> Seeming:
    """Of an edge of `dihedral` [rad] beside a face that seems `press` [mm] deep; `width` [mm] of the response."""
    if dihedral <= SHARP:
        return Seeming(0.0, 0.0)
    slope = np.tan(np.pi - dihedral)
    t, depth = np.arange(-config.outside, config.inside, config.step), press
    line = np.array([-0.5 * press / slope, press, 0.0])
    for _ in range(config.rounds):
        falling = _middles(-depth / slope, 0.0, config)
        shown = depth * response.edge(t[:, None] - falling, width).mean(axis=1)

        def missed(p: Floats, shown: Floats = shown) -> Floats:
            return _sharp(t - p[0], p[1], p[2], response, width, config) - shown

        line = least_squares(missed, line).x
        depth *= press / float(line[1])
    return Seeming(-float(line[0]), depth - press)


def _sharp(
    t: Floats, press: float, slope: float, response: Response, width: float, config: FallingFaceConfig
) -> Floats:
    """(n,) [mm] what the skin shows (n,) [mm] inside a sharp edge: a step, and a slope that begins there."""
    face = _middles(0.0, 2.0 * config.inside, config)
    rising = response.edge(t[:, None] - face, width).mean(axis=1)
    out: Floats = press * response.edge(t, width) + 2.0 * config.inside * slope * rising
    return out


def _middles(begin: float, end: float, config: FallingFaceConfig) -> Floats:
    """(`slivers`,) [mm] middles of the equal slivers into which a face is cut."""
    out: Floats = begin + (np.arange(config.slivers) + 0.5) * (end - begin) / config.slivers
    return out


def set_back(
    trace: EdgeTrace, outward: Floats, dihedral: float, press: float, response: Response, width: float
) -> EdgeTrace:
    """A trace with the falling face's part taken off; `outward` (n, 3), `dihedral` [rad], the rest [mm]."""
    if dihedral <= SHARP:
        return trace
    off = seeming(dihedral, press, response, width)
    return replace(trace, points=frozen(trace.points - off.aside * outward + off.shallow * trace.normals))

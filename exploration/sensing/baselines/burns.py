"""Burns, Hanson and Riseman's straight lines (1986), on a tactile image after Muthukrishnan's median.

Gradients by 2 x 2 masks; their directions are put into eight sectors, twice, the second time turned by half a
sector; connected gradients of one sector make a region.  Each gradient votes for the larger of its two
regions, and a region is kept whose own votes are at least half of it.  The line of a region is where the plane
fitted to its depths, weighted by gradient, meets its mean depth.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from exploration.sensing.baselines.muthukrishnan import settled, silhouette
from exploration.sensing.baselines.picture import contrast, line_through
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Bools, Floats, Ints

_EIGHT = np.ones((3, 3))
_SECTORS = 8


@dataclass(frozen=True)
class BurnsConfig:
    """What counts as a line."""

    least: float = 0.10  # of the plateau, per taxel: weaker gradients are none
    fewest: int = 4  # gradients in a line
    support: float = 0.5  # of a region that votes for it
    binary: bool = False  # on the silhouette, as the chain's order has it, rather than on the filtered depths


def burns_lines(image: TactileImage, most: int = 3, config: BurnsConfig | None = None) -> tuple[Line, ...]:
    """Lines of most gradient first."""
    config = config or BurnsConfig()
    share = contrast(image)
    on = silhouette(image) if config.binary else None
    if share is None:
        return ()
    seen = settled(share) if on is None else on.astype(float)
    gx = (seen[:-1, 1:] + seen[1:, 1:] - seen[:-1, :-1] - seen[1:, :-1]) / 2
    gy = (seen[1:, :-1] + seen[1:, 1:] - seen[:-1, :-1] - seen[:-1, 1:]) / 2
    size = np.hypot(gx, gy)
    strong = size > config.least
    regions = [_regions(np.arctan2(gy, gx), strong, shift) for shift in (0.0, 0.5)]
    counts = [np.bincount(r.ravel()) for r in regions]
    first = counts[0][regions[0]] >= counts[1][regions[1]]
    found = []
    for r, count, chosen in zip(regions, counts, (first, ~first), strict=True):
        votes = np.bincount(r[chosen & strong], minlength=len(count))
        kept = np.flatnonzero((votes >= config.support * count) & (count >= config.fewest))
        found += [(float(size[r == k].sum()), r == k) for k in kept if k]
    found.sort(key=lambda pair: -pair[0])
    lines = [_line(image, seen, size, member, strength) for strength, member in found[:most]]
    return tuple(line for line in lines if line is not None)


def _regions(direction: Floats, strong: Bools, shift: float) -> Ints:
    """(rows - 1, columns - 1) number of the region of each gradient; 0 for none."""
    sector = np.floor(direction / (2 * np.pi) * _SECTORS + shift).astype(int) % _SECTORS
    out = np.zeros(direction.shape, dtype=int)
    for s in np.unique(sector[strong]):
        marked = label(strong & (sector == s), _EIGHT)[0]
        out[marked > 0] = marked[marked > 0] + out.max()
    return out


def _line(image: TactileImage, seen: Floats, size: Floats, member: Bools, strength: float) -> Line | None:
    """Plane and mean plane over the taxels that a region's masks cover, weighted by their gradients."""
    weight = np.zeros(seen.shape)
    share = np.where(member, size, 0.0)
    for a in (slice(None, -1), slice(1, None)):
        for b in (slice(None, -1), slice(1, None)):
            weight[a, b] += share
    row, column = np.nonzero(weight)
    w, z = weight[row, column], seen[row, column]
    center = np.array([column @ w, row @ w]) / w.sum()
    mean = float(z @ w / w.sum())
    design = np.stack([column - center[0], row - center[1]], axis=1)
    normal = design.T @ (design * w[:, None])
    if np.linalg.det(normal) < 1e-9:
        return None
    slope = np.linalg.solve(normal, design.T @ ((z - mean) * w))
    return line_through(image, center, center + np.array([-slope[1], slope[0]]), strength)

"""The plane of a flat face whose outline nobody knows: a notched rim, a land between holes, the teeth of a gear.

Where no taxel lies two spreads from every edge, a plane cannot be read off, and no straight line or arc describes
what ends it.  But the picture tells both, for a face either is under a place or is not.  With M the share of each
cell of a fine lattice that the face covers, B the blur of the skin and of the taxels, and r a place of the pad,

    depth = B (M (d + g . r)).

For a given M that is linear in d and g.  For a given plane, depth over plane is the picture of M alone: M is drawn
where a level, at first that picture, exceeds one half, and the level is moved by what the picture so drawn leaves
(our derivation, after Landweber's iteration).  Both in turn; a taxel counts the less, the more an outline that is
a little off would change it.  An edge of two faces or a dome has no such picture and leaves too much, but for one
that bends less than an outline may be off: ask only of frames that no smooth surface explains.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates

from exploration.sensing.frame import TactileImage
from exploration.sensing.response import Response, response_of
from exploration.sensing.surfaces.in_world import in_world
from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts


@dataclass(frozen=True)
class OutlinedPatchConfig:
    """How finely an outline is drawn, and what is flat."""

    finer: int = 4  # cells to a taxel, along each side
    beyond: int = 2  # taxels past the pad's end that are drawn
    sharp: float = 6.0  # share of a cell over its level: an outline is about one cell wide
    rounds: int = 8
    step: float = 0.7  # of what is left, by which the level moves
    deepest: float = 0.97  # quantile of the depths, that is taken for the face's: a taxel may stray
    high: float = 0.5  # of the deepest taxels, beyond which a taxel tells where to begin
    least: float = 0.2  # of these, that a plane is taken for at least, where it leaves the pad
    above: float = 0.9  # share of the weight of those that lie over the plane to begin with
    off: float = 0.15  # [mm] of an outline, as far as a taxel is believed
    systematic: float = 0.02  # of the deepest taxels: what the model leaves out
    seen: float = 0.02  # share of the face, from which a taxel has a say in the misfit
    misfit: float = 1.0  # chi2 per degree of freedom, beyond which it is no flat face
    inside: float = 0.9  # share of the face under a taxel that lies well inside
    taxels: int = 12  # of these at least,
    narrow: float = 1.1  # [mm] and the least standard deviation of their places, along the narrower axis


@dataclass(frozen=True)
class OutlinedPatch:
    """A plane, and where the face lies on it."""

    plane: Floats  # (3,) depth [mm] at the pad's middle, and its slopes along x and y
    covariance: Floats  # (3, 3)
    inner: Bools  # (rows, columns) taxels well inside the face

    def contacts(self, world_from_sensor: Floats, touch: int, stroke: int, sensor: int) -> Contacts:
        """Four contacts whose own plane fit has the covariance of this one."""
        spread, cross = self.covariance[1:, 1:], self.covariance[1:, 0]
        center = -np.linalg.solve(spread, cross)
        variance = float(self.covariance[0, 0] + cross @ center)
        slopes, axes = np.linalg.eigh(spread)
        arms = np.sqrt(2.0 * variance / slopes) * axes
        at = center + np.concatenate([arms.T, -arms.T])
        return in_world(
            at,
            self.plane[0] + at @ self.plane[1:],
            np.tile(self.plane[1:], (4, 1)),
            2.0 * np.sqrt(variance),
            2.0 * float(np.sqrt(slopes[-1])),
            world_from_sensor,
            touch,
            stroke,
            sensor,
        )


def outlined_patch(
    image: TactileImage, config: OutlinedPatchConfig = OutlinedPatchConfig()
) -> OutlinedPatch | None:
    """The flat face that a frame shows; None where it shows no such thing, or too little of it."""
    array, living = image.array, np.isfinite(image.sigma)
    if not living.any():
        return None
    depth = np.where(living, image.depth, 0.0)
    most = float(np.quantile(depth[living], config.deepest))
    high = living & (depth > config.high * most)
    if high.sum() < config.taxels:
        return None
    rows = np.stack([np.ones(depth.shape), *np.meshgrid(array.x, array.y)], axis=-1)
    plane = _over(rows[high], depth[high], config)
    lattice = _Lattice.under(image, config)
    noise = np.hypot(np.where(living, image.sigma, np.inf), config.systematic * most)
    nearest = tuple(distance_transform_edt(~living, return_distances=False, return_indices=True))
    level: Floats | None = None
    for _ in range(config.rounds):
        above = np.maximum(rows @ plane, config.least * most)
        level = lattice.finer((depth / above)[nearest]) if level is None else level
        seen = lattice.seen(np.clip(config.sharp * (level - 0.5) + 0.5, 0.0, 1.0))
        steep = np.hypot(*np.gradient(seen[..., 0], array.pitch[1], array.pitch[0]))
        weight = 1.0 / np.hypot(noise, config.off * above * steep)
        weighed = (seen * weight[..., None]).reshape(-1, 3)
        plane = np.linalg.lstsq(weighed, (depth * weight).ravel(), rcond=None)[0]
        left = np.where(living, depth - seen @ plane, 0.0)
        level = level + config.step * lattice.finer(left / above)
    counts = living & ((seen[..., 0] > config.seen) | (depth > 4.0 * noise))
    misfit = float(((left * weight)[counts] ** 2).sum()) / max(int(counts.sum()) - 3, 1)
    inner = living & (seen[..., 0] > config.inside)
    if misfit > config.misfit or inner.sum() < config.taxels:
        return None
    if float(np.linalg.eigvalsh(np.cov(rows[inner][:, 1:].T))[0]) < config.narrow**2:
        return None
    return OutlinedPatch(plane, np.linalg.inv(weighed.T @ weighed), inner)


@dataclass(frozen=True)
class _Lattice:
    """Fine cells under a pad and a little past its ends."""

    across: Floats  # (columns, fine columns) share of each that a taxel sees, along x
    along: Floats  # (rows, fine rows) the same along y
    x: Floats  # (fine columns,) [mm]
    y: Floats  # (fine rows,) [mm]
    config: OutlinedPatchConfig

    @staticmethod
    def under(image: TactileImage, config: OutlinedPatchConfig) -> "_Lattice":
        """The cells under an image's pad, as its skin blurs them."""
        response, array = response_of(image), image.array
        across, x = _shares(array.x, array.pitch[0], response, float(response.variance[0]), config)
        along, y = _shares(array.y, array.pitch[1], response, float(response.variance[1]), config)
        return _Lattice(across, along, x, y, config)

    def seen(self, share: Floats) -> Floats:
        """(rows, columns, 3) what taxels see of a (fine rows, fine columns) share: of it, and of it by x and y."""
        each = (share, share * self.x, share * self.y[:, None])
        return np.stack([self.along @ one @ self.across.T for one in each], axis=-1)

    def finer(self, picture: Floats) -> Floats:
        """(fine rows, fine columns) of a (rows, columns) picture, between its taxels and past its ends."""
        rows, columns = (_between(n, self.config.finer, self.config.beyond) for n in picture.shape)
        return np.asarray(rows @ picture @ columns.T)


def _shares(
    at: Floats, pitch: float, response: Response, variance: float, config: OutlinedPatchConfig
) -> tuple[Floats, Floats]:
    """(n, cells) share of each that taxels `at` (n,) places see along an axis, and the cells' (cells,) middles."""
    past = (0.5 + config.beyond) * pitch
    ends = np.linspace(at[0] - past, at[-1] + past, (len(at) + 2 * config.beyond) * config.finer + 1)
    edge = response.edge(ends - at[:, None], float(np.sqrt(variance)))
    return np.diff(edge, axis=1), 0.5 * (ends[1:] + ends[:-1])


@lru_cache(maxsize=32)
def _between(n: int, finer: int, beyond: int) -> Floats:
    """(cells, n) what n values in a row are at the cells between and past them, by cubic splines."""
    at = (np.arange((n + 2 * beyond) * finer) + 0.5) / finer - 0.5 - beyond
    return np.stack(
        [map_coordinates(one, [np.clip(at, 0.0, n - 1.0)], order=3, mode="nearest") for one in np.eye(n)],
        axis=1,
    )


def _over(rows: Floats, depth: Floats, config: OutlinedPatchConfig) -> Floats:
    """(3,) the plane that most of the (n,) depths lie under: what an edge blurs is less deep than the face."""
    weight: Floats = np.ones(len(depth))
    plane: Floats = np.zeros(3)
    for _ in range(25):
        plane = np.asarray(np.linalg.lstsq(rows * weight[:, None], depth * weight, rcond=None)[0])
        weight = np.sqrt(np.where(depth > rows @ plane, config.above, 1.0 - config.above))
    return plane

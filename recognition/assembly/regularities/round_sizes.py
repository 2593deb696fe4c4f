"""Sizes that are round numbers, all together: then the designer drew them so.

One size is near a round number by chance; many that are well known are not.  Of a part drawn in millimeters a
share of the sizes is on each of some grids, from coarse to fine, and the rest on none.  On a grid of step g a size
that was measured r off its nearest number, with deviation s, is g N(r; s) times as likely as among sizes drawn at
random.  What all sizes say together decides between millimeters, inches and neither, and what each says whether it
is put on a number (Bayes; our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from primitives.arrays import Floats
from primitives.shapes import Cylinder, Plane, Shape, Sphere
from recognition.assembly.regularities.relation import Constraint, Proposal, Relation
from recognition.assembly.regularities.state import State

Grids = tuple[tuple[float, float], ...]  # [mm] steps, and the share of sizes on each

_METRIC: Grids = ((1.0, 0.5), (0.5, 0.25), (0.25, 0.05), (0.1, 0.15))
_INCHES: Grids = ((25.4 / 8, 0.3), (25.4 / 16, 0.35), (25.4 / 32, 0.2), (25.4 / 64, 0.1))


@dataclass(frozen=True)
class GridConfig:
    """When sizes are round."""

    systems: tuple[Grids, ...] = (_METRIC, _INCHES)
    none: float = 0.05  # of the sizes of such a part, that are on no grid
    odds: float = 9.0  # [nats] that all sizes together must say for it
    sure: float = 0.9  # that a size is a number, to be put there
    floor: float = 1e-3  # [mm] no size is known better
    own: float = 0.05  # of a size's variance, that is left where those before it are known, if it has a vote


@dataclass(frozen=True)
class _Size:
    faces: tuple[int, ...]
    of: Constraint  # (1,) the size [mm]
    value: float
    sigma: float
    slope: Floats  # (d,)


def put_on_grid(state: State, config: GridConfig | None = None) -> None:
    """Put the sizes of a state on the round numbers that explain them best, if any do."""
    config = config or GridConfig()
    sizes = _new_ones(state, [size for size in _sizes(state, config) if size.value > config.floor], config)
    told = [[_densities(size, grids) for size in sizes] for grids in config.systems]
    odds = [sum(np.log(sum(d.values()) + config.none) for d in of_each) for of_each in told]
    best = int(np.argmax(odds))
    if not sizes or odds[best] < config.odds:
        return
    put = list[tuple[Proposal, Relation]]()
    for size, density in zip(sizes, told[best], strict=True):
        number = max(density, key=density.__getitem__, default=0.0)
        if density and density[number] > config.sure * (sum(density.values()) + config.none):
            relation = Relation("round", size.faces, 0.0, size.value, size.sigma, number)
            put.append((Proposal("round", size.faces, _equal(size.of, number)), relation))
            state.put(*put[-1])
    state.polish(sure=False)
    for proposal, relation in put:
        if float(np.abs(state.value(proposal)).max()) > config.floor:
            state.relations.remove(relation)  # not all could be met together


def _new_ones(state: State, sizes: Sequence[_Size], config: GridConfig) -> list[_Size]:
    """Sizes that do not follow from those before them, as the height of a corner's axis does from its radius."""
    found, left = list[_Size](), state.posterior
    for size in sizes:
        gain = left @ size.slope
        variance = float(size.slope @ gain)
        if variance > config.own * max(size.sigma**2 - config.floor**2, 1e-12):
            found.append(size)
            left = left - np.outer(gain, gain) / variance
    return found


def _densities(size: _Size, grids: Grids) -> dict[float, float]:
    """Round numbers near a size, and how much likelier each is than a size drawn at random."""
    out = dict[float, float]()
    for step, share in grids:
        number = round(step * round(size.value / step), 9)
        if number > 0.0:
            off = (size.value - number) / size.sigma
            density = share * step * float(np.exp(-0.5 * off**2)) / (np.sqrt(2.0 * np.pi) * size.sigma)
            out[number] = out.get(number, 0.0) + density
    return out


def _sizes(state: State, config: GridConfig) -> list[_Size]:
    """Diameters, each once, and steps from plane to plane or axis along every direction that planes face."""
    shapes, out = state.shapes(), list[_Size]()
    said = {i for group in (*state.groups("equal radius"), *state.groups("coincident")) for i in group[1:]}
    for i, shape in enumerate(shapes):
        if isinstance(shape, Cylinder | Sphere) and i not in said:
            out.append(_size(state, (i,), _diameter, config))
    led = set[int]()
    for lead, plane in enumerate(shapes):
        if not isinstance(plane, Plane) or lead in led:
            continue
        height = {i: float(shape.anchor @ plane.normal) for i, shape in enumerate(shapes)}
        level = [i for i, shape in enumerate(shapes) if i != lead and _level(state, lead, i, shape)]
        flats = sorted([lead, *(i for i in level if isinstance(shapes[i], Plane))], key=height.__getitem__)
        led |= set(flats)
        out += [_step(state, below, above, config) for below, above in pairwise(flats)]
        for i in level:
            if not isinstance(shapes[i], Plane):
                out.append(
                    _step(state, min(flats, key=lambda flat: abs(height[flat] - height[i])), i, config)
                )
    return out


def _level(state: State, lead: int, i: int, shape: Shape) -> bool:
    """Whether a face has one height over a plane."""
    if isinstance(shape, Plane):
        return state.has("parallel", (lead, i))
    return isinstance(shape, Sphere) or (
        isinstance(shape, Cylinder) and state.has("perpendicular", (lead, i))
    )


def _step(state: State, flat: int, other: int, config: GridConfig) -> _Size:
    """From a plane to another that is parallel, or to an axis or a center."""
    rise = float((state.shape(other).anchor - state.shape(flat).anchor) @ state.shape(flat).direction)

    def height(a: Plane, b: Shape) -> Floats:
        return np.array([np.copysign(1.0, rise) * float((b.anchor - a.anchor) @ a.normal)])

    return _size(state, (flat, other), height, config)


def _size(state: State, faces: tuple[int, ...], of: Constraint, config: GridConfig) -> _Size:
    value, slope = state.value_and_slope(faces, of)
    sigma = float(np.sqrt(max(float((slope @ state.posterior @ slope.T)[0, 0]), 0.0)))
    return _Size(faces, of, float(value[0]), float(np.hypot(sigma, config.floor)), slope[0])


def _diameter(shape: Cylinder | Sphere) -> Floats:
    return np.array([2.0 * shape.radius])


def _equal(of: Constraint, size: float) -> Constraint:
    return lambda *shapes: of(*shapes) - size

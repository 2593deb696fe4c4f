"""Curved surfaces, one after another: a patch of facets, the shapes that fit it, as far as each can grow.

The simplest shape wins unless another explains more area.  Facets are taken by the surface that was found first;
large regular neighborhoods are looked at first.

What counts as curved and not as a prism, where triangles alone cannot say: neighbors turn by at most `smooth`
(a twelve-sided hole is round, an octagon is not), and a few facets that are not tangent to anything must be
of like width, and four of them unless they turn gently.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from models.recovery.coaxial import coaxial
from models.recovery.convincing import convincing
from models.recovery.curved_options import CurvedOptions
from models.recovery.fits import cut_reach, depth, evidence, fit_facets, refit_facets
from models.recovery.grow import Mesh, Reach, grow
from models.recovery.patches import patch_round, patches
from models.recovery.turned import axis_of
from primitives.arrays import Bools, Floats, Ints
from primitives.fit import NoFit
from primitives.shapes import Shape


@dataclass(frozen=True)
class Region:
    """Facets on one curved surface."""

    shape: Shape
    convex: bool
    facets: Ints
    reach: Reach


def find_curved(mesh: Mesh, taken: Bools, noise: float, options: CurvedOptions) -> list[Region]:
    """Disjoint regions whose corners are on their surface but for `noise` [mm], in the order of finding."""
    free = ~taken
    found: list[Region] = []
    for hood in neighborhoods(mesh, free, options.alike, options):
        for region in in_neighborhood(mesh, hood, free, noise, 0.0, options, found):
            found.append(region)  # noqa: PERF402  the next is looked for about the axes of those before
    return found


def neighborhoods(mesh: Mesh, free: Bools, ratio: float, options: CurvedOptions) -> list[Ints]:
    """Sets of free facets that hang together by links of like facets, the largest area first."""
    first, second = alike(mesh, ratio, options.smooth)
    both = free[first] & free[second]
    n = len(mesh.flats)
    links = (np.ones(int(both.sum()), dtype=bool), (first[both], second[both]))
    group = connected_components(coo_array(links, shape=(n, n)), False)[1]
    order = np.argsort(group, kind="stable")
    hoods = np.split(order, np.flatnonzero(np.diff(group[order])) + 1)
    hoods = [hood for hood in hoods if len(hood) >= 3]
    return sorted(hoods, key=lambda hood: -float(mesh.flats.area[hood].sum()))


def in_neighborhood(
    mesh: Mesh,
    hood: Ints,
    free: Bools,
    noise: float,
    slack: float,
    options: CurvedOptions,
    found: Sequence[Region] = (),
) -> Iterator[Region]:
    """Regions from seeds in one neighborhood, larger facets first; marks what they take as no longer free.

    Facets whose corners a cut may have moved come after others, and those it may have left beside a region last.
    What was `found` before has axes about which there may be more, and so may the whole neighborhood.
    """
    tried, covered = np.zeros((2, len(free)), dtype=bool)
    ordered = hood[np.lexsort((-mesh.flats.area[hood], _near_rim(mesh, hood)[hood]))].tolist()
    patience = options.failures + min(len(hood) // 100, options.patient)
    left, areas = float(patience), list[float]()
    turned, whole = axis_of(mesh, hood), float(mesh.flats.area[hood].sum())
    for seed, late in ((seed, late) for late in (False, True) for seed in ordered):
        if not free[seed] or tried[seed] or covered[seed] != late:
            continue
        if late:
            left = min(left, options.failures_late)
        axes = [(r.shape.anchor, r.shape.direction) for r in found if r.shape.kind != "sphere"]
        axes += [] if turned is None else [turned]
        region = _from_seed(mesh, seed, hood, free, noise, slack, options, axes)
        if region is not None:
            free[region.facets] = False
            reach = cut_reach(mesh, region.shape, region.facets, region.reach, noise)
            covered[grow(mesh, region.shape, region.convex, region.facets, free, reach)] = True
            left = patience if len(region.facets) > 2 * options.patches[0] else left - 0.25
            areas.append(float(mesh.flats.area[region.facets].sum()))
            yield region
            if left <= 0 or _in_crumbs(areas, whole, len(hood), options):
                return
            continue
        tried[patch_round(mesh, seed, free, 5, options)[0]] = True
        left -= 1
        if left <= 0:
            return


def _in_crumbs(areas: Sequence[float], whole: float, facets: int, options: CurvedOptions) -> bool:
    """Whether the surfaces found in a neighborhood of so large a `whole` are too small to be its surfaces.

    On a smooth freeform face small patches of tori fit anywhere.
    """
    if facets < options.crumbs_facets or len(areas) < options.crumbs:
        return False
    return options.crumbs_to_cover * float(np.mean(areas)) < whole


def _near_rim(mesh: Mesh, hood: Ints) -> Bools:
    """(f,) facets at a neighborhood's rim or beside one that is: a boolean may have cut their corners there."""
    second, count = mesh.creases.other, len(mesh.flats)
    first = np.repeat(np.arange(count), np.diff(mesh.creases.start))
    out = ~mesh.thin
    out[hood] = False
    for _ in range(2):
        out = out | (np.bincount(first, out[second], count) > 0)
    return np.asarray(out)


def alike(mesh: Mesh, ratio: float, smooth: float) -> tuple[Ints, Ints]:
    """Pairs of neighbors that may be of one curved surface: a small turn, and areas of at most this ratio."""
    creases, area = mesh.creases, mesh.flats.area
    first = np.repeat(np.arange(len(mesh.flats)), np.diff(creases.start))
    share = area[first] / area[creases.other]
    good = (np.abs(creases.turn) < smooth) & (share < ratio) & (share > 1 / ratio)
    good &= ~mesh.thin[first] & ~mesh.thin[creases.other]
    return first[good], creases.other[good]


def _from_seed(
    mesh: Mesh,
    seed: int,
    hood: Ints,
    free: Bools,
    noise: float,
    slack: float,
    options: CurvedOptions,
    axes: Sequence[tuple[Floats, Floats]],
) -> Region | None:
    around = float(mesh.flats.area[hood[free[hood]]].sum())
    for patch, turn, sag in patches(mesh, seed, free, noise, options):
        if len(patch) < 3:
            return None
        allowed, best = noise + slack * sag / 3, None
        for region in _candidates(mesh, patch, turn, free, allowed, axes, options):
            area = float(mesh.flats.area[region.facets].sum())
            if best is None or best[0] < options.simpler * area:
                best = area, region
            if area > options.whole * around:
                break
        if best is not None:
            return best[1]
    return None


def _candidates(
    mesh: Mesh,
    patch: Ints,
    turn: float,
    free: Bools,
    noise: float,
    axes: Sequence[tuple[Floats, Floats]],
    options: CurvedOptions,
) -> Iterator[Region]:
    """What a patch grows to: as cones and tori about axes that are known, then as any kind that fits it.

    A free fit of a cone to what a cylinder holds creeps towards that cylinder, and is left out.
    """
    straight = False
    for shape, convex in coaxial(mesh, patch, axes, noise):
        if shape.kind in options.fewest and (
            region := _grown(mesh, shape, convex, patch, turn, free, noise, options)
        ):
            straight = straight or _is_cylinder_of(region, patch)
            yield region
    for kind in _possible(mesh.flats.normal[patch], options):
        if straight and kind in ("cylinder", "cone"):
            continue
        fitted = fit_facets(kind, evidence(mesh, patch, turn, noise, options.fit), options.fit)
        if isinstance(fitted, NoFit):
            continue
        if region := _grown(mesh, fitted.shape, fitted.convex, patch, turn, free, noise, options):
            straight = straight or _is_cylinder_of(region, patch)
            yield region


def _is_cylinder_of(region: Region, patch: Ints) -> bool:
    return region.shape.kind == "cylinder" and bool(np.isin(patch, region.facets).all())


def _possible(normals: Floats, options: CurvedOptions) -> list[str]:
    """Kinds whose normals can spread so: on a circle for cylinder and cone, over an area for sphere and torus."""
    spread = np.linalg.svd(normals - normals.mean(axis=0), compute_uv=False)
    share = float(spread[2] / max(spread[0], 1e-12))
    circle, area = share < options.on_circle[1], share > options.on_circle[0]
    return [kind for kind in options.fewest if (circle if kind in ("cylinder", "cone") else area)]


def _grown(
    mesh: Mesh,
    shape: Shape,
    convex: bool,
    patch: Ints,
    turn: float,
    free: Bools,
    noise: float,
    options: CurvedOptions,
) -> Region | None:
    """The region that a patch grows to on the shape that was found from it, which is fitted again meanwhile."""
    off = shape.signed_distance(mesh.vertices[_corner_list(mesh, patch)])
    if float(np.sqrt((off**2).mean())) > 12 * noise:
        return None
    members, last = patch, 0.0
    for _ in range(options.rounds):
        near = np.abs(shape.signed_distance(mesh.vertices[_corner_list(mesh, members)]))
        loose = float(np.clip(3 * np.sqrt((near**2).mean()), 3 * noise, 12 * noise))
        sag = float(np.quantile(depth(mesh, shape, members), 0.9))
        reach = Reach(loose, 2.5 * sag + 3 * noise, min(1.3 * turn + 0.02, 0.45), options.smooth)
        grown = np.sort(grow(mesh, shape, convex, members, free, reach))
        if len(grown) < options.fewest[shape.kind]:
            return None
        area = float(mesh.flats.area[grown].sum())
        if abs(area - last) < 1e-9 * area:
            break
        members, last = grown, area
        again = refit_facets(shape, convex, evidence(mesh, members, turn, noise, options.fit), options.fit)
        if isinstance(again, NoFit):
            return None
        shape = again.shape
    reach = replace(reach, corner=3 * noise)
    members = np.sort(grow(mesh, shape, convex, members, free, reach))
    members = members[free[members]]
    if not convincing(shape.kind, mesh, shape, convex, members, turn, options):
        return None
    return Region(shape, convex, members, reach)


def _corner_list(mesh: Mesh, facets: Ints) -> Ints:
    start = mesh.flats.start
    return np.concatenate([mesh.flats.corners[start[f] : start[f + 1]] for f in facets])

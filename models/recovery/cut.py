"""Surfaces whose chords were cut, so that their corners no longer lie on them.

Cylinders and cones show in the planes of their sides, to rounding.  Spheres and tori are looked for with corners
off by up to a chord's sag; at that tolerance an arc fits any short piece of a freeform surface, so they count only
where few of them explain a whole neighborhood, and fewer than cylinders and cones would (each row of a torus's
facets is a cone's).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from models.recovery.convincing import convincing
from models.recovery.curved import (
    Region,
    in_neighborhood,
    neighborhoods,
)
from models.recovery.curved_options import CurvedOptions
from models.recovery.fits import corners_of, depth
from models.recovery.grow import Mesh, Reach, grow
from models.recovery.patches import patch_round
from models.recovery.prismatic import fit_planes
from primitives.arrays import Bools, Ints
from primitives.shapes import Cylinder

_MANY = 24  # facets that no surface fits as a whole by chance


def find_cut(mesh: Mesh, taken: Bools, noise: float, options: CurvedOptions) -> list[Region]:
    """Regions of surfaces among the facets that are not taken."""
    out: list[Region] = []
    free = ~taken
    for hood in neighborhoods(mesh, free, options.smoothly, options):
        sides = _prismatic(mesh, hood, free, noise, options)
        if not (len(sides) == 1 and _explained(mesh, hood, sides, options)):
            whole = _round(mesh, hood, noise, options)
            if _explained(mesh, hood, whole, options) and len(whole) < max(len(sides), options.together + 1):
                sides = whole
            else:
                sides = [region for region in sides if len(region.facets) > options.few]
                rest = np.setdiff1d(hood, np.concatenate([hood[:0], *(region.facets for region in sides)]))
                more = _round(mesh, rest, noise, options) if sides and len(rest) > 2 else []
                sides += more if _explained(mesh, rest, more, options) else []
                sides = sides or _only(mesh, hood, noise, options)
        for region in sides:
            free[region.facets] = False
        out += sides
    return out


def _explained(mesh: Mesh, hood: Ints, regions: list[Region], options: CurvedOptions) -> bool:
    covered = sum(float(mesh.flats.area[region.facets].sum()) for region in regions)
    return covered > options.whole * float(mesh.flats.area[hood].sum())


def _only(mesh: Mesh, hood: Ints, noise: float, options: CurvedOptions) -> list[Region]:
    """The one surface of any kind that explains a neighborhood whose corners were moved, as by decimation.

    Of many facets the whole is fitted first: what is too noisy for a patch may yet be plain.
    """
    one = replace(options, together=1)
    if len(hood) > _MANY:
        one = replace(one, slack=2 * options.slack)
        whole = replace(one, patches=(len(hood),), failures=1, patient=0)
        found = _round(mesh, hood, noise, whole, tuple(options.fewest))
        if _explained(mesh, hood, found, options):
            return found
    found = _round(mesh, hood, noise, one, tuple(options.fewest))
    return found if _explained(mesh, hood, found, options) else []


def _round(
    mesh: Mesh,
    hood: Ints,
    noise: float,
    options: CurvedOptions,
    wanted: tuple[str, ...] = ("sphere", "torus"),
) -> list[Region]:
    """The first few spheres and tori, or other kinds, of a neighborhood."""
    kinds = replace(options, fewest={kind: options.fewest[kind] for kind in wanted})
    inside = np.zeros(len(mesh.flats), dtype=bool)
    inside[hood] = True
    found: list[Region] = []
    for region in in_neighborhood(mesh, hood, inside, noise, options.slack, kinds):
        found.append(region)
        if len(found) == options.together:
            break
    return found


def with_truncated_ends(mesh: Mesh, region: Region, noise: float, options: CurvedOptions) -> Region:
    """The region; from the planes of its sides if these are few, turn evenly, and the outer ones were cut short.

    Any two equal turns have a circle through their four corners, but a wrong one where the ends were cut.
    """
    facets = region.facets[~mesh.thin[region.facets]]
    if region.shape.kind != "cylinder" or not 3 <= len(facets) <= options.few:
        return region
    inside = set(facets.tolist())
    rows = [i for f in inside for i in range(*mesh.creases.around(f).indices(len(mesh.creases.other)))]
    turns = np.abs([mesh.creases.turn[i] for i in rows if int(mesh.creases.other[i]) in inside])
    if len(turns) < 4 or np.ptp(turns) > 0.02 * turns.mean():
        return region
    found = fit_planes(mesh, facets, float(turns.mean()))
    if found is None or not isinstance(found.shape, Cylinder) or found.convex != region.convex:
        return region
    off = found.shape.signed_distance(mesh.vertices[corners_of(mesh, facets)])
    sag = float(depth(mesh, found.shape, facets).max())
    sound = found.touched(mesh, facets, noise).all() and off.max() < 3 * noise and -off.min() < 1.2 * sag
    return replace(region, shape=found.shape) if sound else region


def _prismatic(mesh: Mesh, hood: Ints, free: Bools, noise: float, options: CurvedOptions) -> list[Region]:
    """Cylinders and cones of a neighborhood, from planes."""
    out: list[Region] = []
    inside = np.zeros(len(free), dtype=bool)
    inside[hood] = free[hood]
    tried = np.zeros(len(free), dtype=bool)
    left = options.failures + min(len(hood) // 10, options.patient)
    for seed in hood[np.argsort(-mesh.flats.area[hood])].tolist():
        if tried[seed] or not inside[seed]:
            continue
        patch, turn, _ = patch_round(mesh, seed, inside, 8, options)
        for some in (patch, patch[:3]):
            region = _sides(mesh, some, turn, hood, inside, noise, options)
            if region is not None:
                inside[region.facets] = False
                out.append(region)
                break
        else:
            tried[seed] = True
            left -= 1
            if left == 0:
                break
    return out


def _sides(
    mesh: Mesh, patch: Ints, turn: float, hood: Ints, free: Bools, noise: float, options: CurvedOptions
) -> Region | None:
    members = patch
    for _ in range(options.rounds):
        found = fit_planes(mesh, members, turn) if len(members) >= 3 else None
        if found is None:
            return None
        touched = np.zeros(len(free), dtype=bool)
        touched[hood] = found.touched(mesh, hood, noise)
        sag = float(np.quantile(depth(mesh, found.shape, members), 0.9))
        reach = Reach(
            1.2 * sag + 3 * noise, 2 * sag + 3 * noise, min(0.8 * turn + 0.02, 0.45), options.smooth
        )
        inside = members[touched[members]]
        region = Region(
            found.shape,
            found.convex,
            np.sort(grow(mesh, found.shape, found.convex, inside, free & touched, reach)),
            replace(reach, corner=3 * noise),
        )
        settled = np.array_equal(region.facets, members)
        members = region.facets
        if settled:
            break
    sound = convincing(region.shape.kind, mesh, region.shape, region.convex, members, turn, options)
    return region if sound else None

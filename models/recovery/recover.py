"""Which exact surface every triangle of a closed mesh stands for.

The steps: triangles in one plane become facets (`flats`), facets that meet become a graph (`creases`), curved
surfaces gather the facets that are their chords (`curved`), fragments of one surface join (`joined`), pieces of
freeform faces are given back to them (`fragments`), and of what is left, facets that stand alone are planes and
those that run on smoothly are freeform (`leftover`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from models.body import LabeledSurface
from models.recovery.creases import find_creases
from models.recovery.curved import Region, find_curved
from models.recovery.curved_options import CurvedOptions
from models.recovery.cut import find_cut, with_truncated_ends
from models.recovery.fits import corners_of
from models.recovery.flats import corner_noise, find_flats
from models.recovery.fragments import without_fragments
from models.recovery.grow import Mesh
from models.recovery.joined import joined
from models.recovery.leftover import LeftoverOptions, label_leftover
from models.recovery.wedged import with_wedged
from primitives.arrays import Floats, Ints, frozen
from primitives.shapes import Plane


@dataclass(frozen=True)
class RecoveryOptions:
    """Tolerances; lengths are in units of the diagonal of the mesh's box."""

    flat: float = 2e-5  # from its plane that a corner of a facet may be
    flat_deg: float = 0.5  # [deg] between the normals of triangles of one facet
    curved: CurvedOptions = field(default_factory=CurvedOptions)
    leftover: LeftoverOptions = field(default_factory=LeftoverOptions)


@dataclass(frozen=True)
class Recovered:
    """Surfaces behind the triangles of a mesh."""

    face_of_triangle: Ints  # (t,) index into `surfaces`
    surfaces: tuple[LabeledSurface, ...]  # with no shape where the triangles are freeform


def recover(
    vertices: Floats, triangles: Ints, neighbors: Ints, options: RecoveryOptions | None = None
) -> Recovered:
    """The surfaces of a closed mesh of (v, 3) vertices [mm] and (t, 3) triangles with (t, 3) neighbors."""
    tolerances = options or RecoveryOptions()
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    angle = float(np.deg2rad(tolerances.flat_deg))
    flat = tolerances.flat * size
    flats = find_flats(vertices, triangles, neighbors, flat, flat / 30, angle)
    turn = find_creases(vertices, triangles, neighbors, flats).mean_turn()
    noise = corner_noise(vertices, flats, turn, flat / 30, flat / 3)
    flat = max(flat / 5, 3 * noise)
    flats = find_flats(vertices, triangles, neighbors, flat, noise, angle)
    creases = find_creases(vertices, triangles, neighbors, flats)
    mesh = Mesh(vertices, flats, creases, flats.thin)
    regions: list[Region] = []
    for find in (find_curved, find_cut):
        taken = np.zeros(len(flats), dtype=bool)
        for region in regions:
            taken[region.facets] = True
        regions = joined(mesh, regions + find(mesh, taken, noise, tolerances.curved), noise)
        regions = with_wedged(mesh, regions, noise, tolerances.curved)
    regions = [with_truncated_ends(mesh, region, noise, tolerances.curved) for region in regions]
    regions = without_fragments(mesh, regions, noise, tolerances.leftover)
    regions = [_flattened(mesh, region, tolerances.flat * size, angle) for region in regions]
    labels, surfaces = label_leftover(mesh, regions, flat, tolerances.leftover)
    return Recovered(frozen(labels[flats.of_triangle], np.int64), surfaces)


def _flattened(mesh: Mesh, region: Region, flat: float, angle: float) -> Region:
    """The region; a plane's where its facets lie on one to `flat` [mm] and `angle` [rad].

    A disc or ring whose corners were rounded off its plane fits a very flat cone.
    """
    area, facets = mesh.flats.area[region.facets], region.facets[~mesh.thin[region.facets]]
    normal = area @ mesh.flats.normal[region.facets]
    if not (length := float(np.linalg.norm(normal))) > 0.0:
        return region
    plane = Plane(area @ mesh.flats.center[region.facets] / area.sum(), normal / length)
    level = np.abs(plane.signed_distance(mesh.vertices[corners_of(mesh, region.facets)])).max() < flat
    alike = (mesh.flats.normal[facets] @ plane.normal > np.cos(angle)).all()
    return replace(region, shape=plane, convex=True) if level and alike else region

"""What one frame is: nothing, flat, edge, ridge, corner or curved.

The frame is read as a smooth surface and as one that its lines cut, and the likelier reading stands (`kinds`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, sqrt
from types import MappingProxyType

import numpy as np

from exploration.sensing.cut_readings import (
    Reading,
    as_wall,
    reading_of_lines,
    readings_of_outline,
    rivals,
)
from exploration.sensing.frame import TactileImage
from exploration.sensing.kinds import KINDS, only, probabilities
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.hough import voted_lines
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.lines.outline import BOSS, Outline, find_outline, outline_of
from exploration.sensing.lines.region_fit import RegionFit
from exploration.sensing.lines.single_edge import NOTHING as NO_EDGE
from exploration.sensing.lines.single_edge import first_look
from exploration.sensing.response import response_of
from exploration.sensing.surfaces.flank import DOUBTED, crest_of, flank_of
from exploration.sensing.surfaces.footprint import PLANE, Footprint, fit_footprint
from exploration.sensing.surfaces.local_surface import (
    LocalSurface,
    NoSurface,
    fit_cut,
    ordered_surface,
    surface_of,
)
from exploration.sensing.surfaces.lone_noise import unexplained
from exploration.sensing.surfaces.order import Ordered, order_contact
from exploration.sensing.surfaces.smooth_fit import SmoothContact, fit_dome, held, smooth_contact
from exploration.sensing.surfaces.smooth_shapes import DOME
from primitives.arrays import frozen

UNREADABLE = "the frame holds values that are not finite, or no living taxel"
BLOCK, ALIKE, PLAIN = 2.6, 0.0, 0.5  # [sigma] of blocks, of neighbors and of chi2, that a plain dome leaves
LIKELY = 0.95  # probability of a reading from which its lines are told
SHARPENS = 9.0  # [chi2] that a ridge which sharpens toward an apex must gain on one that does not
UNKNOWN = 5.0  # [chi2] that each unknown more must gain: log of the number of taxels
STRIP = 9.0  # [chi2] that a flat strip must gain on a flank, which claims less
PIN = 19.0  # odds from which a lone rim is that of a flat pin, and no ball, which claims less
UNEXPLAINED = 3.0  # [standard deviations of chi2] of misfit from which the whole outline is looked for


@dataclass(frozen=True)
class Touch:
    """One frame, understood."""

    kind: str  # the likeliest of `KINDS`
    kinds: Mapping[str, float]  # probability of each
    lines: tuple[Line, ...]
    surface: LocalSurface | NoSurface
    force: float  # [N]
    time: float  # [s]
    arcs: tuple[Arc, ...] = ()

    def __bool__(self) -> bool:
        return self.kind != "nothing"


def perceive(image: TactileImage, max_lines: int = 3) -> Touch:
    """Lines, arcs, local surface and kind of a frame."""
    contact = smooth_contact(image)
    if contact is None:
        return _nothing(UNREADABLE, image)
    if not contact:
        return _nothing("nothing is felt above the noise", image)
    verdict, line = first_look(image, response_of(image))
    if line is not None and (face := _sure_face(image, contact, line)) is not None:
        return _touch(image, contact, only("edge"), (line,), face)
    dome = fit_dome(contact)
    if not dome.converged:
        dome = held(contact, dome)
    ordered = order_contact(contact, dome)
    smooth = ordered_surface(image, contact, ordered)
    if (crest := crest_of(image, smooth)) is not None:
        fit, log_odds = crest
        ordered = replace(ordered, shape=DOME, fit=fit, chi2=fit.chi2, evidence=ordered.evidence + log_odds)
        smooth = surface_of(image, contact.mask, fit, True)
    readings: list[Reading] = []
    if verdict != NO_EDGE:
        if crest is not None or not _explained(smooth):
            return _with_outline(image, max_lines, contact, dome, ordered, smooth, (), crest is not None)
        if not _plain(image, dome):
            readings = rivals(image, ordered)
        seen = any(reading.kind == "ridge" for reading in readings)
        wall = None if seen else as_wall(image, ordered)
        readings += [] if wall is None else [wall]
    kinds, stands = probabilities(contact, ordered, smooth, readings)
    if readings and kinds["edge"] + kinds["corner"] >= 0.5:
        return _with_outline(image, max_lines, contact, dome, ordered, smooth, readings)
    if stands is not None and stands.fit is not None and kinds[stands.kind] > LIKELY:
        return _strip_or_flank(image, contact, kinds, outline_of(image, stands.fit), smooth)
    flank = flank_of(image, smooth, smooth.chi2 - SHARPENS)
    return _touch(image, contact, kinds, (), smooth if flank is None else flank)


def _with_outline(
    image: TactileImage,
    max_lines: int,
    contact: SmoothContact,
    dome: Footprint,
    ordered: Ordered,
    smooth: LocalSurface,
    rivals_: Sequence[Reading],
    crest: bool = False,
) -> Touch:
    """A frame that no smooth surface explains, or that edges explain as well."""
    outline = find_outline(image, max_lines, smooth=dome)
    if outline.fit is not None and outline and outline.explains(UNEXPLAINED):
        kinds, stands = probabilities(
            contact, ordered, smooth, [*readings_of_outline(image, outline), *rivals_]
        )
        if stands is None:
            return _touch(image, contact, kinds, (), smooth)
        return _strip_or_flank(image, contact, kinds, outline, smooth, crest)
    if _explained(smooth):
        return _touch(image, contact, probabilities(contact, ordered, smooth, rivals_)[0], (), smooth)
    return _as_far_as_explained(image, max_lines, contact, ordered, smooth, outline)


def _strip_or_flank(
    image: TactileImage,
    contact: SmoothContact,
    kinds: dict[str, float],
    outline: Outline,
    smooth: LocalSurface,
    crest: bool = False,
) -> Touch:
    """A flat face in its outline, or the flank that is felt nearly like it."""
    assert outline.fit is not None
    flank = None
    if len(outline.lines) > 1:
        limit = outline.chi2 + STRIP + UNKNOWN * (contact.depth.size - outline.dof)
        felt = softened(image) if outline.fit.region.signs else image  # what the outline was fitted to
        flank = flank_of(felt, smooth, limit, outline.lines, len(outline.arcs))
    if crest and (flank is None or smooth.chi2 < flank.chi2):
        flank = smooth
    if flank is None or flank.chi2 > outline.chi2 + STRIP + UNKNOWN * (flank.dof - outline.dof):
        doubted = outline.fit.region == BOSS and kinds["edge"] < PIN * kinds["curved"]
        face = smooth if doubted else _flat_face(image, contact, outline.fit)
        return _touch(image, contact, kinds, outline.lines, face, outline.arcs)
    share = 1.0 / (1.0 + exp(min(0.5 * (flank.chi2 - outline.chi2), 50.0)))
    kinds = {k: (1.0 - share) * v for k, v in kinds.items()}
    kinds["curved"] += share
    return _touch(image, contact, kinds, outline.lines if share < 0.5 else (), flank)


def _as_far_as_explained(
    image: TactileImage,
    max_lines: int,
    contact: SmoothContact,
    ordered: Ordered,
    smooth: LocalSurface,
    outline: Outline,
) -> Touch:
    """A frame that neither a smooth surface nor a flat face explains: edges of curved faces, or worse."""
    surface, lines = smooth, voted_lines(image, max_lines)
    readings: list[Reading] = []
    if lines:
        surface, cut = _cut(image, contact, lines, smooth)
        readings = [] if cut is None else [reading_of_lines(image, cut)]
    else:
        wall = as_wall(image, ordered)
        readings = [] if wall is None else [wall]
    if surface.chi2 > DOUBTED * surface.dof:
        flank = flank_of(image, smooth, surface.chi2)
        if flank is not None:
            lines, surface = (), flank
    flat = bool(outline.fit and outline) and outline.chi2 < surface.chi2
    if flat:
        readings += readings_of_outline(image, outline)
    kinds, _ = probabilities(contact, ordered, smooth, readings)
    edged = max(kinds, key=lambda name: kinds[name]) not in ("flat", "curved")
    if flat and edged:
        return _strip_or_flank(image, contact, kinds, outline, smooth)
    if flat or (lines and not edged):
        lines, surface = (), smooth
    return _touch(image, contact, kinds, lines, surface)


def _flat_face(image: TactileImage, contact: SmoothContact, fit: RegionFit) -> LocalSurface:
    """The plane of an outline."""
    p, covariance = np.zeros(6), np.zeros((6, 6))
    p[:3], covariance[:3, :3] = fit.parameters[:3], fit.covariance[:3, :3]
    plane = Footprint(p, covariance, fit.chi2, fit.dof, fit.converged, contact.depth)
    return surface_of(image, contact.mask, plane, False, _FLAT)


def _touch(
    image: TactileImage,
    contact: SmoothContact,
    kinds: dict[str, float],
    lines: tuple[Line, ...],
    surface: LocalSurface,
    arcs: tuple[Arc, ...] = (),
) -> Touch:
    kind = max(KINDS, key=lambda name: kinds[name])
    px, py = image.array.pitch
    force = image.stiffness * px * py * float(np.sum(contact.depth))
    return Touch(kind, MappingProxyType(kinds), lines, surface, force, image.time, arcs)


def _explained(surface: LocalSurface, deviations: float = UNEXPLAINED) -> bool:
    return surface.chi2 < surface.dof + deviations * sqrt(2 * surface.dof)


def _plain(image: TactileImage, dome: Footprint) -> bool:
    """Whether a dome leaves nothing but noise, as not one edge or corner in ten would: no rival need be fitted."""
    greatest, alike = unexplained(dome.residual, image.sigma)
    return greatest < BLOCK and alike < ALIKE and dome.chi2 < dome.dof + PLAIN * sqrt(2 * dome.dof)


def _sure_face(image: TactileImage, contact: SmoothContact, line: Line) -> LocalSurface | None:
    """The flat face beside the only edge of a frame; none where it is not flat after all."""
    start = np.array([line.plateau, 0.0, 0.0, 0.0, 0.0, 0.0, line.angle, line.offset])
    plane = fit_footprint(image, start, np.array([float(line.material_side)]), shape=PLANE)
    face = surface_of(image, contact.mask, plane, False, _FLAT)
    return face if plane.converged and _explained(face) else None


_FLAT = frozen([1.0, 0.0, 0.0, 0.0])


def _nothing(reason: str, image: TactileImage) -> Touch:
    return Touch("nothing", _NOTHING, (), NoSurface(reason), 0.0, image.time)


_NOTHING = MappingProxyType(only("nothing"))


def _cut(
    image: TactileImage, contact: SmoothContact, lines: tuple[Line, ...], smooth: LocalSurface
) -> tuple[LocalSurface, Footprint | None]:
    """The surface that lines cut; the smooth one where their fit fails."""
    plane, dome, orders = fit_cut(image, lines)
    curved = bool(orders[0] < 0.5)
    fit = dome if curved else plane
    if not fit.converged:
        return smooth, None
    return surface_of(image, contact.mask, fit, curved, orders), fit

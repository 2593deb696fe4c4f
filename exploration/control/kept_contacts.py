"""Which frames become contacts, and how far each is trusted.

A frame's noise gives a contact's covariance.  What that leaves out is added by what the frame shows: a surface
alone, one that an edge cuts, one that an unseen edge probably cuts, a contact so narrow or so doubtful that it may
be a flat strip as well as a round flank.  The floors were measured on simulated presses.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_erosion
from scipy.spatial import KDTree
from scipy.special import chdtri

from exploration.control.feel import FeelConfig, Felt, NotTouching, feel
from exploration.devices.guard import Observation
from exploration.sensing.contacts import contacts_of, slid
from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.arc import Arc
from exploration.sensing.surfaces.domed_patch import domed_patch
from exploration.sensing.surfaces.flat_patch import flat_patch
from exploration.sensing.surfaces.local_surface import LocalSurface
from exploration.sensing.surfaces.midline import Midline
from exploration.sensing.surfaces.outlined_patch import outlined_patch
from exploration.sensing.touch import Touch, perceive
from primitives import pose as se3
from primitives.arrays import Bools, Floats, frozen
from primitives.evidence import Contacts


@dataclass(frozen=True)
class TrustConfig:
    """Which frames are good enough to become contacts; the rest only steer."""

    misfit: float = 1.8  # chi2 per degree of freedom of a flat patch,
    chance: float = 1e-3  # or what noise alone exceeds as seldom as this, where so few taxels see it
    curved_misfit: float = 4.0  # of a curved one
    area: float = 15.0  # [response widths^2] in contact
    flat_area: float = 38.0  # [response widths^2] in contact, where the surface is taken for flat
    slender: float = 4.0  # [response widths] across, a flat face may be an edge of two faces that fall off
    crown: float = 6.0  # [response widths] the same of a strip that bends, which may be the crown of a ring
    straight: float = 0.96  # of a strip's width over that of its places, from which it does not bend
    slanting: tuple[float, float] = (
        0.08,
        5.0,
    )  # [rad, response widths] the same of a pad that has not settled
    curvature: float = 0.8  # [1/mm] beyond which the rubber blurs too much
    sure: float = 0.08  # of a curvature beyond `narrow`, its greatest relative deviation
    doubtful: float = 1.5  # misfit of a curved patch from which an unseen edge probably cuts it
    floor: tuple[float, float, float] = (
        0.01,
        0.02,
        0.05,
    )  # [mm] error of a frame that its noise does not show:
    # nothing but surface is seen; an edge cuts it; an unseen edge does
    normal_floor: tuple[float, float, float] = (0.002, 0.04, 0.04)  # [rad] the same for normals
    curved_normal_floor: float = 0.005  # [rad] of a curved patch that no edge cuts
    cut: float = 0.3  # of the slope at its rim, by which a small contact may be turned if unseen edges cut it
    narrow: float = 0.1  # [1/mm] a contact this curved may be a flat strip of two or three taxels
    round: float = 0.9  # probability of being curved, below which it may be such a strip too
    narrow_floor: float = 0.06  # [mm]
    narrow_normal_floor: float = 0.1  # [rad]
    # over the square of the taxels across: error of a cut face at the pad's end, where an edge goes unseen
    ends: tuple[float, float] = (0.2, 0.18)  # [mm, rad]
    # [mm, rad] error of a face whose outline its picture tells: its four contacts err as one
    outlined: tuple[float, float] = (0.03, 0.012)
    rims: tuple[float, ...] = (
        3.0,
        2.0,
    )  # [spreads] along a contact's end, that a patch of any outline leaves out
    unseen: float = 2.5  # [spreads] from the pad's end, beyond which edges that it does not see bend nothing
    turned: float = 0.12  # [rad] of a normal, beyond which a frame lies on an edge and tells of no surface
    wide: float = 0.03  # [mm] of a contact's own error, beyond which the same
    ringed: float = 0.1  # [mm] the same of a ring that is seen whole: an edge has no two circles
    around: float = 6.0  # [rad] of a circle, from which it is seen whole
    eccentric: float = 0.3  # [mm] between the centers of its circles: a pad that leans sees them apart
    domed: float = 0.5  # probability of being curved, below which a dome is an edge that the pad lies astride
    whole: float = 0.9  # of the pad, which a hollow surface fills; less of one is a step that the skin spans
    border: float = 0.6  # [pitches] from the outermost taxels, where the skin's end bends a curved patch


def keep(
    seen: Observation,
    touch: int,
    stroke: int,
    kept: list[Contacts],
    trust: TrustConfig = TrustConfig(),
) -> None:
    """Turn a frame into contacts, where it shows a smooth surface."""
    what = perceive(seen.image)
    surface = what.surface
    where = (seen.world_from_sensor, touch, stroke, seen.sensor)
    floor, normal_floor = trust.floor[0], trust.normal_floor[0]
    ring: Sequence[Arc] = ()
    if isinstance(surface, LocalSurface) and _trusted(surface, seen.image, trust):
        found = contacts_of(what, *where)
        if surface.curved:
            cut = 2 if _misfit(surface) > trust.doubtful else 1 if what.lines else 0
            floor, normal_floor = trust.floor[cut], max(trust.normal_floor[cut], trust.curved_normal_floor)
            rim = float(np.sqrt(0.5 * max(-surface.point[2] * surface.principal[0][1], 0.0)))
            normal_floor = max(normal_floor, trust.cut * rim)
            strip = what.kinds["curved"] < trust.round and bool(what.kinds["corner"] + what.kinds["ridge"])
            if strip or float(surface.principal[0][0]) > trust.narrow:
                floor, normal_floor = trust.narrow_floor, trust.narrow_normal_floor
        else:
            ring = _ring(what, trust)
            middle = Midline.of(surface.mask, seen.image.array)
            bends = middle.drawn_in < trust.straight
            found = _along(middle, found, seen.world_from_sensor) if bends else found
            found = _round(ring, seen, found) if ring else _on(surface.mask, seen, found)
            if not ring and _width(surface, seen.image) < (trust.crown if bends else trust.slender):
                floor, normal_floor = trust.narrow_floor, trust.narrow_normal_floor
            elif what.lines:
                beside = _to_end(surface.mask) ** 2
                floor, normal_floor = np.hypot((floor, normal_floor), np.divide(trust.ends, beside))
    else:
        found, (floor, normal_floor) = _patch(seen, where, trust, what.kinds["curved"] > trust.domed)
    told = (
        len(found)
        and float(found.normal_sigma.max()) < trust.turned
        and float(found.sigma.max()) < (trust.ringed if ring else trust.wide)
    )
    if told:
        sigma, turn = np.hypot(found.sigma, floor), np.hypot(found.normal_sigma, normal_floor)
        kept.append(replace(found, sigma=frozen(sigma), normal_sigma=frozen(turn)))


def _on(mask: Bools, seen: Observation, contacts: Contacts) -> Contacts:
    """Contacts of a flat (rows, columns) mask, those that lie off its taxels moved to the nearest well within.

    Points spread by the mask's covariance lie where nothing was touched, where it is a ring or a corner.
    """
    if not len(contacts):
        return contacts
    array, pose = seen.image.array, seen.world_from_sensor
    places = se3.transform_points(se3.inverse(pose), contacts.points)[:, :2]
    off = np.asarray(KDTree(_taxels(mask, array)).query(places)[0]) > 0.5 * float(np.hypot(*array.pitch))
    within = np.asarray(binary_erosion(mask, border_value=1), dtype=bool)
    inner = _taxels(within if within.any() else mask, array)
    to = np.where(off[:, None], inner[KDTree(inner).query(places)[1]], places)
    return slid(contacts, to, pose) if off.any() else contacts


def _ring(what: Touch, trust: TrustConfig) -> Sequence[Arc]:
    """The two circles of a ring that a frame shows whole; none where it shows something else."""
    if len(what.arcs) != 2 or what.lines or min(arc.span for arc in what.arcs) < trust.around:
        return ()
    one, other = what.arcs
    return what.arcs if np.linalg.norm(one.center - other.center) < trust.eccentric else ()


def _round(ring: Sequence[Arc], seen: Observation, contacts: Contacts) -> Contacts:
    """Contacts of a flat ring between two circles, moved half way between these."""
    center = np.mean([arc.center for arc in ring], axis=0)
    places = se3.transform_points(se3.inverse(seen.world_from_sensor), contacts.points)[:, :2]
    out = (places - center) / np.linalg.norm(places - center, axis=1, keepdims=True)
    return slid(contacts, center + np.mean([arc.radius for arc in ring]) * out, seen.world_from_sensor)


def _taxels(mask: Bools, array: TaxelArray) -> Floats:
    rows, columns = np.nonzero(mask)
    return np.column_stack([array.x[columns], array.y[rows]])


def _to_end(mask: Bools) -> float:
    """How many taxels deep a mask is from an end of the pad that it lies along; inf where it reaches none."""
    sides = [side for side in (mask, mask[::-1], mask.T, mask.T[::-1]) if side[:2].any()]
    return min((float(np.median(s[:, s[:2].any(axis=0)].sum(axis=0))) for s in sides), default=np.inf)


def _along(middle: Midline, contacts: Contacts, pose: Floats) -> Contacts:
    """Contacts of a flat strip that bends, along it: straight ones lie where nothing was felt."""
    places = se3.transform_points(se3.inverse(pose), contacts.points)[:, :2]
    return slid(contacts, middle.bent(places), pose)


def _patch(
    seen: Observation, where: tuple[Floats, int, int, int], trust: TrustConfig, domed: bool
) -> tuple[Contacts, tuple[float, float]]:
    """Contacts of a face of any outline, perhaps a dome, as far inside its rim as it is wide enough for.

    And their floors [mm, rad].
    """
    found = Contacts.of([])
    felt: Felt | NotTouching = NotTouching()
    for rim in trust.rims:
        felt = feel(seen.image, FeelConfig(rim=rim))
        found = _on(felt.inner, seen, flat_patch(seen.image, felt.inner, *where)) if felt else found
        if felt and domed and not len(found):
            found = domed_patch(seen.image, felt.inner, *where)
        if len(found):
            break
    if felt and not len(found):
        inner = felt.inner & _off_border(seen.image, trust.unseen)
        found = _on(inner, seen, flat_patch(seen.image, inner, *where))
    outlined = outlined_patch(seen.image) if felt and not len(found) else None
    if outlined is not None:
        return _on(outlined.inner, seen, outlined.contacts(*where)), trust.outlined
    return found, (trust.floor[0], trust.normal_floor[0])


def _off_border(image: TactileImage, widths: float) -> Bools:
    """(rows, columns) taxels farther than some `widths` from the pad's end, which an edge beyond it bends."""
    array, clear = image.array, widths * image.spread
    x, y = array.x[-1] + 0.5 * array.pitch[0] - clear, array.y[-1] + 0.5 * array.pitch[1] - clear
    inside: Bools = (np.abs(array.y)[:, None] < y) & (np.abs(array.x) < x)
    return inside


def touched_cells(seen: Observation, felt: Felt) -> Floats:
    """(n, 3) world points under the touched taxels."""
    rows, columns = np.nonzero(felt.mask)
    depth = np.maximum(seen.image.depth[rows, columns], 0.0)
    local = np.column_stack([seen.image.array.x[columns], seen.image.array.y[rows], -depth])
    return se3.transform_points(seen.world_from_sensor, local)


def _trusted(surface: LocalSurface, image: TactileImage, trust: TrustConfig) -> bool:
    area = float(surface.mask.sum()) / _taxels_of_a_width(image)
    if surface.curved:
        most = float(np.abs(surface.principal[0]).max())
        doubt = float(np.sqrt(surface.curvature_covariance[[0, 2], [0, 2]].max()))
        sharp = most > trust.curvature or (most > trust.narrow and doubt > trust.sure * most)
        px, py = image.array.pitch
        room = np.array([image.array.x[-1] - trust.border * px, image.array.y[-1] - trust.border * py])
        inside = bool((np.abs(surface.point[:2]) < room).all())
        if _hollow(surface) and float(surface.mask.mean()) < trust.whole:
            return False
        return inside and not sharp and _misfit(surface) < trust.curved_misfit and area >= trust.area
    dof = max(surface.dof, 1)
    most = max(trust.misfit, float(chdtri(dof, trust.chance)) / dof)
    if _misfit(surface) >= most or area < trust.flat_area:
        return False
    tilt, slender = trust.slanting
    return float(np.hypot(*surface.normal[:2])) <= tilt or _width(surface, image) >= slender


def _hollow(surface: LocalSurface) -> bool:
    least, most = np.sort(surface.principal[0])
    return bool(-least > most)


def _width(surface: LocalSurface, image: TactileImage) -> float:
    """[response widths] of what is touched, across its longer extent, which may bend."""
    width = Midline.of(surface.mask, image.array).width
    return float(width / np.sqrt(_taxels_of_a_width(image) * np.prod(image.array.pitch)))


def _taxels_of_a_width(image: TactileImage) -> float:
    """How many taxels lie in the square of the width over which the skin blurs a step."""
    px, py = image.array.pitch
    return (image.spread**2 + (px**2 + py**2) / 24.0) / (px * py)


def _misfit(surface: LocalSurface) -> float:
    return surface.chi2 / max(surface.dof, 1)

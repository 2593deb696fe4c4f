"""Round holes whose two ends differ: counterbores and countersinks.

Two rims on opposite faces that share an axis are of one hole.  Where one is wider, the hole narrows in between.
What stopped an array there tells how: as deep wherever it was stopped, there is a flat ledge; the deeper the
nearer to the axis, a cone that begins at the rim, of depth (R - rho) k.  Where neither is so the hole narrows as
the outside round it does (`sleeves`).  Where that does not, and nothing was felt, it is most often a ledge.  Whose
two widths are those of a screw's head and shank is sunk for such a head, which is as high as the screw is thick
(ISO 4762, DIN 974-1).  Those of a flat head's and its shank make a cone of 90 degrees (ISO 10642), and more so in
a plate too thin for another head; so does any wider mouth in which no array has room, of which that takes the
least away.  Else half way down is nearest to all that may be (our derivation).  The sigma of its contacts does not
say how far off that may be, the warning beside the model does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.inferring.sleeves import narrowing
from exploration.planning.open.holes import Hole
from exploration.planning.open.round_rims import RoundRim, far_end
from exploration.planning.touching.findings import Stopped
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import Face

BY_GUESS = "a round hole is wider at one end; its ledge is taken for half way down"
BY_SCREW = (
    "a round hole is wider at one end, as for a screw's head; its ledge is taken for as deep as such a head"
)
BY_FLAT_HEAD = (
    "a round hole is wider at one end, as for a screw's flat head; it is taken for a cone of 90 degrees"
)
BY_TOUCH = "a round hole is wider at one end; its ledge is where an array was stopped"
BY_OUTSIDE = "a round hole is wider at one end; it narrows where the outside does"
BY_SLOPE = "a round hole is wider at one end; it narrows as an array was stopped in it"
_DOWN = (0.2, 0.5, 0.8)  # of a cone's depth, where its contacts are


@dataclass(frozen=True)
class SteppedHoleConfig:
    """What is made of where an array was stopped."""

    level: float = 0.7  # [mm] between depths at which it was stopped, of one ledge
    slope: float = 1.0  # [mm] from the axis, by which places at least differ that tell a slope
    screw: tuple[float, float] = (1.5, 1.93)  # times as wide as for its shank, that a hole for a head is
    flat: tuple[float, float] = (1.75, 2.2)  # the same of a flat head, where no other has room or is so wide
    room: float = 6.0  # [mm] radius of a mouth that an array has room in
    head: float = 1.93  # radii of the hole for the shank, that it is deep: M5 to M10 come to 1.91 to 1.96
    sigma: float = 0.5  # [mm] at most: what is less sure would be taken for the face round the mouth
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class SteppedHole:
    """A hole that becomes narrower."""

    rims: tuple[RoundRim, RoundRim]  # its wide end, and the other
    holes: tuple[Hole, ...]  # its upright parts
    contacts: Contacts  # of what narrows it, which nobody lay on
    kind: str  # of that: "plane" or "cone"
    why: str


def stepped_holes(
    rims: Sequence[RoundRim],
    guessed: Sequence[RoundRim] = (),
    stopped: Sequence[Stopped] = (),
    faces: Sequence[Face] = (),
    config: SteppedHoleConfig = SteppedHoleConfig(),
) -> list[SteppedHole]:
    """Every hole that becomes narrower; its far end may be one that is only guessed."""
    found = []
    for rim in rims:
        other = far_end(rim, [*rims, *guessed])
        if other is not None:
            own = np.array([(s.off, s.deep) for s in stopped if np.allclose(s.rim, rim.center)]).reshape(
                -1, 2
            )
            found.append(_made(rim, other, own, narrowing(rim, other, faces), config))
    return found


def _made(
    rim: RoundRim,
    other: RoundRim,
    own: Floats,
    outside: tuple[float, float] | None,
    config: SteppedHoleConfig,
) -> SteppedHole:
    far = float((rim.center - other.center) @ rim.axis)
    own = own[(own[:, 1] > 0.0) & (own[:, 1] < far) & (own[:, 0] < rim.radius)]
    wide = rim.radius - other.radius
    beyond = np.inf if outside is None else _beyond(own, rim.radius, wide, outside)
    if len(own) > 1 and np.ptp(own[:, 0]) > config.slope and np.ptp(own[:, 1]) > config.level:
        inward = rim.radius - own[:, 0]
        cone = 0.0, min(wide * float(inward @ own[:, 1] / (inward @ inward)), far)
        if _beyond(own, rim.radius, wide, cone) <= beyond:
            return _coned(rim, other, cone, BY_SLOPE, config)
    ledge_felt = len(own) > 0 and float(np.ptp(own[:, 1])) <= config.level
    if outside is not None and not (ledge_felt and beyond > config.level):
        return _coned(rim, other, outside, BY_OUTSIDE, config)
    low, high = config.screw
    deep, why = (float(np.median(own[:, 1])), BY_TOUCH) if len(own) else (0.5 * far, BY_GUESS)
    least = high if config.head * other.radius < deep else config.flat[0]
    sunk = least * other.radius <= rim.radius < max(config.flat[1] * other.radius, config.room)
    if not len(own) and sunk and wide < far:
        return _coned(rim, other, (0.0, wide), BY_FLAT_HEAD, config)
    if not len(own) and low < rim.radius / other.radius < high and config.head * other.radius < deep:
        deep, why = config.head * other.radius, BY_SCREW
    mouth = Hole(rim.center - 0.5 * deep * rim.axis, rim.axis, rim.radius, deep, rim.sigma)
    middle = replace(rim, center=rim.center - deep * rim.axis, radius=0.5 * (rim.radius + other.radius))
    places, _ = middle.places()
    ledge = Contacts.of(
        places,
        np.tile(rim.axis, (len(places), 1)),
        sigma=min(config.sigma, far / np.sqrt(12.0)),
        normal_sigma=config.normal_sigma,
        touch=NOT_FELT,
    )
    holes = (mouth, _narrow(rim, other, deep, far))
    return SteppedHole((rim, other), holes, ledge, "plane", why)


def _beyond(own: Floats, radius: float, wide: float, depths: tuple[float, float]) -> float:
    """[mm] that (n, 2) places off the axis and depths lie off a cone between two depths, in the mean."""
    foreseen = depths[0] + (radius - own[:, 0]) / wide * (depths[1] - depths[0])
    return float(np.abs(own[:, 1] - foreseen).mean()) if len(own) else 0.0


def _coned(
    rim: RoundRim, other: RoundRim, depths: tuple[float, float], why: str, config: SteppedHoleConfig
) -> SteppedHole:
    """A cone between two depths [mm], which what is as wide as the mouth and what is narrow go on from."""
    far = float((rim.center - other.center) @ rim.axis)
    begins, deep = depths[0], depths[1] - depths[0]
    wide = rim.radius - other.radius
    ring, ways = rim.places()
    looks = deep * -ways + wide * rim.axis
    places = [ring - begins * rim.axis - share * (wide * ways + deep * rim.axis) for share in _DOWN]
    cone = Contacts.of(
        np.concatenate(places),
        np.tile(looks / np.hypot(deep, wide), (len(_DOWN), 1)),
        sigma=min(config.sigma, far / np.sqrt(12.0)),
        normal_sigma=config.normal_sigma,
        touch=NOT_FELT,
    )
    mouth = Hole(rim.center - 0.5 * begins * rim.axis, rim.axis, rim.radius, begins, rim.sigma)
    parts = (mouth, begins > 0.0), (_narrow(rim, other, depths[1], far), depths[1] < far)
    return SteppedHole((rim, other), tuple(hole for hole, there in parts if there), cone, "cone", why)


def _narrow(rim: RoundRim, other: RoundRim, deep: float, far: float) -> Hole:
    """The narrow part, from some depth [mm] behind the wide rim to the other."""
    middle = other.center + 0.5 * (far - deep) * rim.axis
    return Hole(middle, rim.axis, other.radius, far - deep, other.sigma)

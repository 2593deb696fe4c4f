"""Round holes that come out of a face of which nobody saw the rim there.

A look at a hole's rim tells its radius and axis.  Where the flat face that lies behind, and looks the other way,
was found to be missing just where the hole would come out, the hole goes through: that its other rim was not made
out says less than that (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim, aside


@dataclass(frozen=True)
class FarEndsConfig:
    """When a face is missing where a hole would come out."""

    upright: float = 0.98  # least cosine between the face's normal and the hole's axis
    deepest: float = 80.0  # [mm] behind a rim
    within: float = 0.9  # of the radius round the axis, where the face was found missing
    least: int = 3  # such places
    bare: float = 0.5  # of the radius round the axis, where it was touched nowhere
    beside: float = 12.0  # [mm] round the hole, within which the face was touched


# For the other rim of a hole: where nobody felt that it does not come out.
WHERE_TO_LOOK = FarEndsConfig(least=0)


def far_ends(
    rims: Sequence[RoundRim], known: Sequence[KnownFace], config: FarEndsConfig = FarEndsConfig()
) -> list[RoundRim]:
    """Of each rim that was looked at the other end of its hole, in the first face that is missing behind it."""
    found: list[RoundRim] = []
    for rim in (rim for rim in rims if rim.measured):
        ends = [end for own in known if (end := _end(rim, own, config)) is not None]
        found += sorted(ends, key=lambda end: float((rim.center - end.center) @ rim.axis))[:1]
    return found


def _end(rim: RoundRim, own: KnownFace, config: FarEndsConfig) -> RoundRim | None:
    axis = own.side * own.fit.shape.direction if own.fit.kind == "plane" else rim.axis
    slope = float(axis @ rim.axis)
    if slope > -config.upright or not len(own.cells):
        return None
    deep = float((rim.center - own.fit.shape.anchor) @ axis) / slope
    center = rim.center - deep * rim.axis
    touched, missing = aside(own.cells, center, axis), aside(own.free, center, axis)
    gone = int((missing < config.within * rim.radius).sum()) >= config.least
    bare = config.bare * rim.radius < touched.min() < rim.radius + config.beside
    if not (0.0 < deep < config.deepest and gone and bare):
        return None
    return replace(rim, center=center, axis=-rim.axis, face=own.face.id, measured=False)

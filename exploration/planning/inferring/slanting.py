"""Round holes that run slanting into the face that they come out of.

A look at a rim tells where a hole comes out and how wide it is, and not which way it runs: the rim of a slanting
one is hardly longer than wide.  A drill leaves a floor across its way.  So where an array that went in felt a
floor that leans against the mouth, the hole runs along that floor's normal (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from exploration.planning.open.holes import Hole
from exploration.planning.open.round_rims import aside
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class SlantingConfig:
    """What counts as a hole's floor."""

    slant: tuple[float, float] = (0.8, 0.996)  # least and most cosine between its normal and the mouth's axis
    least: int = 5  # contacts that were felt
    inside: float = 1.0  # [mm] past the hole's radius, within which they lie about its axis
    deep: float = 0.5  # of the way that an array went in, at least


def slanting(hole: Hole, faces: Sequence[Face], config: SlantingConfig = SlantingConfig()) -> Hole:
    """The hole along its floor's normal, down to the floor; itself, where no leaning floor was felt."""
    mouth = hole.middle + 0.5 * hole.depth * hole.axis
    for face in faces:
        if not isinstance(face.fit, Fit) or face.fit.kind != "plane":
            continue
        felt = face.contacts.points[face.contacts.touch != NOT_FELT]
        normal = face.fit.shape.direction * (1.0 if face.fit.convex else -1.0)
        low, high = config.slant
        if len(felt) >= config.least and low < float(normal @ hole.axis) < high:
            deep = float((mouth - face.fit.shape.anchor) @ normal)
            within = aside(felt, mouth, normal).max() < hole.radius + config.inside
            if within and deep > config.deep * hole.depth:
                return replace(hole, middle=mouth - 0.5 * deep * normal, axis=normal, depth=deep)
    return hole

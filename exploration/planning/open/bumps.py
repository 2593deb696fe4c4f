"""Whether surface was felt in front of a flat face and looks its way: no convex object has what is raised on one.

Blur lays touched places a taxel past an edge, but those look along the face that was touched, and lie on that; on
a round face it lays them in front of it, as far as a coarse array's taxels are wide.  What was felt farther in
front of a face than blur reaches, whichever way it looks, is of no convex object either: the outer side of a leg
may go on from that of what it carries.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shared_error import with_shared_error
from primitives.surface_sigma import distance_sigma


@dataclass(frozen=True)
class BumpsConfig:
    """What stands out."""

    before: float = 0.7  # [mm] of a face, where such places are,
    sigmas: float = 3.0  # and as many standard deviations of where it is there
    alike: float = 0.97  # least cosine between the way they look and the face's: a rolling pad leans more
    far: float = 8.0  # [mm] of a face, in front of which places may look anywhere
    least: int = 15  # such places: of a convex object up to 8 were seen, beside rounded edges


def bumpy(faces: Sequence[Face], felt: Contacts, config: BumpsConfig = BumpsConfig()) -> bool:
    """Whether enough of what was `felt`, with the way that it faces, lies in front of one of the faces."""
    return any(_before(face, felt, config) >= config.least for face in faces)


def _before(face: Face, felt: Contacts, config: BumpsConfig) -> int:
    if not isinstance(face.fit, Fit) or face.fit.kind != "plane" or not len(felt):
        return 0
    side, shape = 1.0 if face.fit.convex else -1.0, face.fit.shape
    unsure = distance_sigma(with_shared_error(face.fit, face.weighed), felt.points)
    out = side * shape.signed_distance(felt.points) - config.sigmas * unsure
    alike = side * (shape.normals(felt.points) * felt.normals).sum(axis=1) > config.alike
    return int(((out > config.far) | ((out > config.before) & alike)).sum())

"""What counts as explained when exploration concludes."""

from types import SimpleNamespace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.concluding import unexplained
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]


def wall(number, way):
    """Of a hexagonal hole 36 mm across, looking to its axis."""
    out = np.array([np.cos(way), np.sin(way), 0.0])
    along = np.cross(Z, out)
    points = 18.0 * out + np.array([a * along + b * Z for a in (-8.0, 0.0, 8.0) for b in (-8.0, 0.0, 8.0)])
    return ranked_face(number, Contacts.of(points, np.tile(-out, (9, 1))), MergeOptions()), out, along


def test_a_wall_that_only_ends_at_a_rim_does_not_explain_it():
    (face, _, _), (_, out, along) = wall(1, 0.0), wall(2, np.pi / 3)
    corner = 18.0 * out - 10.0 * along
    found = SimpleNamespace(graph=SimpleNamespace(faces=(face,)), wall_rims=[])
    rim = Sighting(corner + 10.0 * Z, along, -out, Z, 0.05, 12.0), 0
    found.wall_rims = [rim]
    assert unexplained(found) == [rim]
    found.graph.faces = (face, wall(2, np.pi / 3)[0])
    assert unexplained(found) == []

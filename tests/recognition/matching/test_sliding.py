"""Poses are slid along a body or turned about it, where a few contacts alone tell how far."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder, Placed
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.evidence import Contacts
from primitives.pose import inverse, pose, rotation_exp
from recognition.matching.belief import Hypothesis
from recognition.matching.hypotheses import SearchConfig, begin
from recognition.matching.sliding import slid
from recognition.matching.target import target_of

BOLT = Cylinder(3.0, 40.0)
DISC = Cylinder(32.0, 13.0) - BOLT.at(24.0, 0.0, 0.0) - BOLT.at(-16.0, 0.0, 0.0)
TOOTH, TEETH = Cube((8.0, 4.0, 12.0)), 12
GEAR = Cylinder(24.0, 12.0) - Cylinder(8.0, 40.0) - Cube((4.0, 4.0, 40.0)).at(9.0, 0.0, 0.0)
for k in range(TEETH):
    turned = pose(rotation_exp([0.0, 0.0, 2.0 * np.pi * k / TEETH])) @ pose(None, [26.0, 0.0, 0.0])
    GEAR = GEAR | Placed(TOOTH, turned)
BAR = Cube((100.0, 20.0, 20.0)) - BOLT.at(30.0, 0.0, 0.0) - Cylinder(30.0, 8.0).at(0.0, 0.0, 14.0)
EACH = 0.1, 0.1, 0.1, 0.003, 0.003, 0.003  # [mm], [rad] of what is known well


@pytest.mark.parametrize(
    ("body", "away", "loose"),
    [(DISC, pose(rotation_exp([0.0, 0.0, 0.7])), (5, 0.05)), (BAR, pose(None, [9.0, 0.0, 0.0]), (0, 0.5))],
)
def test_a_pose_slides_to_where_the_holes_were_felt(body, away, loose):
    entry = Library.of({"body": Solid.from_csg(body)})["body"]
    samples, target = entry.samples, target_of(entry)
    begun = begin(Contacts.of(samples.points[:120], samples.normals[:120], 0.3, 0.05), SearchConfig(), 0.3)
    sigma = np.array(EACH)
    sigma[loose[0]] = loose[1]
    h = Hypothesis("body", away, 0.0, np.diag(sigma**2), 0.0, np.zeros(0))
    errors = [pose_error(entry.symmetry, inverse(pose(p[:, :3], p[:, 3])), np.eye(4))
              for p in slid(h, begun, target, SearchConfig())[:3]]  # fmt: skip
    assert min(e.distance + 30.0 * e.angle for e in errors) < 0.6


def test_a_gear_turns_by_the_teeth_that_its_keyway_tells() -> None:
    entry = Library.of({"gear": Solid.from_csg(GEAR)})["gear"]
    samples, target = entry.samples, target_of(entry)
    begun = begin(Contacts.of(samples.points[:120], samples.normals[:120], 0.3, 0.05), SearchConfig(), 0.3)
    turn = pose(rotation_exp([0.0, 0.0, 5 * 2.0 * np.pi / TEETH]))
    known = np.diag([0.2, *EACH[1:]]) ** 2  # its turn well, as far as a tooth goes
    poses = slid(Hypothesis("gear", turn, 0.0, known, 0.0, np.zeros(0)), begun, target, SearchConfig())
    errors = [pose_error(entry.symmetry, inverse(pose(p[:, :3], p[:, 3])), np.eye(4)) for p in poses[:3]]
    assert min(e.distance + 30.0 * e.angle for e in errors) < 2.0

"""Global localization: the right basin from any start, other modes listed below it."""

import numpy as np
import pytest

from models.csg import Cube
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, transform_points
from recognition.matching import Evidence, Prior, match

CORNERS = np.array([[0, 0, 0], [100, 0, 0], [30, 80, 0], [35, 25, 70.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


@pytest.fixture(scope="module")
def tetrahedron():
    return Library.of({"tetrahedron": Solid.from_mesh(CORNERS, FACES)})


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_nine_exact_contacts_without_normals_find_a_tetrahedron(tetrahedron, seed):
    rng = np.random.default_rng(seed)
    places = np.array([rng.dirichlet([1, 1, 1]) @ CORNERS[FACES[k % 4]] for k in range(9)])
    world = pose(random_rotation(rng), rng.uniform(-100, 100, 3))
    evidence = Evidence(Contacts.of(transform_points(world, places), None, 0.05))
    belief = match(evidence, tetrahedron, Prior(np.zeros(3), 200.0), unknown=0.0)
    error = pose_error(tetrahedron["tetrahedron"].symmetry, belief.hypotheses[0].pose, world)
    assert error.distance < 2.0
    assert error.angle < 0.05
    weights = [h.log_weight for h in belief.hypotheses]
    assert weights == sorted(weights, reverse=True)
    assert sum(h.probability for h in belief.hypotheses) == pytest.approx(1.0)


def test_contacts_of_one_touch_speak_as_fewer():
    points = 300.0 * np.random.default_rng(0).normal(size=(12, 3))
    alone = Evidence(Contacts.of(points, None, 0.1, touch=np.arange(12))).shares
    together = Evidence(Contacts.of(points, None, 0.1, touch=np.repeat([0, 1], 6))).shares
    assert alone.sum() == pytest.approx(12.0)
    assert 4.0 < together.sum() < 10.0


def test_contacts_close_together_speak_as_fewer():
    row = np.column_stack([np.arange(20.0), np.zeros((20, 2))])
    crowded, apart = (Evidence(Contacts.of(row * d, None, 0.1)).shares.sum() for d in (0.5, 60.0))
    assert apart == pytest.approx(20.0)
    assert crowded < 10.0


def test_a_patch_of_one_face_may_lie_on_any_face_that_is_large_enough():
    block = Library.of({"block": Solid.from_csg(Cube((80.0, 60.0, 40.0)))})
    points = np.column_stack([np.random.default_rng(0).uniform(-14, 14, (30, 2)), np.zeros(30)])
    contacts = Contacts.of(points, np.tile([0.0, 0, 1], (30, 1)), 0.05, 0.02)
    belief = match(Evidence(contacts), block, unknown=0.0)
    facing = {int(np.argmax(np.abs(h.pose[2, :3]))) for h in belief.hypotheses if h.probability > 0.05}
    assert facing == {0, 1, 2}

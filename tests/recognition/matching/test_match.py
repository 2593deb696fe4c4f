import signal

import numpy as np
import pytest

from models import parts
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.errors import PalpateError
from primitives.evidence import Contacts, FreeSpace
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.console import interrupts
from recognition.matching import Evidence, Prior, match
from recognition.matching.refining import Refining

NAMES = ("bracket", "wedge", "hex_nut", "stepped_shaft")
TURN = np.deg2rad(3) / np.sqrt(2)


@pytest.fixture(scope="module")
def library():
    return Library.of({name: Solid.from_csg(parts.build(name), 0.02) for name in NAMES})


def felt(entry, world, count, rng, noise=0.3, normals=True):
    """Contacts spread evenly over the triangles, independent of the library's own samples."""
    solid = entry.solid
    a, b, c = np.moveaxis(solid.vertices[solid.triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    t = rng.choice(len(area), count, p=area / area.sum())
    r, w = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    points = (1 - r) * a[t] + r * (1 - w) * b[t] + r * w * c[t]
    facing = solid.body.triangle_normals[t] + (noise > 0) * TURN * rng.standard_normal((count, 3))
    facing = rotate(world, facing / np.linalg.norm(facing, axis=1, keepdims=True))
    points = transform_points(world, points) + noise * rng.standard_normal((count, 3))
    return Contacts.of(points, facing if normals else None, max(noise, 0.01), TURN)


def somewhere(rng):
    return pose(random_rotation(rng), rng.uniform(-50, 50, 3))


@pytest.mark.slow
def test_twenty_contacts_name_the_object_and_find_its_pose(library):
    rng = np.random.default_rng(1)
    for name in NAMES:
        world = somewhere(rng)
        belief = match(Evidence(felt(library[name], world, 20, rng)), library)
        as_likely = [h for h in belief.hypotheses if h.name == name and h.probability > 0.3]
        errors = [pose_error(library[name].symmetry, h.pose, world) for h in as_likely]
        assert belief.decision == name
        assert any(e.distance < 3.0 and e.angle < 0.05 for e in errors)  # a nut turned over may fit as well


def test_probabilities_sum_to_one_and_hypotheses_to_no_more(library):
    rng = np.random.default_rng(2)
    belief = match(Evidence(felt(library["wedge"], somewhere(rng), 6, rng)), library)
    assert sum(belief.probabilities.values()) == pytest.approx(1.0)
    assert sum(h.probability for h in belief.hypotheses) <= 1.0 + 1e-9
    assert belief.confidence == max(belief.probabilities.values())


def test_a_match_ends_where_somebody_asks_for_an_end(library, monkeypatch):
    contacts = felt(library["wedge"], np.eye(4), 6, np.random.default_rng(2))
    monkeypatch.setattr(interrupts._state, "asked", signal.SIGTERM)
    with pytest.raises(interrupts.Interrupted) as told:
        match(Evidence(contacts), library)
    assert told.value.exit_code == 143


def test_of_many_contacts_those_that_are_searched_with_stay_in_the_order_they_were_felt_in(
    library, monkeypatch
):
    contacts = felt(library["wedge"], np.eye(4), 450, np.random.default_rng(2))
    seen = []
    begin = Refining.__post_init__
    monkeypatch.setattr(
        Refining, "__post_init__", lambda self: seen.append(self.evidence.contacts) or begin(self)
    )
    match(Evidence(contacts), library)
    row = {tuple(point): k for k, point in enumerate(contacts.points)}
    kept = [row[tuple(point)] for point in seen[0].points]
    assert len(kept) == 400
    assert kept == sorted(kept)


def test_an_object_that_is_left_out_is_unknown(library):
    rng = np.random.default_rng(3)
    others = Library.of({name: library[name].solid for name in ("wedge", "hex_nut", "stepped_shaft")})
    belief = match(Evidence(felt(library["bracket"], somewhere(rng), 30, rng)), others)
    assert belief.decision == "unknown"


def test_the_belief_moves_with_the_world(library):
    rng = np.random.default_rng(4)
    contacts = felt(library["bracket"], np.eye(4), 20, rng)
    motion = somewhere(rng)
    moved = Contacts.of(
        transform_points(motion, contacts.points), rotate(motion, contacts.normals), 0.3, TURN
    )
    here = match(Evidence(contacts), library).best("bracket")
    there = match(Evidence(moved), library).best("bracket")
    error = pose_error(library["bracket"].symmetry, motion @ here.pose, there.pose)
    assert error.distance < 0.1
    assert error.angle < 0.01


def test_one_contact_tells_little(library):
    belief = match(Evidence(Contacts.of([[1.0, 2.0, 3.0]], [[0, 0, 1.0]], 0.3, TURN)), library)
    assert belief.entropy_bits > 1.0
    assert belief.hypotheses[0].rotation_sigma > 0.5


@pytest.mark.parametrize("many", [1, 20])
def test_one_place_felt_exactly_is_answered_however_often_it_was_felt(library, many):
    contacts = Contacts.of([[1.0, 2.0, 3.0]] * many, [[0, 0, 1.0]] * many, 1e-5, 1e-3)
    belief = match(Evidence(contacts, scale_known=False), library)
    assert np.isfinite(belief.hypotheses[0].covariance).all()
    assert belief.confidence < 0.9


def test_contacts_far_from_the_prior_are_one_clear_line(library):
    rng = np.random.default_rng(5)
    contacts = felt(library["wedge"], pose(np.eye(3), [900.0, 0, 0]), 12, rng)
    only = Library.of({"wedge": library["wedge"].solid})
    with pytest.raises(PalpateError, match="prior-radius"):
        match(Evidence(contacts), only, Prior(np.zeros(3), 50.0), unknown=0.0)


def test_contacts_that_are_no_numbers_are_left_out_and_none_is_an_error(library):
    with pytest.raises(PalpateError, match="no contact"):
        match(Evidence(Contacts.of([[np.nan, 0, 0]])), library)


def test_swept_space_rules_out_what_would_stand_in_it(library):
    rng = np.random.default_rng(6)
    only = Library.of({"wedge": library["wedge"].solid})
    contacts = felt(library["wedge"], np.eye(4), 12, rng)
    before = match(Evidence(contacts), only, unknown=0.1)
    inside = FreeSpace(np.eye(4)[None], np.full((1, 3), 500.0))
    after = match(Evidence(contacts, free=inside), only, unknown=0.1)
    assert after.probabilities["wedge"] < before.probabilities["wedge"]


def test_an_empty_library_is_one_clear_line():
    with pytest.raises(PalpateError, match="holds no object"):
        match(Evidence(Contacts.of([[0.0, 0, 0]])), Library.of({}))


def test_a_pad_that_lay_on_an_edge_does_not_move_the_pose(library):
    rng = np.random.default_rng(7)
    solid, world = library["bracket"].solid, somewhere(rng)
    whole = felt(library["bracket"], world, 16, rng)
    low = solid.vertices.min(axis=0)
    edge = transform_points(world, low + np.array([[0.0, 0, 10], [0, 0, 20], [0, 0, 30]]))
    tilted = np.tile(rotate(world, np.array([[-0.57, -0.82, 0.0]])), (3, 1))
    both = Contacts.concatenate([whole, Contacts.of(edge, tilted, 0.1, 0.03, touch=1)])
    best = match(Evidence(both), library).best("bracket")
    error = pose_error(library["bracket"].symmetry, best.pose, world)
    assert error.distance < 1.0
    assert (best.log_likelihoods[-3:] > np.log(0.01 / 4 / np.pi / 1e5)).all()


def test_contacts_of_one_plane_leave_the_pose_wide(library):
    rng = np.random.default_rng(8)
    points = np.column_stack([rng.uniform(-8, 8, (12, 2)), np.zeros(12)])
    belief = match(Evidence(Contacts.of(points, np.tile([0.0, 0, 1], (12, 1)), 0.3, TURN)), library)
    assert sum(belief.probabilities.values()) == pytest.approx(1.0)
    assert belief.hypotheses[0].translation_sigma > 1.0


def test_ten_thousand_contacts_are_thinned_and_answered(library):
    rng = np.random.default_rng(9)
    world = somewhere(rng)
    belief = match(Evidence(felt(library["bracket"], world, 10_000, rng)), library)
    assert belief.decision == "bracket"
    assert pose_error(library["bracket"].symmetry, belief.best("bracket").pose, world).distance < 0.5


def test_too_few_contacts_to_tell_their_noise_leave_the_library_likely(library):
    """Estimated from two contacts, noise seemed least where one of them is astray, and all objects unlike."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        entry = library[NAMES[seed]]
        few = Evidence(felt(entry, somewhere(rng), 2, rng), scale_known=False, normal_scale_known=False)
        assert match(few, library).probabilities["unknown"] < 0.5

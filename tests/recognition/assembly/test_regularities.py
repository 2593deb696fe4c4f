"""Which relations are accepted, and what accepting them does."""

from dataclasses import dataclass

import numpy as np
import pytest

from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.pose import pose, random_rotation, rotation_exp
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus
from recognition.assembly.regularities import RegularityOptions, regularize
from recognition.assembly.regularities.proposals import coincident, parallel
from recognition.assembly.regularities.state import State

TILT = np.deg2rad(0.05)
OFFSET = 0.01  # [mm]


@dataclass
class Given:
    shape: Shape
    covariance: np.ndarray
    chi2: float = 10.0
    dof: int = 10
    convex: bool = True


def given(shape, rng=None, offset=OFFSET, tilt=TILT):
    """A shape, disturbed by its own covariance where there is a generator."""
    sigma = np.full(shape.dof, offset)
    first = len(shape.translations)
    sigma[first : first + shape.tilts] = tilt
    if shape.kind == "cone":
        sigma[-1] = tilt
    if rng is not None:
        shape = shape.retract(sigma * rng.standard_normal(shape.dof))
    return Given(shape, np.diag(sigma**2))


def block_planes(world=None):
    half = (30.0, 20.0, 15.0)
    axes = np.eye(3)
    planes = [Plane(s * h * axes[i], s * axes[i]) for i, h in enumerate(half) for s in (-1.0, 1.0)]
    return [p.transformed(np.eye(4) if world is None else world) for p in planes]


def counts(found):
    kinds = [r.kind for r in found.relations]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds))}


def test_a_noisy_block_becomes_exactly_rectangular_at_any_pose():
    accepted = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world = pose(random_rotation(rng), rng.uniform(-50, 50, 3))
        found = regularize([given(p, rng) for p in block_planes(world)])
        normals = np.array([s.direction for s in found.shapes])
        angles = np.abs(normals @ normals.T)
        accepted += bool(((angles < 1e-9) | (angles > 1 - 1e-12)).all())
    assert accepted >= 38  # of 6 independent relations, each is refused once in a thousand


@pytest.mark.parametrize("angle", [0.5, 1.0, 3.0])
def test_a_real_misalignment_is_kept(angle):
    for seed in range(20):
        rng = np.random.default_rng(seed)
        planes = block_planes()
        tilted = planes[1].transformed(pose(rotation_exp(np.deg2rad([0, angle, 0]))))
        planes[1] = Plane(planes[1].origin, tilted.normal)
        found = regularize([given(p, rng) for p in planes])
        between = np.arccos(np.clip(-found.shapes[0].direction @ found.shapes[1].direction, -1, 1))
        assert np.rad2deg(between) == pytest.approx(angle, abs=0.3)
        assert between > np.deg2rad(0.1)


@pytest.mark.parametrize(("deviations", "meant"), [(4.0, True), (12.0, False)])
def test_the_better_known_a_direction_is_the_more_deviations_it_may_be_off(deviations, meant):
    up = np.array([0, 0, 1.0])
    floor, lean = Plane(np.zeros(3), up), rotation_exp([deviations * 3e-4, 0, 0]) @ up
    step, side = (
        Plane(np.array([0, 0, -20.0]), lean),
        Plane(np.array([0, 40.0, 0]), np.cross(lean, [-1.0, 0, 0])),
    )
    for other, kind in ((step, "parallel"), (side, "perpendicular")):
        found = regularize([given(floor, tilt=2e-4), given(other, tilt=2e-4)])
        assert counts(found) == ({kind: 1} if meant else {})
    badly = Plane(np.array([0, 0, -20.0]), rotation_exp([4.0 * 0.015, 0, 0]) @ up)
    assert counts(regularize([given(floor, tilt=0.01), given(badly, tilt=0.01)])) == {}


def test_what_is_badly_known_is_bent_and_what_is_well_known_stays():
    sure = given(Plane(np.zeros(3), np.array([0, 0, 1.0])), tilt=1e-5)
    leaning = rotation_exp([0.004, 0.0, 0.0]) @ np.array([0, 0, -1.0])
    unsure = given(Plane(np.array([0, 0, -20.0]), leaning), tilt=0.01)
    found = regularize([sure, unsure], RegularityOptions(floor=1e-7))
    assert np.arccos(min(1.0, found.shapes[0].direction @ sure.shape.direction)) < 1e-5
    assert np.allclose(found.shapes[0].direction, -found.shapes[1].direction, atol=1e-9)


def test_a_relation_adds_certainty():
    fits = [given(p) for p in block_planes()]
    found = regularize(fits)
    tilt = np.sqrt(np.diag(found.covariance_of(0))[1:])
    assert (tilt < 0.7 * TILT).all()


def test_an_axis_and_two_caps_become_upright_and_coaxial_with_a_cone():
    rng = np.random.default_rng(1)
    up = np.array([0, 0, 1.0])
    shapes = [
        Cylinder(np.array([3.0, 4, 0]), up, 12.0),
        Plane(np.array([3.0, 4, -20]), -up),
        Cone(np.array([3.0, 4, 50]), -up, 0.4),
    ]
    found = regularize([given(s, rng) for s in shapes])
    assert counts(found) == {"coaxial": 1, "parallel": 3}
    rod, cap, cone = found.shapes
    assert np.linalg.norm(np.cross(rod.axis, cap.normal)) < 1e-9
    offset = cone.apex - rod.origin
    assert np.linalg.norm(offset - (offset @ rod.axis) * rod.axis) < 1e-8


def test_a_sphere_near_an_axis_is_put_on_it_and_one_beside_it_is_not():
    rod = Cylinder(np.zeros(3), np.array([0, 0, 1.0]), 12.0)
    on = regularize([given(rod), given(Sphere(np.array([0.015, 0, 30]), 15.0))])
    beside = regularize([given(rod), given(Sphere(np.array([0.2, 0, 30]), 15.0))])
    assert counts(on) == {"coaxial": 1}
    assert counts(beside) == {}
    assert np.allclose(beside.shapes[1].center, [0.2, 0, 30])


def test_one_face_touched_twice_is_coincident_and_a_low_step_is_not():
    up = np.array([0, 0, 1.0])
    first = given(Plane(np.zeros(3), up))
    same = given(Plane(np.array([30.0, 0, 0.01]), up))
    step = given(Plane(np.array([30.0, 0, 0.3]), up))
    assert counts(regularize([first, same]))["coincident"] == 1
    assert "coincident" not in counts(regularize([first, step]))


@pytest.mark.parametrize("axis", [[1.0, 0.0, 0.0], [0.6, -0.8, 0.0], [0.0, 0.0, 1.0]])
@pytest.mark.parametrize("lean", [-1e-9, 0.0, 1e-9])
def test_holes_that_lie_level_are_two_where_they_are_far_apart(axis, lean):
    along = np.array(axis) + lean
    beside = np.cross(along, [0.3, 0.5, 0.7])
    far = [Cylinder(s * 10.0 * beside, s * along, 6.0) for s in (1.0, -1.0)]
    found = regularize([given(shape) for shape in far])
    assert "coincident" not in counts(found)
    assert all(shape.radius == pytest.approx(6.0, abs=1e-6) for shape in found.shapes)


def test_the_two_sides_of_a_thin_plate_are_never_coincident():
    up = np.array([0, 0, 1.0])
    pair = [given(Plane(np.zeros(3), up)), given(Plane(np.array([0, 0, -0.005]), -up))]
    assert "coincident" not in counts(regularize(pair))


def test_exact_shapes_are_left_as_they_are():
    world = pose(random_rotation(np.random.default_rng(2)), [10.0, 20, 30])
    planes = block_planes(world)
    found = regularize([Given(p, np.zeros((3, 3))) for p in planes])
    assert counts(found) == {"parallel": 3, "perpendicular": 12, "round": 3}
    assert np.abs(found.step).max() < 1e-9


def test_a_ring_that_is_hardly_known_is_not_carried_past_what_a_ring_can_be():
    """Moved onto the rod's axis, 3 mm away, its minor radius of 5 mm would become 15 mm less."""
    up = np.array([0, 0, 1.0])
    ring, sigma = Torus(np.zeros(3), up, 20.0, 5.0), np.array([2.0, 2.0, 1.0, 0.01, 0.01, 0.1, 10.0])
    loose = np.diag(sigma**2)
    loose[0, -1] = loose[-1, 0] = 0.99 * sigma[0] * sigma[-1]
    sides = [sign * ring.frame[:, 0] for sign in (3.0, -3.0)]
    for side in sides:
        found = regularize([Given(ring, loose), given(Cylinder(side, up, 6.0))])
        assert found.shapes[0].sizes[-1] > 0.0
        assert ("coaxial" in counts(found)) == (found.shapes[0].sizes[-1] > 10.0)


def test_nothing_to_regularize_is_no_error():
    assert regularize([]).shapes == ()


def test_a_nearly_cylindrical_cone_stays_on_its_contacts():
    rng, rod = np.random.default_rng(5), Cylinder([0, 0, 0.0], [0, 0, 1.0], 40.0)
    around, height = rng.uniform(-1.2, 1.2, 40), rng.uniform(-3.0, 3.0, 40)
    at = rod.project(np.column_stack([40 * np.cos(around), 40 * np.sin(around), height]))
    points = at + 0.05 * rng.standard_normal((40, 1)) * rod.normals(at)
    found = fit("cone", Contacts.of(points, rod.normals(at), 0.05, 0.05))
    assert found
    assert np.linalg.norm(found.shape.apex) > 500.0
    floor = given(Plane([0, 0, -3.0], [0.0, 0.0, -1.0]), tilt=1e-5, offset=1e-3)
    adjusted = regularize([found, floor])
    assert counts(adjusted) == {"parallel": 1}
    away = adjusted.shapes[0].signed_distance(points)
    assert np.sqrt(np.mean(away**2)) < 2 * found.rms


def test_a_relation_that_follows_from_others_is_told_and_is_no_constraint_of_its_own():
    rng = np.random.default_rng(4)
    heights = 10.0 * np.arange(8)
    state = State([given(Plane(h * np.eye(3)[2], np.eye(3)[2]), rng) for h in heights], RegularityOptions())
    for proposal in parallel(state):
        state.consider(proposal)
    assert len(state.relations) == 8 * 7 / 2
    assert len(state.accepted) == 7
    state.polish()
    normals = np.array([shape.direction for shape in state.shapes()])
    assert np.allclose(normals, normals[0], atol=1e-9)


def test_what_was_met_before_and_is_not_sure_becomes_a_constraint_all_the_same():
    flat = [given(Plane(np.zeros(3), np.eye(3)[2])) for _ in range(2)]
    state = State(flat, RegularityOptions())
    for proposal in coincident(state):
        state.consider(proposal)
    assert len(state.accepted) == 1
    assert np.sqrt(np.diag(state.posterior)).max() < OFFSET  # two faces tell more than one


def loose_hole(turn, rng):
    """A hole whose axis is hardly known, and its size the less the more it leans."""
    shape, sigma = (
        Cylinder([30 * np.cos(turn), 30 * np.sin(turn), 0.0], np.eye(3)[2], 4.0),
        [0.05] * 2 + [0.03] * 3,
    )
    covariance = (0.3 * np.eye(5) + 0.7) * np.outer(sigma, sigma)
    return Given(
        shape.retract(np.linalg.cholesky(covariance) @ rng.standard_normal(5)), covariance, convex=False
    )


@pytest.mark.parametrize("seed", [8, 11, 33])
def test_axes_that_are_hardly_known_become_parallel_and_leave_holes_their_size(seed):
    rng = np.random.default_rng(seed)
    holes = [loose_hole(turn, rng) for turn in np.arange(4) * np.pi / 2]
    faces = [given(Plane([0, 0, z], [0, 0, s]), rng, tilt=2e-4) for z, s in ((0.0, -1.0), (6.0, 1.0))]
    found = regularize([*holes, *faces], RegularityOptions(round=False))
    assert counts(found)["parallel"] >= 12
    for before, after in zip(holes, found.shapes, strict=False):
        assert after.radius == pytest.approx(before.shape.radius, abs=0.1)

"""From fitted faces to a short list of primitives where the body is not convex."""

from dataclasses import dataclass

import numpy as np
import pytest

from models.csg import Cone as ConeSolid
from models.csg import Cube, Prism, Sphere
from models.csg import Cylinder as CylinderSolid
from models.csg import Torus as TorusSolid
from models.parts import build
from models.solid import Solid, iou
from primitives.evidence import Contacts
from primitives.fit import Fit, refit
from primitives.pose import pose, random_rotation
from primitives.shapes import Cylinder, Plane, Torus
from recognition.assembly import assemble
from recognition.assembly.exchange import exchanged
from recognition.assembly.lists import Step, Target
from recognition.assembly.search import mended, shortest
from recognition.assembly.separators import separators, stops
from recognition.assembly.vocabulary import Candidate, Vocabulary
from recognition.truth import LabeledFaces, TruthOptions, sample_surface

BOX = np.array([[-300.0] * 3, [300.0] * 3])


@dataclass
class Touched:
    fit: Fit
    contacts: Contacts


def touched_faces(solid, rng, sigma=0.01, each=80):
    labels = LabeledFaces.of(solid)
    samples, face_of = sample_surface(solid, TruthOptions(samples=1, least_face=each), labels)
    out = []
    for face in labels.faces:
        shape = face.shape.transformed(solid.pose)
        points = shape.project(samples.points[face_of == face.id])
        normals = shape.normals(points) * (1 if face.convex else -1)
        points = points + sigma * rng.standard_normal((len(points), 1)) * normals
        contacts = Contacts.of(points, normals, sigma, np.deg2rad(2.0), touch=np.arange(len(points)))
        fit = refit(shape, face.convex, contacts)
        assert fit
        out.append(Touched(fit, contacts))
    return out


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["bracket", "slotted_block", "stepped_shaft", "dovetail_block", "dish", "die_holder"]
)
def test_a_part_with_steps_and_holes_is_recovered_with_as_few_leaves_as_it_was_made_with(name):
    tree, rng = build(name), np.random.default_rng(0)
    truth = Solid.from_csg(tree, 0.005).placed(pose(random_rotation(rng), rng.uniform(-80, 80, 3)))
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.999
    assert len(found.pieces) <= len(list(tree.leaves()))


def test_a_step_makes_the_same_list_every_time():
    truth = Solid.from_csg(build("stepped_block"), 0.005)
    first, second = (assemble(touched_faces(truth, np.random.default_rng(1)), BOX) for _ in range(2))
    assert repr(first.tree) == repr(second.tree)


def test_a_slot_whose_ends_are_round_gets_planes_through_its_axes():
    end = Cylinder(np.array([10.0, 0, 0]), np.array([0, 0, 1.0]), 4.0)
    walls = [Plane(np.array([0, y, 0]), np.array([0, y, 0])) for y in (4.0, -4.0)]
    (made,) = separators([end, *walls])
    assert abs(made.normal[0]) == pytest.approx(1.0)
    assert made.signed_distance(np.array([[10.0, 7.0, 3.0]]))[0] == pytest.approx(0.0, abs=1e-12)


def test_a_plane_that_misses_a_cylinder_gets_no_separator():
    end = Cylinder(np.zeros(3), np.array([0, 0, 1.0]), 4.0)
    assert separators([end, Plane(np.array([0, 6.0, 0]), np.array([0, 1.0, 0]))]) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bearing_block", "cavity_block", "eyebolt"])
def test_what_runs_into_a_round_body_ends_inside_it(name):
    tree, rng = build(name), np.random.default_rng(0)
    truth = Solid.from_csg(tree, 0.005)
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.999
    assert len(found.pieces) <= len(list(tree.leaves()))


def test_a_pin_may_end_in_the_tube_of_the_ring_that_it_carries():
    ring = Torus(np.zeros(3), np.array([0, 1.0, 0]), 20.0, 5.0)
    pin = Cylinder(np.array([0, 0, -50.0]), np.array([0, 0, 1.0]), 4.0)
    assert sorted(round(float(s.origin[2]), 9) for s in stops([ring, pin])) == [-20.0, 20.0]
    hardly_felt = Cylinder(np.array([0, 0, -50.0]), np.array([0, 0.04, 1.0]), 4.0)
    assert len(stops([ring, hardly_felt])) == 2


def test_a_bent_tube_goes_over_into_straight_ones_at_planes_through_its_rings_axis():
    ring = Torus(np.zeros(3), np.array([0, 0, 1.0]), 30.0, 8.0)
    straight = Cylinder(np.array([30.0, -40.0, 0.1]), np.array([0, 1.0, 0]), 8.0)
    (made,) = separators([ring, straight])
    assert abs(made.normal[1]) == pytest.approx(1.0)
    assert made.signed_distance(np.zeros((1, 3)))[0] == pytest.approx(0.0, abs=1e-12)
    beside = Cylinder(np.array([25.0, -40.0, 0.0]), np.array([0, 1.0, 0]), 8.0)
    assert separators([ring, beside]) == []


@pytest.mark.parametrize("turn", [60.0, 90.0, 150.0])
def test_a_bent_tube_is_a_bend_of_a_ring_between_two_cylinders(turn):
    """A bend of some degrees, a leg at its beginning and one at its end."""
    angles = np.radians([0.0, turn / 2.0, turn])
    rim = 80.0 * np.column_stack([np.cos(angles), np.sin(angles)])
    sector = Prism(tuple(map(tuple, np.concatenate([np.zeros((1, 2)), rim]).tolist())), 40.0)
    leg = CylinderSolid(8.0, 40.0).placed(pose([[1, 0, 0], [0, 0, 1], [0, -1, 0]], [30.0, -19.99, 0.0]))
    c, s = np.cos(angles[-1]), np.sin(angles[-1])
    other = CylinderSolid(8.0, 30.0).placed(pose([[1, 0, 0], [0, 0, 1], [0, -1, 0]], [30.0, 14.99, 0.0]))
    tree = TorusSolid(30.0, 8.0) & sector | leg | other.placed(pose([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    truth = Solid.from_csg(tree, 0.01)
    found = assemble(touched_faces(truth, np.random.default_rng(2)), BOX)
    assert found
    assert iou(found.solid, truth) > 0.995
    assert sorted(piece.kind for piece in found.pieces) == ["cylinder", "cylinder", "torus"]


def test_a_flange_with_a_turned_edge_is_there_though_nobody_felt_the_end_of_its_cone():
    shaft, collar = CylinderSolid(11.0, 110.0).at(0, 0, 55), CylinderSolid(22.0, 12.0).at(0, 0, 46)
    edge = ConeSolid(22.0, 14.0, 10.0).at(0, 0, 57)
    truth = Solid.from_csg(shaft | collar | edge, 0.005)
    faces = touched_faces(truth, np.random.default_rng(3))
    heights = [float(np.ptp(f.contacts.points[:, 2])) for f in faces]
    top = [f.fit.kind == "plane" and h < 1.0 and 61.0 < f.contacts.points[0, 2] < 63.0
           for f, h in zip(faces, heights, strict=True)]  # fmt: skip
    assert sum(top) == 1
    found = assemble([f for f, cut in zip(faces, top, strict=True) if not cut], BOX)
    assert found
    assert iou(found.solid, truth) > 0.98


def test_what_would_refill_a_hole_is_added_before_it():
    planes = [Plane(k * n, n) for n in np.eye(3)[:2] for k in range(4)]
    centers = np.array([[x, y, 0.0] for x in np.arange(-0.5, 4.0) for y in np.arange(-0.5, 4.0)])
    vocabulary = Vocabulary(planes, np.stack([p.signed_distance(centers) > 0 for p in planes], axis=1))
    (x, y), weight = centers.T[:2], np.full(len(centers), 100.0)
    upright, across = (abs(x - 1.5) < 1) & (abs(y - 1.5) < 2), (abs(x - 1.5) < 2) & (abs(y - 1.5) < 1)
    cross = (upright | across) & ~(upright & across)
    bar, hole = (vocabulary.best(np.where(m, 1.0, -1.0), 1)[0][1] for m in (upright, upright & across))
    target = Target(vocabulary, cross, weight)
    after = mended(target.listed((Step("add", bar), Step("subtract", hole))), target)
    assert [step.operation for step in after.steps] == ["add", "add", "subtract"]
    assert (after.held == cross).all()


def test_a_bar_that_was_left_open_past_its_round_end_ends_at_its_axis():
    x, y = np.eye(3)[:2]
    sides = [Plane(k * y, y) for k in (-4.0, 4.0)] + [Plane(k * x, x) for k in (-10.0, 10.0)]
    end = Cylinder(10.0 * x, np.eye(3)[2], 4.0)
    grid = np.array([[a, b, 0.0] for a in np.arange(-14.5, 20.0) for b in np.arange(-7.5, 8.0)])
    outside = np.stack([s.signed_distance(grid) > 0 for s in (*sides, end)], axis=1)
    vocabulary, weight = Vocabulary([*sides, end], outside), np.ones(len(grid))
    bar = (abs(grid[:, 1]) < 4) & (abs(grid[:, 0]) < 10) | ~outside[:, 4]
    frame = next(k for k, axes in enumerate(vocabulary.frames) if None not in axes[:2])
    slabs = tuple(
        (2, None) if axis is not None and vocabulary.directions[axis].axis @ x > 0.5 else (0, 1)
        for axis in vocabulary.frames[frame][:2]
    )
    open_ = Candidate("cube", frame=frame, slabs=(*slabs, (None, None)))
    target = Target(vocabulary, bar, weight)
    after = exchanged(target.listed((Step("add", open_),)), target)
    assert [step.candidate.kind for step in after.steps] == ["cube", "cylinder"]
    assert (after.held == bar).all()
    long = Candidate("prism", sides=((0, True), (1, False), (2, True)))
    after = exchanged(target.listed((Step("add", long),)), target)
    assert [step.candidate.kind for step in after.steps] == ["cube", "cylinder"]
    assert (after.held == bar).all()


def test_a_ring_round_a_bore_that_was_felt_is_added_and_bored():
    """A foot with a ring on it: the bore's evidence outweighs the ring's, and whoever adds the ring fills it."""
    x, y, z = np.eye(3)
    center = 10.0 * y
    rings = [Cylinder(center, z, 8.0), Cylinder(center, z, 6.0)]
    foot = [Plane(k * y, y) for k in (0.0, 4.0)] + [Plane(k * x, x) for k in (-15.0, 15.0)]
    grid = np.array([[a, b, 0.0] for a in np.arange(-19.5, 20.0) for b in np.arange(-4.5, 25.0)])
    outside = np.stack([s.signed_distance(grid) > 0 for s in (*foot, *rings)], axis=1)
    base = (abs(grid[:, 0]) < 15) & (grid[:, 1] > 0) & (grid[:, 1] < 4)
    part = (base | ~outside[:, 4]) & outside[:, 5]
    weight = np.where(outside[:, 5], 1.0, 20.0)
    found = shortest(Target(Vocabulary([*foot, *rings], outside), part, weight))
    assert (found.held == part).all()
    assert [step.operation for step in found.steps] == ["add", "add", "subtract"]


def test_a_plane_hardly_off_upright_ends_a_round_body():
    lean = np.array([0.004, 0.0, 1.0])
    shapes = [Cylinder(np.zeros(3), np.eye(3)[2], 10.0), Plane(np.zeros(3), -np.eye(3)[2])]
    shapes += [Plane(np.array([0, 0, 30.0]), lean / np.linalg.norm(lean)), Plane(np.zeros(3), np.eye(3)[0])]
    vocabulary = Vocabulary(shapes, np.zeros((1, 4), dtype=bool))
    assert vocabulary.across(0) == (1, 2)
    assert Candidate("cylinder", 0, slabs=((1, 2),)) in vocabulary.rounds(np.ones(1), 50)


def test_a_hexagonal_bar_is_added_together_with_the_bore_that_weighs_more_than_it():
    ways = [np.array([np.cos(a), np.sin(a), 0.0]) for a in np.arange(6) * np.pi / 3]
    shapes = [Plane(18.0 * way, way) for way in ways]
    shapes += [Plane(z * np.eye(3)[2], np.eye(3)[2]) for z in (0.0, 16.0)]
    shapes.append(Cylinder(np.zeros(3), np.eye(3)[2], 9.0))
    places = np.random.default_rng(0).uniform(-30.0, 30.0, (20_000, 3))
    outside = np.unique(np.stack([s.signed_distance(places) > 0 for s in shapes], axis=1), axis=0)
    vocabulary = Vocabulary(shapes, outside)
    block = ~outside[:, :6].any(axis=1) & outside[:, 6] & ~outside[:, 7]
    bore = ~outside[:, 8]
    weight = np.where(block & ~bore, 1000.0, np.where(bore, 2000.0, 100.0))
    found = shortest(Target(vocabulary, block & ~bore, weight))
    assert [(step.operation, step.candidate.kind) for step in found.steps] == [
        ("add", "prism"),
        ("subtract", "cylinder"),
    ]
    assert found.wrong == 0.0


def test_a_rounded_slab_with_a_pocket_is_two_boxes_and_four_cylinders_less_a_box():
    tree = Cube((76, 70, 28)).at(0, 0, 14) | Cube((100, 46, 28)).at(0, 0, 14)
    for x, y in ((-38, -23), (-38, 23), (38, -23), (38, 23)):
        tree = tree | CylinderSolid(12, 28).at(x, y, 14)
    tree, rng = tree - Cube((60, 40, 30)).at(0, 0, 25), np.random.default_rng(0)
    truth = Solid.from_csg(tree, 0.005).placed(pose(random_rotation(rng), rng.uniform(-80, 80, 3)))
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.999
    kinds = sorted((piece.operation, piece.kind) for piece in found.pieces)
    assert kinds == [("add", "cube")] * 2 + [("add", "cylinder")] * 4 + [("subtract", "cube")]


def test_a_bored_neck_on_a_pot_is_found_among_the_many_ends_that_the_pot_may_have():
    def neck(radius, length):
        return CylinderSolid(radius, length).turned("x", np.pi / 2).at(0, -34, 25)

    tree = CylinderSolid(40, 50).at(0, 0, 25) | CylinderSolid(55, 8).at(0, 0, 4) | neck(18, 40)
    tree = tree - CylinderSolid(33, 60).at(0, 0, 38) - neck(12, 50)
    truth, rng = Solid.from_csg(tree, 0.005), np.random.default_rng(0)
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.995
    assert len(found.pieces) <= 7


def test_a_dome_on_a_plate_is_a_ball_less_what_is_under_the_plate_and_the_plate():
    dome = Sphere(34).at(0, -3, -7) - Cube((90, 90, 60)).at(0, 0, -30)
    tree, rng = dome | Cube((80, 85, 9)).at(0, 0, 4.5), np.random.default_rng(0)
    truth = Solid.from_csg(tree, 0.005).placed(pose(random_rotation(rng), rng.uniform(-80, 80, 3)))
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.999
    assert len(found.pieces) == 3


def test_a_collar_whose_underside_nobody_felt_ends_where_it_was_felt_last():
    """A cone would lie inside the collar's cylinder all its length; contacts of both say what is between them."""
    rng = np.random.default_rng(4)
    handle = ConeSolid(7.0, 11.0, 50.0).at(0, 0, 25.0) | CylinderSolid(14.0, 14.0).at(0, 0, 57.0)
    truth = Solid.from_csg(handle | Sphere(16.0), 0.005)
    ledge = [
        face
        for face in touched_faces(truth, rng)
        if not (face.fit.kind == "plane" and abs(face.fit.shape.origin[2] - 50.0) < 1.0)
    ]
    found = assemble(ledge, BOX)
    assert found
    assert iou(found.solid, truth) > 0.95
    assert [piece.kind for piece in found.pieces].count("cylinder") == 1

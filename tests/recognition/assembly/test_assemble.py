"""From fitted faces to a named body: every convex built-in part, at any pose, from noisy contacts."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from models.boundary import labeled_boundary
from models.csg import Cone, Cube, Cylinder, Sphere
from models.parts import build, describe, names
from models.solid import Solid, iou
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import Fit, refit
from primitives.pose import pose, random_rotation
from primitives.shapes import Plane
from recognition.assembly.assemble import AssemblyOptions, assemble
from recognition.assembly.closure import NotClosed
from recognition.assembly.described import (
    describe_edges,
    describe_faces,
    describe_primitives,
    describe_regularities,
    link,
    written_tree,
)
from recognition.assembly.given import outward
from recognition.assembly.regularities import RegularityOptions
from recognition.truth import LabeledFaces, TruthOptions, evaluate, sample_surface

CONVEX = [name for name in names() if describe(name).convex]
OF_FOUR = [
    name
    for name in CONVEX
    if all(isinstance(leaf.primitive, Cube | Cylinder | Cone | Sphere) for leaf in build(name).leaves())
]
BOX = np.array([[-300.0] * 3, [300.0] * 3])
SIGMA = 0.01  # [mm] of a contact


@dataclass
class Touched:
    fit: Fit
    contacts: Contacts


def touched_faces(solid, rng, sigma=SIGMA, each=150):
    """Contacts on every face of a placed solid, and fits to them from the exact shapes."""
    labels = LabeledFaces.of(solid)
    samples, face_of = sample_surface(solid, TruthOptions(samples=1, least_face=each), labels)
    out = []
    for face in labels.faces:
        shape = face.shape.transformed(solid.pose)
        points = samples.points[face_of == face.id]
        points = shape.project(points)
        normals = shape.normals(points) * (1 if face.convex else -1)
        points = points + sigma * rng.standard_normal((len(points), 1)) * normals
        contacts = Contacts.of(points, normals, sigma, np.deg2rad(2.0), touch=np.arange(len(points)))
        fit = refit(shape, face.convex, contacts)
        assert fit
        out.append(Touched(fit, contacts))
    return out


def placed(tree, seed):
    rng = np.random.default_rng(seed)
    return Solid.from_csg(tree, 0.005).placed(pose(random_rotation(rng), rng.uniform(-80, 80, 3))), rng


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", OF_FOUR)
def test_a_convex_part_is_recovered_with_as_few_leaves_as_it_was_made_with(name, seed):
    tree = build(name)
    truth, rng = placed(tree, seed)
    found = assemble(touched_faces(truth, rng), BOX)
    assert found
    assert iou(found.solid, truth) > 0.999
    assert len(found.pieces) <= len(list(tree.leaves()))
    assert found.dropped == ()
    compared = evaluate(found.solid, truth, TruthOptions(samples=1500))
    assert compared.face_shape_accuracy == 1.0
    assert compared.surface_mean < 0.01
    assert max(compared.extent_errors) < 0.1


@pytest.mark.parametrize("name", CONVEX)
def test_every_face_of_a_part_is_linked_to_the_fit_it_came_from(name):
    truth, rng = placed(build(name), 2)
    found = assemble(touched_faces(truth, rng), BOX)
    boundary = link(found)
    assert None not in boundary.fit_of_face
    assert len(boundary.brep.faces) == len(labeled_boundary(truth)[0].faces)
    assert boundary.brep.check() == ()
    for face in describe_faces(found, boundary):
        assert face["status"] == "measured"
        assert face["sigma"]["origin_mm"] > 0


def test_a_block_is_one_cube_with_the_deviations_of_its_sides():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 3)
    (entry,) = describe_primitives(assemble(touched_faces(truth, rng), BOX))
    assert entry["kind"] == "cube"
    assert entry["operation"] == "add"
    assert sorted(entry["extent_mm"]) == pytest.approx([30, 40, 60], abs=0.02)
    error = np.sort(entry["extent_mm"]) - [30, 40, 60]
    assert (np.abs(error) < 4 * np.max(entry["sigma"]["extent_mm"])).all()
    assert max(entry["sigma"]["extent_mm"]) < 0.01


def test_size_deviations_are_those_of_many_trials():
    solid = Solid.from_csg(Cube((60.0, 40.0, 30.0)), 0.01)
    errors, stated = [], []
    measured = AssemblyOptions(regularity=RegularityOptions(round=False))
    for seed in range(40):
        faces = touched_faces(solid, np.random.default_rng(seed), 0.1, 40)
        (entry,) = describe_primitives(assemble(faces, BOX, measured))
        errors.append(np.subtract(entry["extent_mm"], [60, 40, 30]))
        stated.append(entry["sigma"]["extent_mm"])
    assert np.std(errors, axis=0) == pytest.approx(np.mean(stated, axis=0), rel=0.35)


def test_a_block_is_regular_and_tells_what_was_measured():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 3)
    found = assemble(touched_faces(truth, rng), BOX)
    told = describe_regularities(found, link(found))
    kinds = [row["kind"] for row in told]
    assert {kind: kinds.count(kind) for kind in kinds} == {"parallel": 3, "perpendicular": 3, "round": 3}
    sizes = {row["taken"]: row for row in told if row["kind"] == "round"}
    assert set(sizes) == {30.0, 40.0, 60.0}
    for size, row in sizes.items():
        assert row["unit"] == "mm"
        assert 0.0 < abs(row["measured"] - size) < 4 * row["sigma"]
        first, second = (found.shape(link(found).fit_of_face[face]) for face in row["faces"])
        assert abs((second.anchor - first.anchor) @ first.normal) == pytest.approx(size, abs=1e-6)
    for row in told[:6]:
        assert (row["unit"], row["taken"]) == ("deg", 0.0)
        assert row["measured"] < 4 * row["sigma"] < 1.0


def test_a_cone_without_a_second_cap_closes_at_its_apex():
    truth, rng = placed(build("cone"), 4)
    (entry,) = describe_primitives(assemble(touched_faces(truth, rng), BOX))
    assert entry["top_radius_mm"] == 0.0


@pytest.mark.parametrize("missing", range(6))
def test_a_block_without_one_face_is_open_there(missing):
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 5)
    faces = touched_faces(truth, rng)
    way = faces[missing].fit.shape.normal
    found = assemble(faces[:missing] + faces[missing + 1 :], BOX)
    assert not found
    assert "open along" in found.reason
    assert max(np.array(found.directions) @ way) > 0.7
    assert len(found.open_faces) == 4


def test_one_face_alone_names_itself_as_open():
    truth, rng = placed(Cylinder(15.0, 40.0), 6)
    found = assemble(touched_faces(truth, rng)[:1], BOX)
    assert isinstance(found, NotClosed)
    assert found.open_faces == (0,)


def test_no_face_at_all_is_not_closed():
    assert not assemble([], BOX)


def test_contacts_overrule_fits_that_were_turned_inside_out():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 7)
    faces = touched_faces(truth, rng)
    turned = [replace(f.fit, shape=Plane(f.fit.shape.origin, -f.fit.shape.normal)) for f in faces]
    found = assemble([Touched(fit, f.contacts) for fit, f in zip(turned, faces, strict=True)], BOX)
    assert iou(found.solid, truth) > 0.999


def test_a_plane_that_does_not_touch_the_body_is_left_out_and_said():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 8)
    faces = touched_faces(truth, rng)
    direction = faces[0].fit.shape.normal + faces[2].fit.shape.normal
    far = Plane(truth.center + 100.0 * direction / np.linalg.norm(direction), direction)
    stray = Touched(replace(faces[0].fit, shape=far), faces[0].contacts)
    found = assemble([*faces, stray], BOX)
    assert found.dropped == (6,)
    assert "lies on no surface" in found.warnings[0]
    assert iou(found.solid, truth) > 0.999


def test_a_face_touched_in_two_places_is_one():
    truth, rng = placed(Cylinder(15.0, 40.0), 9)
    faces = touched_faces(truth, rng)
    again = touched_faces(truth, rng)
    found = assemble([*faces, again[1]], BOX)
    assert len(found.pieces) == 1
    assert len(set(found.surface_of_fit)) == 3


def test_a_plane_fitted_with_the_material_before_it_is_turned_round():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 10)
    faces = touched_faces(truth, rng)
    fit = faces[0].fit
    back = replace(outward(replace(fit, convex=False)), convex=False)
    again = outward(back)
    assert np.allclose(again.shape.normal, fit.shape.normal)
    assert np.allclose(again.covariance, fit.covariance)
    found = assemble([Touched(back, faces[0].contacts), *faces[1:]], BOX)
    assert iou(found.solid, truth) > 0.999


def test_a_through_hole_is_subtracted():
    truth, rng = placed(build("plate_with_hole"), 11)
    found = assemble(touched_faces(truth, rng), BOX)
    assert iou(found.solid, truth) > 0.999
    told = describe_primitives(found)
    assert [p["operation"] for p in told] == ["add", "subtract"]
    block, hole = (leaf.primitive.name for leaf in written_tree(found).leaves())
    assert block.startswith("primitive 0: cube, extent +- ")
    assert hole.startswith("primitive 1: cylinder, taken away, radius +- ")
    assert f"{told[1]['sigma']['radius_mm']:.2g} mm" in hole
    assert hole.endswith(" x ? mm")  # nobody needs to know how far it goes on past the plate


def test_the_tree_does_not_depend_on_the_run():
    truth, rng = placed(Cylinder(12.0, 40.0) & Sphere(21.0), 12)
    faces = touched_faces(truth, rng)
    assert repr(assemble(faces, BOX).tree) == repr(assemble(faces, BOX).tree)


def test_an_edge_is_measured_where_a_trace_ran_along_it():
    truth, rng = placed(Cube((60.0, 40.0, 30.0)), 13)
    found = assemble(touched_faces(truth, rng), BOX)
    boundary = link(found)
    ends = boundary.brep.edges[3].points
    points = ends[0] + np.linspace(0.1, 0.9, 9)[:, None] * (ends[-1] - ends[0])
    trace = EdgeTrace(points, points, points, np.full(9, 0.1), False, 0, 0)
    status = [e["status"] for e in describe_edges(found, boundary, [trace])]
    assert status.count("measured") == 1
    assert status[3] == "measured"

"""A smooth body through all that was felt, where faces tell too little of it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from models.boundary import boundary
from models.formats.openscad import write
from models.part import load_part
from models.solid import Solid, iou
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from recognition.assembly import NotClosed
from recognition.assembly.described import describe_primitives, link, written_tree
from recognition.best_body import FeltFace, best_body
from recognition.freeform import bends, freeform
from recognition.hulled import hulled

BOX = np.array([[-100.0] * 3, [100.0] * 3])
AXES = np.array([45.0, 32.0, 25.0])
NOTHING = NotClosed("no face was felt")


def ways(count, seed=0):
    rows = np.random.default_rng(seed).normal(size=(count, 3))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def egg(count=600, seed=0, noise=0.03, semi=AXES):
    """Contacts on an ellipsoid, six of each touch."""
    points = semi * ways(count, seed)
    normals = points / semi**2
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    off = noise * np.random.default_rng(seed + 1).normal(size=(count, 1))
    return Contacts.of(points + off * normals, normals, noise, 0.02, touch=np.arange(count) // 6)


def ellipsoid(semi=AXES):
    points = semi * ways(20_000, 7)
    hull = ConvexHull(points)
    a, b, c = np.moveaxis(points[hull.simplices], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    return Solid.from_mesh(points, np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices))


def bottom(below=-10.0, touches=9):
    steps = np.linspace(-0.85, 0.85, 9)
    points = np.array([[45.0 * x, 32.0 * y, below] for x in steps for y in steps if np.hypot(x, y) < 0.9])
    down = np.tile([0.0, 0.0, -1.0], (len(points), 1))
    touch = 1000 + np.arange(len(points)) * touches // len(points)
    felt = Contacts.of(points, down, 0.01, 0.005, touch=touch)
    return FeltFace(fit("plane", felt), felt)


def test_an_ellipsoid_is_one_freeform_face():
    body = best_body([], BOX, None, 15.0, egg())
    assert body.whole
    assert iou(body.assembly.solid, ellipsoid()) > 0.99
    boundary = link(body.assembly)
    assert [face.shape for face in boundary.brep.faces] == [None]
    (entry,) = describe_primitives(body.assembly)
    assert entry["kind"] == "mesh"
    off = body.assembly.solid.signed_distance(egg(seed=9, noise=0.0).points)
    assert 0.5 < entry["sigma"]["surface_mm"] / np.sqrt(np.mean(off**2)) < 4.0
    assert "smooth mesh" in body.assembly.warnings[0]


def test_what_bends_is_told_from_what_has_edges():
    each = np.arange(600)
    own = egg()
    cloud = Contacts.of(own.points, own.normals, 0.03, 0.02, touch=each)
    assert bends([], cloud)
    axis = each % 3
    side = np.where(each // 3 % 2, 1.0, -1.0)
    points = np.random.default_rng(0).uniform(-20.0, 20.0, size=(600, 3))
    points[each, axis] = 20.0 * side
    block = Contacts.of(points, side[:, None] * np.eye(3)[axis], 0.03, 0.02, touch=each)
    assert not bends([], block)


def test_what_half_of_was_never_felt_closes_no_body():
    contacts = egg()
    upper = contacts.select(contacts.points[:, 2] > 2.0)
    assert isinstance(best_body([], BOX, None, 15.0, upper).assembly, NotClosed)


@pytest.mark.parametrize("count", [30, 60])
def test_a_few_scattered_contacts_tell_more_than_their_hull(count):
    own = egg(count, noise=0.3)
    cloud = Contacts.of(own.points, own.normals, 0.3, 0.05, touch=np.arange(count))
    found, hull = freeform([], cloud, NOTHING), hulled([], cloud, NOTHING)
    assert iou(found.solid, ellipsoid()) > 0.93
    assert hull is None or iou(hull.solid, ellipsoid()) < 0.85
    assert found.mesh_sigma > 0.3
    body = best_body([], BOX, None, 15.0, cloud)
    assert not body.whole
    assert "counts as open" in body.assembly.warnings[-1]


@pytest.mark.parametrize("touches", [7, 2])
def test_a_flat_bottom_stays_flat(touches):
    contacts = egg()
    upper = contacts.select(contacts.points[:, 2] > -8.0)
    flat = bottom(touches=touches)
    body = best_body([flat], BOX, None, 15.0, upper)
    assert body.whole
    assert [piece.kind for piece in body.assembly.pieces] == ["mesh", "cube"]
    assert abs(body.assembly.solid.bounds[0, 2] + 10.0) < 0.02
    kinds = [face.shape and face.shape.kind for face in link(body.assembly).brep.faces]
    assert sorted(map(str, kinds)) == ["None", "plane"]
    assert body.assembly.surface_of_fit == (0,)
    capped = 1.0 - 10.0 / 25.0 - (1.0 - (10.0 / 25.0) ** 3) / 3.0  # of the half below, past the bottom
    assert abs(body.assembly.solid.volume / (np.pi * np.prod(AXES) * (4.0 / 3.0 - capped)) - 1.0) < 0.01


def test_nothing_is_where_an_array_went():
    waist = egg(semi=np.array([20.0, 20.0, 45.0]))
    ends = waist.select(np.abs(waist.points[:, 2]) > 15.0)
    round_it = np.array(
        [[16.0 * np.cos(t), 16.0 * np.sin(t), z] for t in np.arange(0, 6.2, 0.3) for z in (-5, 0, 5)]
    )
    full = freeform([], ends, NOTHING)
    less = freeform([], ends, NOTHING, round_it)
    assert full.solid.signed_distance(round_it).max() < -1.0
    assert less.solid.signed_distance(round_it).min() > -0.5


def test_a_hole_that_only_passes_is_none_of_a_body():
    contacts = egg(1000)
    contacts = contacts.select(np.linalg.norm(contacts.points[:, :2], axis=1) > 12.0)
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    way = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    for aside, is_hole in ((0.0, True), (55.5, False)):
        points = 12.0 * way + np.outer(np.cos(9.0 * turn), [0.0, 0.0, 20.0]) + [aside, 0.0, 0.0]
        lot = Contacts.of(points, -way, 0.02, 0.02, touch=np.full(60, NOT_FELT))
        found = freeform([FeltFace(fit("cylinder", lot), lot)], contacts, NOTHING)
        assert ("cylinder" in [piece.kind for piece in found.pieces]) == is_hole


def test_what_is_explained_or_was_not_felt_has_none():
    contacts = egg()
    body = best_body([], BOX, None, 15.0, contacts).assembly
    assert freeform([], contacts, body) is None
    assert freeform([], replace(contacts, touch=np.full(len(contacts), NOT_FELT)), NOTHING) is None
    bare = Contacts.of(contacts.points, sigma=0.03, touch=contacts.touch)
    assert freeform([], bare, NOTHING) is None


def test_the_hull_of_sharp_facets_is_kept():
    facing, places = ways(12, 5), ways(900, 6)
    reach, face = 30.0 / (places @ facing.T).max(axis=1), (places @ facing.T).argmax(axis=1)
    contacts = Contacts.of(reach[:, None] * places, facing[face], 0.01, 0.01, touch=np.arange(900) // 6)
    sides = [FeltFace(fit("plane", own), own) for k in range(2) for own in [contacts.select(face == k)]]
    body = best_body(sides, BOX, None, 15.0, contacts.select(face > 1))
    assert [piece.kind for piece in body.assembly.pieces] == ["polyhedron"]


def test_a_hull_is_beaten_by_what_lies_nearer_contacts_kept_apart_and_no_polyhedron_is():
    contacts = egg(noise=0.005)
    whole = hulled([bottom()], contacts, NOTHING)
    assert freeform([], contacts, whole, is_hull=True) is not None
    assert freeform([], contacts, whole) is None  # as good as what named faces make


def test_what_stands_on_a_table_goes_down_to_it():
    contacts = egg()
    upper = contacts.select(contacts.points[:, 2] > -8.0)
    corners = np.array([[x, y, -12.0] for x in (-30.0, 30.0) for y in (-20.0, 20.0)])
    table = Contacts.of(corners, np.tile([0.0, 0.0, -1.0], (4, 1)), 0.05, 0.02, touch=NOT_FELT)
    body = best_body([FeltFace(fit("plane", table), table)], BOX, None, 15.0, upper)
    assert [piece.kind for piece in body.assembly.pieces] == ["mesh", "cube"]
    assert abs(body.assembly.solid.bounds[0, 2] + 12.0) < 0.01
    assert not body.whole  # nobody felt what lies on the table


@pytest.mark.parametrize("semi", [(60.0, 30.0, 3.0), (70.0, 9.0, 6.0)])
def test_what_is_thin_is_meshed_as_finely(semi):
    contacts = egg(1500, semi=np.array(semi))
    made = freeform([], contacts, NOTHING)
    off = np.abs(made.solid.signed_distance(contacts.points))
    assert np.percentile(off, 95.0) < 0.5
    assert np.percentile(off, 68.0) < 1.5 * made.mesh_sigma
    assert abs(made.solid.volume / (4.0 / 3.0 * np.pi * np.prod(semi)) - 1.0) < 0.03


def test_what_is_too_thin_for_the_grid_is_not_meshed_wrong():
    contacts = egg(1500, semi=np.array([200.0, 4.0, 1.9]))
    made = freeform([], contacts, NOTHING)
    assert made is None or abs(made.solid.volume / (4.0 / 3.0 * np.pi * 200.0 * 4.0 * 1.9) - 1.0) < 0.05


def test_few_contacts_all_round_are_enough():
    made = freeform([], egg(100), NOTHING)
    assert abs(made.solid.volume / (4.0 / 3.0 * np.pi * np.prod(AXES)) - 1.0) < 0.02


def test_a_mesh_that_goes_on_past_all_contacts_is_none():
    contacts = egg()
    assert freeform([], contacts.select(contacts.points[:, 2] > 2.0), NOTHING) is None


def test_what_is_written_is_read_again_as_one_freeform_face(tmp_path):
    made = freeform([], egg(), NOTHING)
    write(written_tree(made), tmp_path / "egg.csg")
    again = load_part(tmp_path / "egg.csg").solid
    assert abs(again.volume / made.solid.volume - 1.0) < 1e-3
    assert [face.shape for face in boundary(again).faces] == [None]


def test_contacts_without_normals_are_held_against_it_too():
    contacts, far = egg(), Contacts.of(1.3 * AXES * ways(300, 4), sigma=0.03)
    assert freeform([], Contacts.concatenate([contacts, far]), NOTHING) is None
    near = Contacts.of(AXES * ways(300, 4), sigma=0.03)
    assert freeform([], Contacts.concatenate([contacts, near]), NOTHING) is not None


@pytest.mark.parametrize(("times", "made"), [(1, True), (30, False)])
def test_a_smooth_body_is_made_of_more_than_a_few_contacts_beside_flat_faces(times, made):
    """Where faces have closed a body, be that as poor as a box round half an egg."""
    contacts, below = egg(240), bottom()
    contacts = contacts.select(contacts.points[:, 2] > -9.5)
    more = [replace(below.contacts, touch=below.contacts.touch + 100 * k) for k in range(times)]
    flat = Contacts.concatenate(more)
    sides = [below]
    for way in (*np.eye(3), *-np.eye(3)[:2]):
        rows = np.random.default_rng(0).uniform(-0.9, 0.9, (30, 3)) * AXES
        rows += np.outer(AXES @ np.abs(way) - rows @ way, way)
        lot = Contacts.of(rows, np.tile(way, (30, 1)), 0.01, 0.005)
        sides.append(FeltFace(fit("plane", lot), lot))
    box = best_body(sides, BOX, None, 15.0).assembly
    face = FeltFace(fit("plane", flat), flat)
    assert (freeform([face], Contacts.concatenate([contacts, flat]), box) is not None) is made

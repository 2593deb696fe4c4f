"""Which face contacts belong to, and when they make a new one."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.faces.attribution import CONVEX, AttributionConfig, known_face, name_loose, take_in
from exploration.planning.faces.consistency import concave, drop_false, drop_rims
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cone, Torus

CONFIG = AttributionConfig()
NONE = Contacts.of(np.empty((0, 3)))


def side(axis, sign, n=30, seed=0, half=15.0, middle=(0.0, 0.0, 0.0), reach=14.0):
    rng = np.random.default_rng(seed)
    points = np.array(middle) + rng.uniform(-reach, reach, (n, 3))
    points[:, axis] = sign * half + 0.005 * rng.standard_normal(n)
    return Contacts.of(points, sign * np.eye(3)[[axis] * n], sigma=0.01, normal_sigma=0.005, touch=seed)


@pytest.fixture
def corner():
    """Two sides of a block."""
    graph = PatchGraph(options=CONVEX)
    for contacts in (side(2, 1.0), side(0, 1.0, seed=1)):
        graph = take_in(graph, NONE, contacts, CONFIG).graph
    assert [face.fit.kind for face in graph.faces] == ["plane", "plane"]
    return graph


def test_contacts_go_to_the_faces_that_they_lie_on(corner):
    mixed = Contacts.concatenate([side(2, 1.0, n=12, seed=2), side(0, 1.0, n=7, seed=3)])
    taken = take_in(corner, NONE, mixed, CONFIG)
    assert [len(face.contacts) for face in taken.graph.faces] == [42, 37]
    assert taken.home == corner.faces[0].id
    assert len(taken.loose) == 0


def test_contacts_that_no_face_explains_make_a_new_one(corner):
    taken = take_in(corner, NONE, side(1, 1.0, seed=4), CONFIG)
    assert len(taken.graph.faces) == 3
    assert taken.home == taken.graph.faces[-1].id


def test_the_few_contacts_of_a_small_face_add_up_over_visits(corner):
    """A tip of 6 mm, felt once a visit, among twenty contacts of the side that the pad slid onto."""
    graph, loose = corner, NONE
    for visit in range(10, 17):
        tip = side(1, 1.0, n=1, seed=visit, reach=3.0)
        taken = take_in(
            graph, loose, Contacts.concatenate([tip, side(2, 1.0, n=20, seed=visit + 50)]), CONFIG
        )
        graph, loose = taken.graph, taken.loose
    assert len(graph.faces) == 3
    assert np.abs(graph.faces[-1].fit.shape.direction[1]) > 0.99


def test_a_face_is_known_again_by_its_place_and_its_facing(corner):
    assert known_face(corner, side(0, 1.0, n=5, seed=7), CONFIG) == corner.faces[1].id
    turned = side(0, 1.0, n=5, seed=7)
    turned = Contacts.of(turned.points, np.eye(3)[[1] * 5], sigma=0.01, normal_sigma=0.005)
    assert known_face(corner, turned, CONFIG) is None
    assert known_face(corner, NONE, CONFIG) is None


def test_poor_contacts_of_one_touch_make_no_face(corner):
    rim = side(1, 1.0, n=6, seed=30, reach=3.0)
    rim = Contacts.of(rim.points, rim.normals, sigma=0.06, normal_sigma=0.1, touch=30)
    once = take_in(corner, NONE, rim, CONFIG)
    assert (len(once.graph.faces), len(once.loose)) == (2, 6)
    again = Contacts.of(
        rim.points + np.array([0.0, 0.0, 1.0]), rim.normals, sigma=0.06, normal_sigma=0.1, touch=31
    )
    assert len(take_in(once.graph, once.loose, again, CONFIG).graph.faces) == 3


def test_contacts_of_a_face_that_goes_are_not_lost(corner):
    beyond = side(2, 1.0, n=12, seed=40, half=14.0, reach=4.0)
    taken = take_in(corner, NONE, beyond, CONFIG)
    held = sum(len(face.contacts) for face in taken.graph.faces) + len(taken.loose)
    assert held == 30 + 30 + 12


@pytest.mark.parametrize("seed", [1, 2, 3, 6])
def test_a_ball_felt_at_one_end_gets_a_contact_of_the_other(seed):
    def cap(way, touch, n):
        rng = np.random.default_rng([seed, touch])
        out = way + 0.2 * rng.standard_normal((n, 3))
        out /= np.linalg.norm(out, axis=1)[:, None]
        away = 28.0 + 0.02 * rng.standard_normal(n)
        return Contacts.of(away[:, None] * out, out, sigma=0.02, normal_sigma=0.03, touch=touch)

    graph = PatchGraph(options=CONVEX)
    graph = take_in(graph, NONE, cap(np.array([0.0, 0.0, 1.0]), 1, 10), CONFIG).graph
    far = cap(np.array([0.0, 0.0, -1.0]), 2, 1)
    assert [face.fit.kind for face in graph.faces] == ["sphere"]
    assert abs(graph.faces[0].fit.shape.signed_distance(far.points)[0]) > 0.2
    taken = take_in(graph, NONE, far, CONFIG)
    assert [len(face.contacts) for face in taken.graph.faces] == [11]
    assert abs(taken.graph.faces[0].fit.shape.radius - 28.0) < 0.06


def test_what_a_pad_reads_on_a_rim_is_no_face_of_a_hollow_object(corner):
    """Beside the rim of the upper side, turned by 30 degrees: as a pad lies from there to the edge of a step."""
    hollow = AttributionConfig(convex=False)
    along = np.linspace(-12.0, 12.0, 9)
    rows = np.concatenate(
        [np.column_stack([along, np.full(9, -14.5 - s), np.full(9, 15.0 - 0.58 * s)]) for s in (0.0, 0.7)]
    )
    tilted = np.tile([0.0, -0.5, np.sqrt(0.75)], (len(rows), 1))
    taken = take_in(corner, NONE, Contacts.of(rows, tilted, sigma=0.03, normal_sigma=0.01, touch=7), hollow)
    assert len(taken.graph.faces) == 2
    assert len(taken.loose) == len(rows)
    farther = Contacts.of(
        rows + np.outer(np.arange(18) % 6, [0.0, -2.0, -1.155]), tilted, 0.03, 0.01, touch=8
    )
    assert len(take_in(corner, NONE, farther, hollow).graph.faces) == 3


@pytest.mark.parametrize(
    ("lean", "before", "kept"),
    [
        (0.19, 0.25, False),
        (0.0, 0.3, True),  # a step
        (0.19, 0.0, True),  # a bevel, 2.5 mm wide
        (0.1, 0.0, True),
    ],
)
def test_a_pad_that_leans_over_a_plates_edge_reads_no_face_of_its_own(lean, before, kept):
    """Its contacts are before the plate, too, by so many mm at most."""
    x, y = np.meshgrid(np.linspace(-20.0, 20.0, 6), np.linspace(-20.0, 20.0, 6))
    top = Contacts.of(np.column_stack([x.ravel(), y.ravel(), np.zeros(36)]), np.eye(3)[[2] * 36], 0.02, 0.01)
    graph, home = PatchGraph(options=CONVEX).add_stroke(top)
    along, across = np.linspace(-12.0, 12.0, 8), np.tile([19.0, 21.5], 4)
    places = np.column_stack([across, along, before - np.tan(lean) * (across - 19.0)])
    ways = np.tile([np.sin(lean), 0.0, np.cos(lean)], (8, 1))
    leaning = Contacts.of(places, ways, sigma=0.03, normal_sigma=0.01, touch=5)
    graph = PatchGraph((*graph.faces, Face(9, fit("plane", leaning), leaning)), options=CONVEX)
    assert [face.id for face in drop_rims(graph).faces] == ([home, 9] if kept else [home])


def test_a_ring_is_a_torus_and_what_is_read_flat_off_its_crest_goes():
    """A crest of 7 mm radius fills so few taxels across that some frames are read as a strip of a plane."""
    rng = np.random.default_rng(3)
    ring = Torus([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 35.0, 7.0)
    round_, tube = rng.uniform(0.0, 2.0 * np.pi, 90), rng.uniform(-1.0, 2.0, 90)
    way = np.column_stack([np.cos(round_), np.sin(round_), np.zeros(90)])
    normals = np.cos(tube)[:, None] * way + np.sin(tube)[:, None] * [0.0, 0.0, 1.0]
    points = 35.0 * way + (7.0 + 0.01 * rng.standard_normal(90))[:, None] * normals
    sides = Contacts.of(points, normals, sigma=0.02, normal_sigma=0.02, touch=np.arange(90) // 30)
    graph, home = PatchGraph(options=CONVEX).add_stroke(sides)
    assert graph.face(home).fit.kind == "torus"
    assert concave(graph)
    crest = 35.0 * way[:20] + rng.uniform(-1.5, 1.5, 20)[:, None] * way[:20] + [0.0, 0.0, 6.95]
    flat = Contacts.of(crest, np.eye(3)[[2] * 20], sigma=0.03, normal_sigma=0.01, touch=5)
    graph = PatchGraph((*graph.faces, Face(9, fit("plane", flat), flat)), options=CONVEX)
    assert np.abs(ring.signed_distance(crest)).max() < 0.3
    assert [face.id for face in drop_rims(graph).faces] == [home]


def countersink(azimuth):
    """What a fingertip feels at one place of a countersink of 45 degrees: a place, and three beside it."""
    cone, ways = Cone([0.0, 0.0, -6.0], [0.0, 0.0, 1.0], np.pi / 4), azimuth + np.array([0.0, -0.1, 0.1, 0.0])
    rho = 11.0 + np.array([0.0, 0.0, 0.0, 1.0])
    points = np.column_stack([rho * np.cos(ways), rho * np.sin(ways), rho - 6.0])
    return Contacts.of(points, -cone.normals(points), sigma=0.05, normal_sigma=0.04, touch=int(10 * azimuth))


def test_places_of_a_countersink_that_face_every_way_make_it_known():
    hollow = AttributionConfig(convex=False)
    graph, loose = PatchGraph(options=CONVEX), NONE
    for azimuth in (0.0, 1.6, 3.2):
        assert not graph.faces
        taken = take_in(graph, loose, countersink(azimuth), hollow)
        graph, loose = taken.graph, taken.loose
    (face,) = graph.faces
    assert not face.fit.convex
    assert np.abs(face.fit.shape.signed_distance(countersink(4.5).points)).max() < 0.1


def test_contacts_that_scatter_too_far_make_no_face_of_a_hollow_object():
    rng, flat = np.random.default_rng(8), side(2, 1.0, n=10)
    points = flat.points + 0.4 * rng.standard_normal((10, 3))
    poor = Contacts.of(points, flat.normals, sigma=0.5, normal_sigma=0.3, touch=np.arange(10) // 5)
    graph, home = PatchGraph(options=CONVEX).add_stroke(poor)
    assert graph.face(home).fit.rms > 0.15
    assert not drop_false(graph).faces


def test_a_ring_felt_here_and_there_is_known_once_all_that_is_loose_is_seen_together():
    rng = np.random.default_rng(5)
    ring = Torus([3.0, 0.0, 0.0], [0.0, 0.6, 0.8], 22.0, 6.0)
    touch = np.repeat(np.arange(20), 2)
    points = ring.project(np.array([3.0, 0.0, 0.0]) + rng.uniform(-28.0, 28.0, (40, 3)))
    loose = Contacts.of(points, ring.normals(points), sigma=0.06, normal_sigma=0.1, touch=touch)
    corner_read_badly = side(2, 1.0, n=8, seed=30, half=60.0)
    points = corner_read_badly.points + 0.4 * rng.standard_normal((8, 3))
    poor = Contacts.of(
        points, corner_read_badly.normals, sigma=0.5, normal_sigma=0.3, touch=np.arange(8) + 40
    )
    taken = name_loose(PatchGraph(options=CONVEX), Contacts.concatenate([loose, poor]), AttributionConfig())
    (face,) = taken.graph.faces
    assert face.fit.kind == "torus"
    assert face.fit.shape.sizes == pytest.approx((22.0, 6.0), abs=0.1)
    assert len(taken.loose) == 8


@pytest.mark.parametrize(("sigma", "faces"), [(0.011, 3), (0.017, 2)])
def test_one_flush_frame_makes_a_narrow_face_where_it_shows_nothing_else(corner, sigma, faces):
    flush = replace(side(1, 1.0, n=4, seed=5, reach=2.0), sigma=np.full(4, sigma))
    taken = take_in(corner, NONE, flush, AttributionConfig(convex=False))
    assert len(taken.graph.faces) == faces
    assert len(taken.loose) == (0 if faces == 3 else 4)


@pytest.mark.parametrize("convex", [True, False])
def test_a_pad_that_came_down_askew_spoils_no_face_that_it_felt_afterwards(convex):
    askew = np.array([0.22, 0.0, 0.976]) / np.hypot(0.22, 0.976)
    first = np.array([[-8.3, 1.9, 12.2], [-20.9, 12.3, 15.1], [-22.6, 3.3, 15.5], [-20.9, -9.3, 15.1]])
    strays = Contacts.of(first, np.tile(askew, (4, 1)), 0.027, 0.004, touch=5)
    top = replace(side(2, 1.0, n=50, seed=5), touch=np.full(50, 5))
    own = replace(CONFIG, convex=convex)
    taken = take_in(PatchGraph(options=CONVEX), NONE, Contacts.concatenate([strays, top]), own)
    (face,) = taken.graph.faces
    assert taken.home == face.id
    assert face.fit.kind == "plane"
    assert abs(float(face.fit.shape.normal @ [0.0, 0.0, 1.0])) > 0.9999
    assert len(face.contacts) == 50
    assert len(taken.loose) == 4

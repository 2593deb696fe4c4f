"""Grooves round a cylinder, from images of a pad that lay along it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import erf

from exploration.planning.inferring.concluding import _add_groove
from exploration.planning.inferring.grooves import grooves
from exploration.planning.inferring.hole_walls import add_holes
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Findings
from exploration.sensing.frame import TaxelArray
from primitives.cylinder import Cylinder
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose, transform_points
from primitives.torus import Torus

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
RADIUS, SIGMA, SPREAD = 20.0, 0.03, 1.0
X = np.eye(3)[0]
ROUND = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]


def wall(*rims):
    """Along x between rims: there before the first, missing up to the second, and so on, as rubber shows it."""
    return lambda x, turn: (
        1.0
        - sum(
            (-1) ** k * 0.5 * (1.0 + erf((x - rim) / (np.sqrt(2.0) * SPREAD))) for k, rim in enumerate(rims)
        )
    )


def out_at(turn):
    return np.array([0.0, np.cos(turn), np.sin(turn)])


def looked(there, turns=ROUND, places=(-6.0, 0.0, 6.0)):
    """A pad that lay along the cylinder at turns round it and places along it."""
    mosaic, rng = Mosaic(), np.random.default_rng(1)
    for turn in turns:
        out = out_at(turn)
        frame = np.column_stack([X, np.cross(-out, X), -out])
        for at in places:
            where = pose(frame, (RADIUS - 0.8) * out + at * X)
            x, y = np.meshgrid(ARRAY.x, ARRAY.y)
            taxels = transform_points(where, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
            before = np.maximum(RADIUS - np.hypot(taxels[:, 1], taxels[:, 2]), 0.0)
            depth = (before * there(taxels[:, 0], turn)).reshape(ARRAY.shape)
            seen = SimpleNamespace(
                array=ARRAY,
                depth=depth + SIGMA * rng.normal(size=depth.shape),
                sigma=np.full(ARRAY.shape, SIGMA),
                spread=SPREAD,
            )
            mosaic.look(SimpleNamespace(image=seen, world_from_sensor=where))
    return mosaic


def known(convex=True):
    turns, along = (lot.ravel() for lot in np.meshgrid(ROUND, [-15.0, -12.0, 12.0, 15.0]))
    out = np.column_stack([0.0 * turns, np.cos(turns), np.sin(turns)])
    contacts = Contacts.of(RADIUS * out + along[:, None] * X, out if convex else -out)
    face = ranked_face(0, contacts, MergeOptions())
    return KnownFace(face, face.fit, 1.0 if convex else -1.0, contacts.points, np.empty((0, 3)))


@pytest.mark.parametrize(("low", "high"), [(-3.0, 4.0), (-2.0, 2.5), (-6.0, 5.0)])
def test_a_gap_all_round_is_a_groove_half_as_deep_as_wide(low, high):
    own = known()
    (groove,) = grooves([own], [own.face], looked(wall(low, high)))
    ring = fit("torus", groove.contacts)
    assert not ring.convex
    assert abs(float(ring.shape.direction @ X)) > 0.999
    assert float(ring.shape.center @ X) == pytest.approx(0.5 * (low + high), abs=0.2)
    assert ring.shape.radius == pytest.approx(RADIUS, abs=0.1)
    assert ring.shape.minor_radius == pytest.approx(0.5 * (high - low), abs=0.2)
    assert (groove.contacts.touch == NOT_FELT).all()
    assert not groove.instead


def test_what_is_missing_of_the_wall_in_a_groove_is_the_groove_and_no_hole():
    own = known()
    (groove,) = grooves([own], [own.face], looked(wall(-3.0, 4.0)))
    out = out_at(1.0)
    assert groove.holds(RADIUS * out + 1.0 * X)
    assert not groove.holds(RADIUS * out + 7.0 * X)
    assert not groove.holds(0.5 * RADIUS * out)
    mouth = RoundRim(RADIUS * out, out, 4.0, 0.3, own.face.id, True, bent=True)
    for images, wanted in ((looked(wall(-3.0, 4.0)), 0), (Mosaic(), 1)):
        found = Findings(graph=PatchGraph((own.face,)))
        now = SimpleNamespace(openings=[], narrow=[], round_gaps=[mouth], known=[own])
        add_holes(found, lambda now=now: now, np.empty((0, 3)), images)
        assert len(found.openings) == wanted


def test_two_grooves_are_two():
    own = known()
    lots = grooves(
        [own], [own.face], looked(wall(-8.0, -4.0, 3.0, 7.0), places=(-12.0, -6.0, 0.0, 6.0, 12.0))
    )
    assert len(lots) == 2


def test_what_is_a_gap_from_some_sides_alone_or_was_looked_at_from_one_is_no_groove():
    own, groove = known(), wall(-3.0, 4.0)
    assert grooves([own], [own.face], looked(groove, turns=ROUND[:4])) == []
    unseen = looked(groove, places=(-16.0, 18.0))  # nobody looked where the gap ends
    assert grooves([own], [own.face], unseen) == []

    def keyway(x, turn):
        return groove(x, turn) if abs(turn - ROUND[2]) < 0.5 else 1.0 + 0.0 * x

    assert grooves([own], [own.face], looked(keyway)) == []
    assert grooves([own], [own.face], Mosaic()) == []


def test_an_end_of_the_wall_a_bore_and_a_gap_in_which_something_was_felt_are_none():
    own, groove = known(), looked(wall(-3.0, 4.0))
    assert grooves([own], [own.face], looked(wall(4.0))) == []
    assert grooves([known(convex=False)], [own.face], groove) == []
    out = np.array([out_at(turn) for turn in ROUND])
    for deep, count in (
        (0.5, 1),
        (0.8, 0),
        (2.0, 0),
        (6.0, 0),
        (12.0, 0),
    ):  # in the air, where skin came to 0.8
        floor = ranked_face(1, Contacts.of((RADIUS - deep) * out, out), MergeOptions())
        assert len(grooves([own], [own.face, floor], groove)) == count
    beside = ranked_face(1, Contacts.of((RADIUS - 2.0) * out + 9.0 * X, out), MergeOptions())
    bore = ranked_face(1, Contacts.of(8.0 * out, -out), MergeOptions())
    assert len(grooves([own], [own.face, beside, bore], groove)) == 1
    assert isinstance(own.fit.shape, Cylinder)


def test_a_ring_that_leans_was_read_by_a_pad_on_the_walls_beside_the_groove():
    own, turns = known(), np.linspace(0.0, 2.0, 12)
    out = np.array([out_at(turn) for turn in turns])
    felt = Contacts.of((RADIUS - 0.2) * out + np.where(np.arange(12) % 2, -4.0, 5.0)[:, None] * X, out, 0.06)
    made = fit("cylinder", felt)
    read = {
        lean: Face(7, replace(made, shape=Torus([0.5, 0.0, 0.0], [1.0, lean, 0.0], 60.0, 40.0)), felt)
        for lean in (0.0, 0.1)
    }
    seen = looked(wall(-3.0, 4.0))
    assert [groove.instead for groove in grooves([own], [own.face, read[0.1]], seen)] == [{7}]
    assert [groove.instead for groove in grooves([own], [own.face, read[0.0]], seen)] == [set()]


def bottom(depth, width, touches=6):
    """Contacts of a fingertip near the bottom of a groove that is round across, from -width / 2 to width / 2."""
    radius = (0.25 * width**2 + depth**2) / (2.0 * depth)
    lean = np.linspace(-0.2, 0.15, touches)
    out = np.array([out_at(turn) for turn in np.linspace(0.0, 1.5, touches)])
    points = (RADIUS - depth + radius * (1.0 - np.cos(lean)))[:, None] * out
    points = points - radius * np.sin(lean)[:, None] * X
    return Contacts.of(points, np.cos(lean)[:, None] * out + np.sin(lean)[:, None] * X, 0.02)


@pytest.mark.parametrize("depth", [2.5, 4.0, 4.6])
def test_a_round_bottom_that_was_felt_tells_how_deep_the_groove_is(depth):
    own, width = known(), 8.0
    floor = ranked_face(1, bottom(depth, width), MergeOptions())
    inferred = Contacts.of([[1.0, RADIUS - 1.0, y] for y in (-1.0, 0.0, 1.0)], [X] * 3, touch=NOT_FELT)
    wall_in_it = ranked_face(2, inferred, MergeOptions())
    (groove,) = grooves([own], [own.face, floor, wall_in_it], looked(wall(-4.0, 4.0)))
    ring = fit("torus", groove.contacts).shape
    assert groove.felt
    assert groove.instead == {1, 2}
    assert ring.radius - ring.minor_radius == pytest.approx(RADIUS - depth, abs=0.1)
    assert ring.minor_radius == pytest.approx((16.0 + depth**2) / (2.0 * depth), abs=0.25)


def test_no_bottom_is_where_skin_came_and_felt_nothing():
    own, width = known(), 8.0
    sagged = ranked_face(1, bottom(0.6, width), MergeOptions())
    (groove,) = grooves([own], [own.face, sagged], looked(wall(-4.0, 4.0)))
    assert not groove.felt
    assert groove.bare == pytest.approx(0.8, abs=0.1)
    assert [face.id for face in groove.stands_beside([own.face, sagged])] == [0]


def test_a_bottom_that_skin_was_pressed_on_is_not_bare():
    own, width, depth = known(), 8.0, 4.0
    seen, touched = looked(wall(-4.0, 4.0)), looked(wall(-4.0, 4.0), turns=ROUND[:1])
    for image in touched._images:  # a fingertip in the groove, pressed by 0.4 mm
        deeper = replace(
            image, places=image.places - (depth - 0.4) * out_at(ROUND[0]), depth=image.depth + 0.4
        )
        seen._images.append(deeper)
    floor = ranked_face(1, bottom(depth, width), MergeOptions())
    (groove,) = grooves([own], [own.face, floor], seen)
    assert groove.felt
    assert groove.bare < 1.0


def test_a_flat_bottom_and_one_that_bends_otherwise_are_faces_of_their_own():
    own, seen = known(), looked(wall(-4.0, 4.0))
    out = np.array([out_at(turn) for turn in np.linspace(0.0, 1.5, 6)])
    flat = Contacts.of((RADIUS - 2.0) * out + np.linspace(-2.0, 2.0, 6)[:, None] * X, out, 0.02)
    for felt in (flat, bottom(2.0, 24.0), bottom(3.0, 4.0), bottom(6.0, 8.0)):
        floor = ranked_face(1, felt, MergeOptions())
        assert grooves([own], [own.face, floor], seen) == []


def test_a_plane_of_one_touch_over_a_groove_was_read_where_a_pad_sagged_into_it():
    own = known()
    beside = np.array([[x, RADIUS - 0.1, y] for x in (-5.0, 6.0) for y in (-2.0, 0.0, 2.0)])
    read = [ranked_face(1, Contacts.of(beside, [[0.0, 1.0, 0.0]] * 6, 0.05, touch=touch), MergeOptions())
            for touch in (3, [3, 3, 3, 4, 4, 4])]  # fmt: skip
    one_side = ranked_face(1, Contacts.of(beside[3:], [[0.0, 1.0, 0.0]] * 3, 0.05, touch=3), MergeOptions())
    seen = looked(wall(-3.0, 4.0))
    told = [groove.instead for face in (*read, one_side) for groove in grooves([own], [own.face, face], seen)]
    assert told == [{1}, set(), set()]


def test_a_contact_of_a_pad_on_both_walls_is_in_the_air_between_them():
    own, out = known(), np.array([out_at(turn) for turn in ROUND])
    across = ranked_face(
        3,
        Contacts.concatenate([own.face.contacts, Contacts.of(RADIUS * out[:2] + 0.5 * X, out[:2])]),
        MergeOptions(),
    )
    hanging = ranked_face(4, Contacts.of(RADIUS * out + 0.5 * X, out), MergeOptions())
    (groove,) = grooves([own], [own.face], looked(wall(-3.0, 4.0)))
    (left,) = groove.stands_beside([across, hanging])
    assert len(left.contacts) == len(left.fit.inliers) == len(own.face.contacts)
    assert (np.abs(left.contacts.points[:, 0]) > 10.0).all()
    assert groove.stands_beside([own.face]) == (own.face,)


def test_what_was_felt_of_the_bottom_is_the_grooves_alone():
    own = known()
    floor = bottom(4.0, 8.0)
    both = ranked_face(1, Contacts.concatenate([floor, own.face.contacts]), MergeOptions())
    (groove,) = grooves([own], [own.face, both], looked(wall(-4.0, 4.0)))
    assert groove.felt
    assert len(groove.stands_beside([both])[0].contacts) == len(own.face.contacts)


def test_a_groove_keeps_what_was_felt_of_it_and_other_faces_do_not():
    own, floor = known(), bottom(4.0, 8.0)
    faces = (own.face, ranked_face(1, floor, MergeOptions()))
    found = Findings(graph=PatchGraph(faces))
    (groove,) = grooves([own], faces, looked(wall(-4.0, 4.0)))
    _add_groove(found, groove)
    kept, ring = found.graph.faces
    assert kept == own.face
    assert ring.fit.kind == "torus"
    assert int((ring.contacts.touch != NOT_FELT).sum()) == len(floor)

"""What counts as explained when exploration concludes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.adding import add
from exploration.planning.inferring.concluding import conclude
from exploration.planning.inferring.explained_rims import unexplained
from exploration.planning.inferring.led_into import hollows_of, led_into, own_rim
from exploration.planning.inferring.turned_ends import turned_ends
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Findings
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.shapes import Cone, Sphere, Torus

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
    rim = Sighting(corner + 10.0 * Z, along, -out, Z, 0.05, 12.0), 0
    assert unexplained([rim], [face]) == [rim]
    assert unexplained([rim], [face, wall(2, np.pi / 3)[0]]) == []


def test_a_wall_that_is_inferred_elsewhere_does_not_explain_a_rim_and_one_that_was_felt_does():
    (face, out, along), far = wall(1, 0.0), 40.0
    rim = Sighting(18.0 * out + far * along + 10.0 * Z, along, -out, Z, 0.05, 12.0), 0
    guessed = replace(face, contacts=replace(face.contacts, touch=np.full(9, NOT_FELT)))
    assert unexplained([rim], [face]) == []
    assert unexplained([rim], [guessed]) == [rim]
    near = Sighting(18.0 * out + 10.0 * Z, along, -out, Z, 0.05, 12.0), 0
    assert unexplained([near], [guessed]) == []


@pytest.mark.parametrize(
    ("short", "above", "left"), [(0.0, 2.0, 0), (1.5, 2.0, 0), (2.0, 9.0, 1), (4.0, 2.0, 1), (-1.5, 2.0, 1)]
)
def test_no_wall_stands_at_the_rim_of_a_bevel_and_one_does_on_a_ledge_far_below_it(short, above, left):
    face, out, along = wall(1, 0.0)
    rim = Sighting((18.0 + short) * out + (8.0 + above) * Z, along, -out, Z, 0.05, 12.0), 0
    assert len(unexplained([rim], [face])) == left
    guessed = replace(face, contacts=replace(face.contacts, touch=np.full(9, NOT_FELT)))
    assert len(unexplained([rim], [guessed])) == (short != 0.0)


def test_a_flat_face_that_goes_over_into_a_round_one_has_no_rim_there():
    turn = np.linspace(0.2, 1.4, 20)
    ways = np.column_stack([np.sin(turn), np.cos(turn), np.zeros(20)])
    points = 10.0 * ways + np.outer(np.linspace(-9.0, 9.0, 20), Z)
    corner = ranked_face(1, Contacts.of(points, ways, 0.01, 0.02), MergeOptions())
    assert corner.fit.kind == "cylinder"
    x, y = np.eye(3)[:2]
    beside, past = ((Sighting(np.array([at, 10.0, 0.0]), Z, x, y, 0.05, 12.0), 0) for at in (2.0, 6.0))
    assert unexplained([beside, past], [corner]) == [past]


def test_the_other_flange_of_a_spool_goes_on_from_no_rim_of_the_first():
    """Both are on one cylinder, 40 mm apart."""
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    low, high = (
        ranked_face(
            number,
            Contacts.of(
                np.concatenate([20.0 * ring + (z + a) * Z for a in (0.0, 2.0, 4.0)]), np.tile(ring, (3, 1))
            ),
            MergeOptions(),
        )
        for number, z in ((1, 0.0), (2, 44.0))
    )
    x, y, _ = np.eye(3)
    rim = Sighting(20.0 * x + 5.0 * Z, y, Z, x, 0.05, 9.0), 1
    assert unexplained([rim], [low, high]) == [rim]
    beside = Sighting(20.0 * x + 40.0 * Z, y, Z, x, 0.05, 9.0), 1
    assert unexplained([beside], [low, high]) == []


def test_a_turned_face_that_ends_round_its_axis_ends_in_a_plane_upright_on_it():
    """A funnel's mouth, whose ring is too narrow to lie on, seen at two places of the cone outside it."""
    cone = Cone([0.0, 0.0, -18.2], Z, 0.58)
    around = np.linspace(0.0, 6.0, 12)
    points = cone.project(np.column_stack([30.0 * np.cos(around), 30.0 * np.sin(around), 20.0 + around]))
    face = ranked_face(3, Contacts.of(points, cone.normals(points), 0.02, 0.01), MergeOptions())

    def rim(way, slant=0.0):
        out = np.array([np.cos(way), np.sin(way), 0.0])
        point = cone.project((45.0 * out + 50.0 * Z)[None])[0]
        normal, along = cone.normals(point[None])[0], np.cross(Z, out)
        tangent = np.cos(slant) * along + np.sin(slant) * np.cross(normal, along)
        return Sighting(point, tangent, np.cross(normal, tangent), normal, 0.05, 8.0), 3

    seen = [rim(0.3), rim(2.8)]
    (end,) = turned_ends(seen, [face])
    assert np.abs(end.normals - np.sign(seen[0][0].outward @ Z) * Z).max() < 0.01
    assert np.abs(end.points[:, 2] - seen[0][0].point[2]).max() < 0.2
    assert np.linalg.norm(end.points[:, :2], axis=1).max() < np.linalg.norm(seen[0][0].point[:2])
    assert turned_ends([rim(0.3, slant=0.4)], [face]) == []


def test_a_round_opening_goes_on_to_the_countersink_behind_it():
    """Of 45 degrees, 10 mm down to where its radius is the opening's."""
    sink = Cone([0.0, 0.0, -6.0], Z, np.pi / 4)
    around = np.linspace(0.0, 6.0, 12)
    points = sink.project(np.column_stack([9.0 * np.cos(around), 9.0 * np.sin(around), 3.0 + 0.2 * around]))
    face = ranked_face(2, Contacts.of(points, -sink.normals(points), 0.02, 0.01), MergeOptions())
    assert (face.fit.kind, face.fit.convex) == ("cone", False)
    under = RoundRim(-10.0 * Z, -Z, 6.0, 0.05, 4, True)
    hole = led_into(under, hollows_of([face]))
    assert hole.depth == pytest.approx(10.0, abs=0.3)
    assert own_rim(RoundRim(8.0 * Z, Z, 14.0, 0.05, 5, True), [face])
    assert not own_rim(under, [face])
    assert led_into(replace(under, center=under.center + np.array([30.0, 0.0, 0.0])), [face]) is None


def test_a_hole_into_a_hollow_ends_there_though_an_array_went_in_from_the_other_side():
    hollow, around = Sphere(np.zeros(3), 30.0), np.linspace(0.0, 6.0, 30)
    points = hollow.project(np.column_stack([9.0 * np.cos(around), 9.0 * np.sin(around), 20.0 + around]))
    found, frontier = (
        Findings(),
        SimpleNamespace(openings=[], narrow=[], round_gaps=[], known=[], placed=list, ends=list),
    )
    found.graph, own = found.graph.add_stroke(Contacts.of(points, -hollow.normals(points), 0.02, 0.01))
    assert not found.graph.face(own).fit.convex
    top = np.array([[x, y, 35.0] for x in (-9.0, 0.0, 9.0) for y in (-9.0, 0.0, 9.0)])
    found.graph, lid = found.graph.add_stroke(Contacts.of(top, np.tile(Z, (9, 1))))
    found.rims = [RoundRim(35.0 * Z, Z, 6.0, 0.05, lid, True)]
    found.inside = [np.outer(np.arange(0.0, 35.0, 2.0), Z)]
    conclude(found, list, lambda: frontier, Mosaic())
    (hole,) = (face for face in found.graph.faces if (face.contacts.touch == NOT_FELT).all())
    assert hole.fit.kind == "cylinder"
    assert hole.contacts.points[:, 2].min() > 29.0


def test_a_round_hole_between_two_rims_is_known_before_it_is_asked_what_stopped_strokes():
    found = Findings()
    square = np.array([[x, y, 0.0] for x in (-25.0, 0.0, 25.0) for y in (-25.0, 0.0, 25.0)])
    for z, way in ((0.0, Z), (-20.0, -Z)):
        found.graph, own = found.graph.add_stroke(Contacts.of(square + z * Z, np.tile(way, (9, 1))))
        found.rims.append(RoundRim(z * Z, way, 9.0, 0.05, own, True))
    known = []
    frontier = SimpleNamespace(openings=[], narrow=[], round_gaps=[], known=[], placed=list, ends=list)
    conclude(
        found, lambda: known.append({f.fit.kind for f in found.graph.faces}) or [], lambda: frontier, Mosaic()
    )
    assert "cylinder" in known[0]


@pytest.mark.parametrize("bored", [True, False])
def test_two_mouths_in_a_tubes_wall_lead_into_its_bore_and_in_a_bars_through_it(bored):
    x, turn = np.eye(3)[0], np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    out = np.tile(np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)]), (3, 1))
    found = Findings()
    side = 25.0 * out + np.repeat([-15.0, 10.0, 15.0], 24)[:, None] * Z
    found.graph, barrel = found.graph.add_stroke(Contacts.of(side, out, 0.02, 0.01))
    ends = 20.0 * out[:24]
    for way in (1.0, -1.0):
        end = Contacts.of(ends + way * 20.0 * Z, np.tile(way * Z, (24, 1)), 0.02, 0.01)
        found.graph, own = found.graph.add_stroke(end)
        found.rims += [RoundRim(way * 20.0 * Z, way * Z, 10.0, 0.05, own, True)] if bored else []
    mouths = [RoundRim(way * 25.0 * x, way * x, 5.0, 0.3, barrel, True, bent=True) for way in (1.0, -1.0)]
    frontier = SimpleNamespace(openings=[], narrow=[], round_gaps=mouths, known=[], placed=list, ends=list)
    conclude(found, list, lambda: frontier, Mosaic())
    assert found.openings == []
    inferred = [face for face in found.graph.faces if (face.contacts.touch == NOT_FELT).all()]
    across = [face for face in inferred if abs(float(face.fit.shape.axis @ x)) > 0.99]
    assert len(inferred) - len(across) == (1 if bored else 0)
    depth = np.abs(np.concatenate([face.contacts.points for face in across]) @ x)
    assert depth.max() > 15.0
    assert (depth.min() > 10.0) == bored


def ring_with_rims():
    """A ring whose crests passed for flat faces, and the rims that these seemed to have round its middle."""
    ring, rng = Torus(np.zeros(3), Z, 22.0, 6.0), np.random.default_rng(3)
    points = ring.project(rng.uniform(-28.0, 28.0, (90, 3)))
    found = Findings()
    contacts = Contacts.of(points, ring.normals(points), 0.02, 0.02, touch=np.arange(90))
    found.graph, own = found.graph.add_stroke(contacts)
    assert found.graph.face(own).fit.kind == "torus"
    found.rims = [RoundRim(s * 6.0 * Z, s * Z, 19.6, 0.05, 50 + s, True) for s in (1, -1)]
    found.wall_rims = [(Sighting(np.array([20.0, 0.0, 5.9]), np.eye(3)[1], -np.eye(3)[0], Z, 0.05, 8.0), 51)]
    return found


def test_rims_of_faces_that_turned_out_to_be_a_ring_make_no_hole_and_no_wall():
    found, frontier = (
        ring_with_rims(),
        SimpleNamespace(openings=[], narrow=[], round_gaps=[], known=[], placed=list, ends=list),
    )
    conclude(found, list, lambda: frontier, Mosaic())
    assert [face.fit.kind for face in found.graph.faces] == ["torus"]


def test_an_inferred_wall_joins_what_faces_as_it_does_and_moves_nothing_that_was_felt():
    at = np.array([[0.0, y, z] for y in (-9.0, 0.0, 9.0) for z in (1.0, 5.0, 9.0)])
    aside, way = np.array([1.0, 0.0, 0.0]), np.tile([1.0, 0.0, 0.0], (9, 1))
    found = Findings()
    found.graph, own = found.graph.add_stroke(Contacts.of(at, way, 0.02, 0.02, touch=np.arange(9)))
    felt = found.graph.face(own).fit
    add(found, Contacts.of(at + 0.9 * aside, way, 0.5, 0.05, touch=NOT_FELT), "of the same wall")
    assert len(found.graph.faces) == 1
    assert found.graph.faces[0].fit.shape is felt.shape
    assert len(found.graph.faces[0].fit.inliers) == len(found.graph.faces[0].contacts) == 18
    add(found, Contacts.of(at - 1.2 * aside, -way, 0.5, 0.05, touch=NOT_FELT), "of the next, back to back")
    assert len(found.graph.faces) == 2

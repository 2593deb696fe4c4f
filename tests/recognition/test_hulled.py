"""The hull of what was felt, where faces tell too little."""

from dataclasses import replace

import numpy as np

from models.csg import Cube
from models.solid import Solid
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from recognition import best_body as best_body_module
from recognition.assembly import Assembly, NotClosed
from recognition.assembly.described import link
from recognition.assembly.regularities import regularize
from recognition.best_body import FeltFace, best_body
from recognition.hulled import all_on_hull, hulled
from recognition.reconstruct import NO_FACE, _faces_of

BOX = np.array([[-100.0] * 3, [100.0] * 3])
AXES = np.concatenate([np.eye(3), -np.eye(3)])


def side(normal, half=20.0):
    u, v = np.roll(normal, 1), np.roll(normal, 2)
    steps = np.linspace(-0.9 * half, 0.9 * half, 6)
    points = half * normal + np.array([a * u + b * v for a in steps for b in steps])
    felt = Contacts.of(points, np.tile(normal, (len(points), 1)), 0.01, 0.005)
    return FeltFace(fit("plane", felt), felt)


def crumpled(radius=40.0):
    """Places all over something round, that name no face."""
    ways = np.random.default_rng(0).normal(size=(600, 3))
    return Contacts.of(radius * ways / np.linalg.norm(ways, axis=1, keepdims=True), sigma=0.05)


def test_most_contacts_off_the_faces_make_their_hull_the_body():
    body = best_body([side(way) for way in AXES], BOX, None, 15.0, crumpled())
    assert body.faceless
    assert not body.whole
    assert "hull" in body.assembly.warnings[0]
    inside = np.array(np.meshgrid(*[np.arange(-28.0, 29.0, 4.0)] * 3)).reshape(3, -1).T
    assert not best_body([side(way) for way in AXES], BOX, inside, 15.0, crumpled()).faceless  # a shell
    assert 0.85 < body.assembly.solid.volume / (4.0 / 3.0 * np.pi * 40.0**3) < 1.0


def test_a_body_that_explains_what_was_felt_stays():
    faces, few = [side(way) for way in AXES], crumpled().select(np.arange(40))
    body = best_body(faces, BOX, None, 15.0, few)
    assert body.whole
    assert abs(body.assembly.solid.volume - 64000.0) < 10.0
    inferred = replace(crumpled(), touch=np.full(600, NOT_FELT))
    assert hulled(faces, inferred, NotClosed("nothing was felt")) is None


def test_a_wall_that_was_only_inferred_may_not_cut_away_what_was_felt(monkeypatch):
    faces = [side(way) for way in AXES]
    slanting = np.array([0.6, 0.8, 0.0])
    places = 12.0 * slanting + np.outer(np.arange(6.0), [0.8, -0.6, 0.0]) + np.outer([1, 2, 0] * 2, AXES[2])
    lot = Contacts.of(places, np.tile(-slanting, (6, 1)), 0.1, 0.02, touch=NOT_FELT)
    wall = FeltFace(fit("plane", lot), lot)
    sliver = best_body([side(way, 5.0) for way in AXES], BOX, None, 15.0)
    made = best_body_module._of_faces

    def misled(felt, *rest):
        return sliver if any(face is wall for face in felt) else made(felt, *rest)

    monkeypatch.setattr(best_body_module, "_of_faces", misled)
    body = best_body([*faces, wall], BOX, None, 15.0)
    assert abs(body.assembly.solid.volume - 64000.0) < 10.0
    assert not body.faceless


def test_a_body_in_pieces_with_nothing_under_many_contacts_is_their_hull():
    blocks = [Cube((20.0, 60.0, 60.0)).at(x, 0, 0) for x in (-30.0, 30.0)]
    tree = blocks[0] | blocks[1]
    apart = Assembly((), regularize(()), (), (), tree, Solid.from_csg(tree), ())
    across = Contacts.of(
        np.array([[x, y, z] for x in (-8, 0, 8) for y in (-20, 0, 20) for z in (-30.0, 30.0)])
    )
    ends = np.array([[x, y, z] for x in (-40, 40) for y in (-29, 0, 29) for z in np.linspace(-29, 29, 7)])
    shell = Contacts.of(ends.astype(float))
    sides = [side(way, 40.0) for way in AXES]
    assert hulled(sides, Contacts.concatenate([across, shell]), apart) is not None
    assert hulled(sides, shell, apart) is None  # pieces, but nothing is in the air
    whole = Cube((80.0, 60.0, 60.0))
    one = Assembly((), regularize(()), (), (), whole, Solid.from_csg(whole), ())
    assert hulled(sides, Contacts.concatenate([across, shell]), one) is None


def test_a_smooth_convex_body_is_one_freeform_face_that_was_felt():
    ways = np.random.default_rng(0).normal(size=(1500, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    felt = Contacts.of(ways * [30.0, 20.0, 15.0], sigma=0.05)
    face = FeltFace(fit("sphere", felt), felt)
    hull = hulled([face], felt, NotClosed("a ball does not hold them"))
    assert hull is not None
    boundary = link(hull)
    assert [f.kind for f in boundary.brep.faces] == ["freeform"]
    owner = _faces_of(hull, boundary, felt, np.full(len(felt), NO_FACE))
    assert np.mean(owner == 0) > 0.99
    assert all_on_hull(felt.points)
    assert not all_on_hull(np.vstack([felt.points, 0.5 * felt.points[:200]]))


def test_places_all_but_in_a_plane_have_no_hull():
    flat = np.random.default_rng(0).uniform(-20.0, 20.0, (60, 3)) * [1.0, 1.0, 1e-12]
    assert not all_on_hull(flat)

"""One more of equal round faces, of which a touch or two tell."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.faces.repeated import repeated_face
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose, random_rotation, rotate, transform_points

WORLD = pose(random_rotation(np.random.default_rng(7)), [10.0, -20.0, 30.0])


def scallop(center: tuple[float, float], azimuths: Floats, touch: int, radius: float = 12.0) -> Contacts:
    """Contacts of a hollow cylinder along z at a place, as seen from inside it."""
    rng = np.random.default_rng(touch)
    ways = np.column_stack([np.cos(azimuths), np.sin(azimuths), np.zeros(len(azimuths))])
    points = np.array([*center, 0.0]) + (radius + 0.01 * rng.standard_normal((len(ways), 1))) * ways
    points[:, 2] = rng.uniform(2.0, 18.0, len(ways))
    return Contacts.of(transform_points(WORLD, points), rotate(WORLD, -ways), 0.015, 0.01, touch=touch)


def on_ring(number: int, far: float = 38.0) -> tuple[tuple[float, float], float]:
    """Where the scallops of a ring of six are, and the way from there to its middle."""
    angle = number * np.pi / 3
    return (far * float(np.cos(angle)), far * float(np.sin(angle))), angle + np.pi


def face_of(number: int, contacts: Contacts) -> Face:
    face = ranked_face(number, contacts, MergeOptions())
    assert isinstance(face.fit, Fit)
    assert face.fit.kind == "cylinder"
    return face


@pytest.fixture(scope="module")
def knob() -> PatchGraph:
    """A round body 64 mm wide with two neighboring scallops of six."""
    turn = np.linspace(0.2, 6.0, 60)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(60)])
    points = 32.0 * out + np.outer(np.linspace(0.0, 20.0, 60), [0.0, 0.0, 1.0])
    body = Contacts.of(transform_points(WORLD, points), rotate(WORLD, out), 0.015, 0.01, touch=90)
    hollows = [
        scallop(place, way + np.linspace(-0.6, 0.6, 14), k)
        for k, (place, way) in enumerate(map(on_ring, (0, 1)))
    ]
    return PatchGraph(tuple(face_of(k, c) for k, c in enumerate([body, *hollows])), ())


@pytest.mark.parametrize("number", [2, 5])
def test_a_few_contacts_a_step_on_are_one_more(knob: PatchGraph, number: int) -> None:
    place, way = on_ring(number)
    felt = scallop(place, way + np.array([-0.4, -0.1, 0.1, 0.3]), 50)
    stray = scallop((0.0, 90.0), np.array([0.0, 0.1]), 51)
    face = repeated_face(knob, Contacts.concatenate([felt, stray]))
    assert face is not None
    assert face.id == 3
    assert (face.contacts.touch == 50).all()
    assert len(face.contacts) == 4
    assert isinstance(face.fit, Fit)
    assert not face.fit.convex
    assert face.fit.shape.sizes[0] == pytest.approx(12.0, abs=0.1)
    middle = transform_points(WORLD, np.array([[*place, 10.0]]))
    assert face.fit.shape.signed_distance(middle)[0] == pytest.approx(-12.0, abs=0.15)


def test_what_strays_from_a_face_is_not_carried_on(knob: PatchGraph) -> None:
    place, way = on_ring(2)
    felt = scallop(place, way + np.array([-0.4, -0.1, 0.1, 0.3]), 50)
    hollow = knob.faces[2]
    assert isinstance(hollow.fit, Fit)
    astray = replace(hollow.contacts.select(slice(0, 5)), points=hollow.contacts.points[:5] + 2.0)
    with_them = replace(
        hollow,
        contacts=Contacts.concatenate([hollow.contacts, astray]),
        fit=replace(hollow.fit, inliers=np.append(hollow.fit.inliers, np.zeros(5, dtype=bool))),
    )
    clean, strewn = (
        repeated_face(PatchGraph((*knob.faces[:2], last), ()), felt) for last in (hollow, with_them)
    )
    assert clean is not None
    assert strewn is not None
    assert isinstance(clean.fit, Fit)
    assert isinstance(strewn.fit, Fit)
    assert strewn.fit.shape.sizes == pytest.approx(clean.fit.shape.sizes)


def test_a_row_goes_on_both_ways() -> None:
    around = np.linspace(3.6, 5.8, 14)
    row = PatchGraph(tuple(face_of(k, scallop((30.0 * k, 0.0), around, k)) for k in (0, 1)), ())
    for place in (-30.0, 60.0):
        felt = scallop((place, 0.0), np.array([4.0, 4.5, 5.0, 5.4]), 50)
        face = repeated_face(row, felt)
        assert face is not None
        assert len(face.contacts) == 4


def test_what_lies_elsewhere_or_faces_one_way_or_is_of_another_radius_is_none(knob: PatchGraph) -> None:
    place, way = on_ring(2)
    wide = way + np.array([-0.4, -0.1, 0.1, 0.3])
    assert repeated_face(knob, scallop(on_ring(2, 41.0)[0], wide, 50)) is None
    assert repeated_face(knob, scallop(place, way + np.array([0.0, 0.01, 0.02, 0.03]), 50)) is None
    assert repeated_face(knob, scallop(place, wide, 50, radius=9.0)) is None
    assert repeated_face(knob, scallop(place, wide[:2], 50)) is None
    assert repeated_face(knob, Contacts.of([])) is None
    known, back = on_ring(1)
    beside = scallop(known, back + np.array([-0.4, -0.1, 0.1, 0.3]), 50, radius=12.2)  # of one that is there
    assert repeated_face(knob, beside) is None
    assert repeated_face(PatchGraph(knob.faces[:2], ()), scallop(place, wide, 50)) is None

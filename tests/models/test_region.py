import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models import parts
from models.boundary import boundary
from models.csg import Cube, Cylinder, Sphere
from models.region import OPEN, region
from models.solid import Solid
from primitives.errors import PalpateError

BRACKET = Solid.from_csg(parts.build("bracket"))


def test_a_region_of_faces_keeps_their_edges_and_marks_those_that_lost_a_face() -> None:
    whole = boundary(Solid.from_csg(Cube((40, 30, 20))))
    corner = [f for f in range(6) if whole.faces[f].shape.direction.sum() > 0]
    part = region(whole, faces=corner)
    assert part.check() == ()
    assert (len(part.faces), len(part.edges), len(part.open_edges)) == (3, 9, 6)
    assert (part.cut, part.sources) == (frozenset(), tuple(corner))
    assert [part.faces[i].area for i in range(3)] == [whole.faces[f].area for f in corner]
    assert all(OPEN in part.edges[e].faces for e in part.open_edges)


def test_all_faces_are_the_whole_and_none_is_nothing() -> None:
    whole = boundary(BRACKET)
    part = region(whole, faces=range(len(whole.faces)))
    assert part.open_edges == ()
    assert len(part.edges) == len(whole.edges)
    assert not region(whole, faces=[])
    assert not region(BRACKET, ball=((500, 0, 0), 5))


def test_a_ball_round_a_corner_cuts_three_faces_into_quarter_discs() -> None:
    part = region(Solid.from_csg(Cube((40, 40, 40))), ball=((20, 20, 20), 10))
    assert part.check() == ()
    assert (len(part.faces), len(part.edges), len(part.cut)) == (3, 6, 3)
    assert part.cut_faces == {0, 1, 2}
    for face in part.faces:
        assert face.area == pytest.approx(25 * np.pi, rel=1e-3)
    for e in part.cut:
        assert part.edges[e].curve == "circle"
        assert part.edges[e].length == pytest.approx(5 * np.pi, rel=1e-4)


def test_a_box_that_touches_a_face_all_over_holds_it_whole() -> None:
    solid = Solid.from_csg(parts.build("stepped_block"))
    whole = boundary(solid)
    part = region(solid, box=solid.bounds)
    assert len(part.faces) == len(whole.faces)
    assert not part.cut
    low, high = solid.bounds
    lower = region(solid, box=[low, [high[0], high[1], 15.0]])
    step = next(
        f.id for f in whole.faces if f.shape.direction[2] > 0.5 and abs(f.shape.anchor[2] - 15) < 1e-6
    )
    assert step in lower.sources
    assert lower.faces[lower.sources.index(step)].area == pytest.approx(whole.faces[step].area, rel=1e-3)


@settings(max_examples=15, deadline=None)
@given(st.tuples(*[st.floats(0, 1)] * 3), st.floats(0.15, 0.8), st.booleans())
def test_any_region_is_sound_and_no_larger_than_the_whole(
    at: tuple[float, float, float], share: float, as_ball: bool
) -> None:
    low, high = BRACKET.bounds
    middle, half = low + (high - low) * np.array(at), (high - low) * share / 2
    whole = boundary(BRACKET)
    part = (
        region(BRACKET, ball=(middle, float(half.max())))
        if as_ball
        else region(BRACKET, box=[middle - half, middle + half])
    )
    assert part.check() == ()
    for face, source in zip(part.faces, part.sources, strict=True):
        assert face.kind == whole.faces[source].kind
        assert face.area <= whole.faces[source].area * (1 + 1e-6)
        if face.id not in part.cut_faces:
            assert face.area == pytest.approx(whole.faces[source].area, rel=1e-6)


def test_a_ball_that_just_dips_through_a_face_cuts_every_face_that_it_meets() -> None:
    low, _ = BRACKET.bounds
    part = region(BRACKET, ball=((low[0], low[1], low[2] + 21.86), 21.866))
    assert part.check() == ()
    assert part.cut_faces == {face.id for face in part.faces}
    assert {face.kind for face in part.faces} == {"plane", "cylinder"}


def test_the_graph_marks_rim_and_cuts_for_partial_matching() -> None:
    solid = Solid.from_csg(Cube((60, 40, 12)) - Cylinder(6, 30))
    hole = next(f.id for f in boundary(solid).faces if f.kind == "cylinder")
    graph = region(boundary(solid), faces=[hole]).graph()
    (_, node), *others = graph.nodes(data=True)
    assert not others
    assert node["shape"] == "cylinder"
    assert not node["cut"]
    assert [curve for curve, _ in node["open"]] == ["circle", "circle"]
    near = region(solid, ball=((0, 0, 6), 9)).graph()
    assert sorted(data["cut"] for _, data in near.nodes(data=True)) == [True, True]
    assert near.number_of_edges() == 1


def test_a_ball_of_the_part_s_own_sphere_holds_it_whole() -> None:
    part = region(Solid.from_csg(Sphere(20)), ball=((0, 0, 0), 20))
    assert len(part.faces) == 1
    assert part.open_edges == ()


def test_json_writes_the_missing_face_as_null() -> None:
    part = region(boundary(BRACKET), faces=[0])
    assert all(None in edge["faces"] for edge in part.as_json()["edges"])


@pytest.mark.parametrize(
    "given", [{}, {"faces": [99]}, {"box": [[0, 0, 0], [0, 1, 1]]}, {"faces": [0], "ball": ((0, 0, 0), 1)}]
)
def test_a_region_that_makes_no_sense_is_refused(given: dict) -> None:
    with pytest.raises(PalpateError):
        region(BRACKET, **given)


def test_a_boundary_alone_cannot_be_cut() -> None:
    with pytest.raises(PalpateError, match="solid"):
        region(boundary(BRACKET), ball=((0, 0, 0), 10))

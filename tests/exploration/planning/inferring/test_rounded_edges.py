"""Edges of a block that are rounded, inferred from where contact with its walls ends."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.rounded_edges import RoundedEdgesConfig, rounded_edges
from exploration.planning.touching.findings import SeenRim
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, MergeOptions, ranked_face
from primitives.pose import pose, random_rotation, rotate, transform_points

Z = np.array([0.0, 0.0, 1.0])
PRESSED = RoundedEdgesConfig().pressed


def end(radius: float, turn: float) -> float:
    """[mm] from the edge at which contact ends, where the rounding has fallen away by what the skin is pressed."""
    tangent = radius * np.tan(0.5 * turn)
    past = np.sqrt(radius**2 - (radius - PRESSED) ** 2)
    return float(tangent - past)


class Corner:
    """Two walls at the z axis, `turn` between their normals, felt up to some distance from it, at any pose."""

    def __init__(self, turn: float, felt: tuple[float, float]) -> None:
        self.world = pose(random_rotation(np.random.default_rng(4)), [20.0, -10.0, 5.0])
        self.normals = np.array([[1.0, 0.0, 0.0], [np.cos(turn), np.sin(turn), 0.0]])
        self.faces = [self._face(k, felt[k]) for k in (0, 1)]

    def _face(self, k: int, nearest: float) -> Face:
        rng = np.random.default_rng(k)
        away = np.concatenate([[nearest], rng.uniform(nearest, nearest + 30.0, 60)])
        points = np.outer(away, self._inward(k)) + np.outer(rng.uniform(-8, 8, 61), Z)
        normals = np.tile(self.normals[k], (61, 1))
        at = transform_points(self.world, points), rotate(self.world, normals)
        return ranked_face(k, Contacts.of(*at, 0.01, 0.01), MergeOptions())

    def _inward(self, k: int) -> Floats:
        """Along a wall, away from the edge: away from where the other wall looks."""
        way = np.cross(self.normals[k], Z)
        return np.asarray(way * -np.sign(way @ self.normals[1 - k]))

    def rims(self, k: int, far: float, count: int = 3) -> list[SeenRim]:
        turn = self.world[:3, :3]
        return [
            (
                Sighting(
                    transform_points(self.world, (far * self._inward(k) + height * Z)[None])[0],
                    turn @ Z, turn @ -self._inward(k), turn @ self.normals[k], 0.1, 8.0,
                ),
                k,
            )
            for height in np.linspace(-6.0, 6.0, count)
        ]  # fmt: skip


@pytest.mark.parametrize(
    ("radius", "turn"), [(6.0, np.pi / 3), (4.0, np.pi / 2), (6.0, np.pi / 2), (5.0, 1.9)]
)
def test_where_both_walls_end_tells_the_radius(radius: float, turn: float) -> None:
    far = end(radius, turn)
    corner = Corner(turn, (far + 2.0, far + 2.0))
    (lot,) = rounded_edges([*corner.rims(0, far), *corner.rims(1, far)], corner.faces)
    made = fit("cylinder", lot)
    assert isinstance(made, Fit)
    assert made.convex
    assert made.shape.sizes[0] == pytest.approx(radius, rel=0.03)
    for face in corner.faces:  # it goes over into both
        assert isinstance(face.fit, Fit)
        assert abs(face.fit.shape.signed_distance(made.shape.anchor[None])[0]) == pytest.approx(
            radius, rel=0.03
        )


def test_one_wall_s_rims_do_where_the_other_was_felt_no_nearer() -> None:
    far = end(6.0, np.pi / 2)
    corner = Corner(np.pi / 2, (far + 2.0, far + 1.0))
    assert len(rounded_edges(corner.rims(0, far), corner.faces)) == 1
    assert len(rounded_edges(corner.rims(1, far), corner.faces)) == 1
    assert not rounded_edges(corner.rims(1, far, count=1), corner.faces)


def test_a_slot_along_an_edge_that_was_felt_is_no_rounding_of_it() -> None:
    near = Corner(np.pi / 2, (0.5, 0.5))
    assert not rounded_edges([*near.rims(0, 7.0), *near.rims(1, 7.0)], near.faces)
    own = Corner(np.pi / 2, (0.5, 8.0))
    assert not rounded_edges(own.rims(0, 7.0), own.faces)


def test_a_rim_far_along_the_edge_proves_nothing_of_it_here() -> None:
    far = end(6.0, np.pi / 2)
    corner = Corner(np.pi / 2, (far + 2.0, far + 2.0))
    away = replace(
        corner.rims(1, far, 1)[0][0], point=corner.rims(1, far, 1)[0][0].point + 80.0 * corner.world[:3, 2]
    )
    (lot,) = rounded_edges([*corner.rims(0, far), (away, 1)], corner.faces)
    along = (lot.points - corner.world[:3, 3]) @ corner.world[:3, 2]
    assert np.abs(along).max() < 10.0


def test_nor_do_rims_of_one_wall_far_along_the_edge_from_those_of_the_other() -> None:
    far = end(6.0, np.pi / 2)
    corner = Corner(np.pi / 2, (far + 2.0, far + 2.0))
    along = 80.0 * corner.world[:3, 2]
    away = [(replace(rim, point=rim.point + along), k) for rim, k in corner.rims(1, far)]
    assert not rounded_edges([*corner.rims(0, far), *away], corner.faces)


def test_what_goes_on_to_the_edge_is_a_step_and_what_was_felt_far_away_tells_nothing() -> None:
    far = end(6.0, np.pi / 2)
    assert not rounded_edges(Corner(np.pi / 2, (0.5, 0.5)).rims(0, far), Corner(np.pi / 2, (0.5, 0.5)).faces)
    corner = Corner(np.pi / 2, (far + 1.0, far + 15.0))
    assert not rounded_edges(corner.rims(0, far), corner.faces)
    unlike = Corner(np.pi / 2, (far + 1.0, 2.0 * far + 1.0))
    assert not rounded_edges([*unlike.rims(0, far), *unlike.rims(1, 2.0 * far)], unlike.faces)
    assert not rounded_edges([], unlike.faces)


def test_a_wall_that_ends_at_the_side_of_a_plate_does_so_under_what_hangs_over_it_too() -> None:
    far = end(6.0, np.pi / 2)
    corner = Corner(np.pi / 2, (far + 2.0, far + 2.0))
    rims = [*corner.rims(0, far), *corner.rims(1, far)]
    front = corner.faces[0].contacts
    back = far * corner.normals[0] @ corner.world[:3, :3].T
    along = 30.0 * corner.world[:3, 2]
    side = Contacts.of(front.points - back + along, front.normals, 0.01, 0.01)
    assert len(rounded_edges(rims, corner.faces)) == 1
    assert not rounded_edges(rims, [*corner.faces, ranked_face(2, side, MergeOptions())])

"""What an array passed through is taken away from a body that has something there."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives.pose import pose, random_rotation, transform_points
from primitives.shapes import Cylinder as RoundWall
from primitives.shapes import Plane
from recognition.assembly.enclosing import enclosing_circle
from recognition.assembly.hollowed import hollowed
from recognition.assembly.made import Body, Known
from recognition.assembly.piece import Piece
from recognition.assembly.regularities import regularize
from recognition.assembly.uncertainty import piece_sigma

FACET = 0.01
BLOCK = Cube((80.0, 50.0, 16.0))
SLOT = Cube((50.0, 20.0, 30.0)).at(25.0, 0.0, 0.0)  # open at x = 40, above and below; its end at x = 0
TOP = Plane([0, 0, 8.0], [0, 0, 1.0])
SIDE = Plane([0, -25.0, 0], [0, -1.0, 0])
WALLS = Plane([0, 10.0, 0], [0, -1.0, 0]), Plane([0, -10.0, 0], [0, 1.0, 0])


def body(tree, world=None):
    placed = tree.placed(np.eye(4) if world is None else world)
    piece = Piece("cube", "add", tree, np.eye(4) if world is None else world, None, ())
    return Body((piece,), Solid.from_csg(placed, FACET), FACET)


def passed(tree, spacing=4.0, within=2.0):
    """The middles of the cells that lie in a tree, as deep as a swept cell's does at least."""
    low, high = tree.bounds()
    axes = [np.arange(a, b, spacing) for a, b in zip(low + 1.0, high, strict=True)]
    cells = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    return cells[tree.signed_distance(cells) < -within]


def felt(solid, count=1500):
    """Places all over a solid."""
    corners = solid.vertices[solid.triangles]
    rng = np.random.default_rng(1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    weight = rng.dirichlet(np.ones(3), count)
    return np.einsum("ij,ijk->ik", weight, corners[rng.choice(len(area), count, p=area / area.sum())])


def known(shapes, places, inferred=None):
    return Known(shapes, places, [False] * len(shapes) if inferred is None else inferred, np.empty((0, 3)))


def top_of(part):
    """Contacts of the outside of a part, those in what was cut from it left out."""
    at = felt(Solid.from_csg(part, FACET))
    return at[np.abs(BLOCK.signed_distance(at)) < 0.1]


def test_a_slot_whose_end_nobody_felt_is_taken_away_between_its_known_walls():
    part = BLOCK - SLOT
    at = top_of(part)
    walls = [np.array([[20.0, 10.0, 0.0]]), np.array([[20.0, -10.0, 0.0]])]
    told = known([TOP, SIDE, *WALLS], [at, at, *walls], [False, False, True, True])
    less = hollowed(body(BLOCK), passed(SLOT), told)
    cut = less.pieces[-1]
    assert cut.operation == "subtract"
    assert sorted(end for pair in cut.ends for end in pair if end is not None) == [2, 3]
    truth = Solid.from_csg(part, FACET)
    assert less.solid.volume == pytest.approx(truth.volume, rel=0.03)
    assert less.solid.shared_volume(truth) > 0.97 * truth.volume


@pytest.mark.parametrize("floor", [1.3, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("known_floor", [True, False])
def test_a_pocket_does_not_come_out_through_a_floor_that_was_felt_from_behind(floor, known_floor):
    deep = 16.0 - floor
    pocket = Cube((40.0, 24.0, deep + 20.0)).at(0.0, 0.0, 8.0 - deep + 0.5 * (deep + 20.0))
    at = top_of(BLOCK - pocket)
    shapes, where, told = [TOP, SIDE], [at, at], [False, False]
    if known_floor:
        level = 8.0 - deep
        shapes, told = [*shapes, Plane([0, 0, level], [0, 0, 1.0])], [*told, True]
        where = [*where, np.array([[0.0, 0.0, level]])]
    less = hollowed(body(BLOCK), passed(pocket, 2.0, 1.0), known(shapes, where, told))
    assert less.solid.genus == 0
    if known_floor:
        assert less.pieces[-1].operation == "subtract"


def test_a_known_wall_that_leans_ends_a_slot_where_it_passes_that():
    lean = np.deg2rad(4.0)
    wall = Plane(
        [-60.0, 3.0, 0], [np.sin(lean), -np.cos(lean), 0]
    )  # at y = 3 far off, and at 8.9 in the slot
    at = top_of(BLOCK - SLOT)
    told = known([TOP, SIDE, wall], [at, at, np.array([[25.0, 9.0, 0.0]])], [False, False, True])
    cut = hollowed(body(BLOCK), passed(SLOT), told).pieces[-1]
    edge = cut.placed.bounds()[1][1]
    assert edge == pytest.approx(wall_at(wall, 25.0), abs=0.5)


def wall_at(wall, x):
    """The y of a plane at x."""
    return wall.origin[1] - (x - wall.origin[0]) * wall.normal[0] / wall.normal[1]


def test_the_same_is_found_at_any_attitude():
    world = pose(random_rotation(np.random.default_rng(5)), [10.0, -20.0, 30.0])
    turn = world[:3, :3]
    at = transform_points(world, top_of(BLOCK - SLOT))
    shapes = [Plane(world[:3, 3] + turn @ p.origin, turn @ p.normal) for p in (TOP, SIDE)]
    free = transform_points(world, passed(SLOT))
    less = hollowed(body(BLOCK, world), free, known(shapes, [at, at]))
    truth = Solid.from_csg((BLOCK - SLOT).placed(world), FACET)
    assert truth.volume <= less.solid.volume < 1.08 * truth.volume  # a slot 4 mm narrower at most


def test_a_bore_has_the_radius_of_the_round_wall_that_is_known_there():
    bore = Cylinder(12.0, 30.0)
    wall = RoundWall([0, 0, 0.0], [0, 0, 1.0], 12.0)
    at = top_of(BLOCK - bore)
    told = known([TOP, SIDE, wall], [at, at, np.array([[12.0, 0.0, 0.0]])], [False, False, True])
    less = hollowed(body(BLOCK), passed(bore), told)
    assert less.pieces[-1].body == 2
    assert less.solid.volume == pytest.approx(Solid.from_csg(BLOCK - bore, FACET).volume, rel=1e-3)


def test_places_here_and_there_in_a_ring_about_a_bore_make_it_wider_there():
    bore, wide = (
        Cylinder(10.0, 30.0),
        Cylinder(17.0, 10.0).at(0, 0, 8.0),
    )  # its ledge at z = 3, felt by nobody
    turn = 2.0 * np.pi * np.arange(12) / 12
    seen = np.concatenate([[[13.5 * np.cos(t), 13.5 * np.sin(t), z] for t in turn] for z in (5.0, 9.0)])
    at = top_of(BLOCK - bore - wide)
    less = hollowed(body(BLOCK - bore), seen, known([TOP, SIDE], [at, at]))
    cut = less.pieces[-1]
    assert cut.kind == "cylinder"
    assert cut.solid.radius == pytest.approx(17.0, abs=2.0)  # half way to the contacts round it
    truth = Solid.from_csg(BLOCK - bore - wide, FACET)
    missing = body(BLOCK - bore).solid.volume - truth.volume
    assert less.solid.volume - truth.volume < 0.8 * missing


def test_half_a_bore_in_a_side_is_round_though_no_wall_is_known():
    notch = Cylinder(14.0, 30.0).at(0.0, -25.0, 0.0)
    at = top_of(BLOCK - notch)
    less = hollowed(body(BLOCK), passed(notch, 2.0, 0.5), known([TOP, SIDE], [at, at]))
    assert less.pieces[-1].kind == "cylinder"
    assert piece_sigma(less.pieces[-1], regularize(())) == {
        "extent_mm": [None, None, None]
    }  # all of it is a guess
    truth = Solid.from_csg(BLOCK - notch, FACET)
    assert less.solid.shared_volume(truth) / max(truth.volume, less.solid.volume) > 0.98


def test_what_was_passed_just_under_a_surface_takes_nothing_away():
    skim = Cube((60.0, 40.0, 3.4)).at(0.0, 0.0, 8.0)  # the array a little deeper than it knew
    at = felt(Solid.from_csg(BLOCK, FACET))
    given = body(BLOCK)
    assert hollowed(given, passed(skim, 2.0, 0.0), known([TOP, SIDE], [at, at])) is given


def test_contacts_in_a_hollow_keep_it():
    at = felt(Solid.from_csg(BLOCK, FACET))  # felt all over, where the slot would be, too
    given = body(BLOCK)
    assert hollowed(given, passed(SLOT), known([TOP, SIDE], [at, at])) is given


def test_no_hollow_tears_a_body_apart():
    across = Cube((20.0, 90.0, 30.0))
    at = top_of(BLOCK - across)
    given = body(BLOCK)
    assert hollowed(given, passed(across), known([TOP, SIDE], [at, at])) is given


@pytest.mark.parametrize("seed", range(6))
def test_the_least_circle_holds_all_points_and_is_held_by_two_or_three(seed):
    points = np.random.default_rng(seed).standard_normal((40, 2)) * [3.0, 1.0]
    center, radius = enclosing_circle(points)
    away = np.linalg.norm(points - center, axis=1)
    assert away.max() == pytest.approx(radius)
    on = points[away > radius * (1.0 - 1e-9)] - center
    turn = np.sort(np.arctan2(on[:, 1], on[:, 0]))
    assert np.diff([*turn, turn[0] + 2.0 * np.pi]).max() <= np.pi + 1e-6  # no half of its rim is bare


def test_a_circle_round_half_a_disc_is_that_of_the_disc():
    turn = np.linspace(0.0, np.pi, 50)
    center, radius = enclosing_circle(np.column_stack([7.0 * np.cos(turn) + 2.0, 7.0 * np.sin(turn)]))
    np.testing.assert_allclose([*center, radius], [2.0, 0.0, 7.0], atol=1e-9)

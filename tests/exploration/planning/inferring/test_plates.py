"""Outlines of plates, from pictures of both their sides."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.planning.inferring.concluding import _add_outlines
from exploration.planning.inferring.plate_walls import along_it, denies, freeform, plate_walls
from exploration.planning.inferring.plates import plates
from exploration.planning.known.mosaic import Mosaic, Picture
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.findings import Findings
from exploration.sensing.frame import TaxelArray
from primitives.evidence import NOT_FELT, Contacts
from primitives.outlines import depth_inside
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face
from primitives.pose import inverse, pose, rotation_exp, transform_points

Z = np.array([0.0, 0.0, 1.0])
NOWHERE = np.empty((0, 3))


def side(number, height, up):
    x, y = np.meshgrid(np.linspace(-18.0, 18.0, 8), np.linspace(-18.0, 18.0, 8))
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    face = ranked_face(number, Contacts.of(points, np.tile(up * Z, (len(points), 1))), MergeOptions())
    return KnownFace(face, face.fit, 1.0 if face.fit.convex else -1.0, points, NOWHERE)


SOFT = 1.3  # [mm]


class Drawn:
    """A mosaic that knows, of a plane at some height, a share within 28 mm, as soft as images are."""

    config = SimpleNamespace(step=0.5)

    def __init__(self, share_of):
        self.share_of = share_of

    def picture(self, anchor, normal, lattice):
        i, j = np.meshgrid(*(np.arange(count) for count in lattice.shape), indexing="ij")
        flat = lattice.origin + lattice.step * np.stack([i, j], axis=-1)
        world = flat @ lattice.along.T
        known = np.hypot(world[..., 0], world[..., 1]) < 28.0
        share = gaussian_filter(self.share_of(world, float(anchor[2])), SOFT / lattice.step, mode="nearest")
        return Picture(np.where(known, share, 0.0), known)


def soft(depth):
    return np.clip(0.5 + 0.5 * depth, 0.0, 1.0)


def notched(world, height):
    """A square of 40 mm with a notch 8 mm wide from the right to x = 10; on the upper side a dent as well."""
    x, y = world[..., 0], world[..., 1]
    square = 20.0 - np.maximum(np.abs(x), np.abs(y))
    notch = np.minimum(x - 10.0, 4.0 - np.abs(y))
    dent = 5.0 - np.hypot(x + 10.0, y)
    return soft(np.minimum(square, -np.maximum(notch, dent) if height > 0.0 else -notch))


TOP, BOTTOM = side(1, 6.0, 1.0), side(2, -6.0, -1.0)


def test_what_both_sides_have_and_what_neither_has_are_told_and_nothing_of_the_rest():
    (plate,) = plates([TOP, BOTTOM], Drawn(notched))
    assert abs(plate.thick - 12.0) < 1e-6
    asked = np.array([[0.0, 0.0], [15.0, 0.0], [15.0, 8.0], [-10.0, 0.0], [24.0, 0.0], [22.0, 8.0]])
    own = transform_points(inverse(plate.pose), np.column_stack([asked, np.zeros(len(asked))]))[:, :2]
    assert (depth_inside(plate.there, own) > 0.0).tolist() == [True, False, True, False, False, False]
    assert (depth_inside(plate.missing, own) > 0.0).tolist() == [False, True, False, False, True, True]
    rim = np.array([[10.0, 0.0, 0.0], [15.0, 4.0, 0.0], [20.0, 10.0, 0.0]])
    on = transform_points(inverse(plate.pose), rim)[:, :2]
    assert np.abs(depth_inside(plate.there, on)).max() < 0.4


@pytest.mark.parametrize("touched", [False, True])
def test_what_one_side_has_or_was_touched_at_is_not_missing_where_the_other_was_not_seen(touched):
    """Beside what both lack, and nearer to that than to all that both have."""

    class Narrower(Drawn):
        """Nobody saw the lower side where x > -10; there the upper is seen, or was only touched."""

        def picture(self, anchor, normal, lattice):
            whole = super().picture(anchor, normal, lattice)
            i, j = np.meshgrid(*(np.arange(count) for count in lattice.shape), indexing="ij")
            world = (lattice.origin + lattice.step * np.stack([i, j], axis=-1)) @ lattice.along.T
            seen = (world[..., 0] < -10.0) | (world[..., 0] > 22.0) | (anchor[2] > 0.0 and not touched)
            return Picture(np.where(seen, whole.share, 0.0), whole.known & seen)

    x, y = np.meshgrid(np.arange(-19.0, 20.0), np.arange(-19.0, 20.0))
    top, bottom = (
        replace(
            own,
            cells=np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)]) if touched else own.cells,
        )
        for own, height in ((TOP, 6.0), (BOTTOM, -6.0))
    )

    def square(world, height):
        return soft(20.0 - np.maximum(np.abs(world[..., 0]), np.abs(world[..., 1])))

    (plate,) = plates([top, bottom], Narrower(square))
    asked = np.array([[18.9, 0.0], [18.9, 8.0], [24.0, 0.0]])
    own = transform_points(inverse(plate.pose), np.column_stack([asked, np.zeros(len(asked))]))[:, :2]
    assert (depth_inside(plate.missing, own) > 0.0).tolist() == [False, False, True]


def test_faces_that_lie_far_apart_and_floors_that_nobody_saw_beside_a_face_are_no_plate():
    assert (
        plates([TOP, side(2, -6.0, 1.0)], Drawn(lambda world, height: soft(height + 0.0 * world[..., 0])))
        == []
    )
    assert plates([TOP, side(2, -300.0, -1.0)], Drawn(notched)) == []


def pocket(world, height):
    """In a square of 40 mm, 8 mm deep, of 16 x 10 mm: its floor, or what is round it."""
    hole = np.minimum(8.0 - np.abs(world[..., 0]), 5.0 - np.abs(world[..., 1]))
    return soft(hole if height < 0.0 else np.minimum(-hole, 20.0 - np.abs(world).max(axis=-1)))


def test_over_a_floor_nothing_is_where_the_face_above_is_not_and_elsewhere_nothing_is_said():
    (step,) = plates([TOP, side(2, -2.0, 1.0)], Drawn(pocket))
    assert step.step
    assert step.thick == pytest.approx(8.0)
    asked = np.array([[0.0, 0.0, 2.0], [7.0, 4.0, 2.0], [12.0, 0.0, 2.0], [25.0, 0.0, 2.0]])
    own = transform_points(inverse(step.pose), asked)
    assert np.abs(own[:, 2]).max() < 1e-9
    assert (depth_inside(step.missing, own[:, :2]) > 0.0).tolist() == [True, True, False, False]
    assert (depth_inside(step.there, own[:, :2]) > 0.0).tolist() == [False, False, True, False]
    assert not denies(step, np.column_stack([np.linspace(10.0, 16.0, 9), np.full(9, 12.0), np.full(9, 2.0)]))
    walls = plate_walls(step, [])
    assert [kind for _, kind in walls] == ["plane"] * 4
    for lot, _ in walls:
        off = np.abs(lot.points[:, :2]) - [8.0, 5.0]
        assert np.abs(off).min(axis=1).max() < 0.4
        assert ((lot.points * lot.normals).sum(axis=1) < 0.0).all()


@pytest.mark.parametrize(("levels", "far"), [((-2.0,), True), ((-2.0, 1.0), False)])
def test_a_pocket_of_which_one_floor_was_felt_in_a_part_goes_down_to_it_everywhere(levels, far):
    """It is as a U, 8 mm wide; between its legs lies the upper face, and two floors may be at its ends."""

    def bent(world, height):
        x, y = world[..., 0], world[..., 1]
        hole = np.minimum(13.0 - np.abs(x), np.maximum(np.abs(x) - 5.0, 4.0 - np.abs(y + 10.0)))
        hole = np.minimum(hole, 14.0 - np.abs(y))
        if height > 5.0:
            return soft(np.minimum(-hole, 20.0 - np.abs(world).max(axis=-1)))
        return soft(np.minimum(hole, np.minimum(x - 5.0, y - 4.0) if height < 0.0 else -5.0 - x))

    floors = [side(2 + k, level, 1.0) for k, level in enumerate(levels)]
    step = max(plates([TOP, *floors], Drawn(bent)), key=lambda each: each.thick)
    own = transform_points(
        inverse(step.pose), np.array([[9.0, 10.0, 2.0], [-9.0, 0.0, 2.0], [0.0, 0.0, 2.0]])
    )
    assert (depth_inside(step.missing, own[:, :2]) > 0.0).tolist() == [True, far, False]


def test_a_cross_has_walls_through_a_plate_and_none_as_a_pocket_in_it():
    def crossed(world, height):
        x, y = np.abs(world[..., 0]), np.abs(world[..., 1])
        bars = np.maximum(np.minimum(15.0 - x, 5.0 - y), np.minimum(5.0 - x, 15.0 - y))
        return soft(bars if -5.0 < height < 5.0 else np.minimum(-bars, 20.0 - np.abs(world).max(axis=-1)))

    (through,) = plates([TOP, BOTTOM], Drawn(crossed))
    step = next(each for each in plates([TOP, side(2, -2.0, 1.0)], Drawn(crossed)) if each.step)
    inside = [
        [lot for lot, _ in plate_walls(plate, []) if np.abs(lot.points[:, :2]).max() < 18.0]
        for plate in (through, step)
    ]
    assert [len(walls) for walls in inside] == [12, 0]


def test_a_ledge_between_a_floor_and_the_face_above_it_is_left_where_it_is():
    def stairs(world, height):
        tread = {-2.0: (10.0, 20.0), 2.0: (6.0, 10.0), 6.0: (-20.0, 6.0)}[round(height, 3)]
        return soft(np.minimum(world[..., 0] - tread[0], tread[1] - world[..., 0]))

    steps = plates([TOP, side(2, -2.0, 1.0), side(3, 2.0, 1.0)], Drawn(stairs))
    assert sorted(round(step.thick, 3) for step in steps) == [4.0, 4.0, 8.0]
    (whole,) = (step for step in steps if step.thick > 6.0)
    own = transform_points(
        inverse(whole.pose), np.array([[8.0, 0.0, 2.0], [12.0, 0.0, 2.0], [0.0, 0.0, 2.0]])
    )
    assert (depth_inside(whole.missing, own[:, :2]) > 0.0).tolist() == [False, True, False]


def slope(number):
    """A plane that comes down from x = 6 at the upper face to x = 10 at a floor 8 mm below it."""
    along, y = np.meshgrid(np.linspace(0.1, 0.9, 6), np.linspace(-16.0, 16.0, 9))
    points = np.column_stack([6.0 + 4.0 * along.ravel(), y.ravel(), 6.0 - 8.0 * along.ravel()])
    normals = np.tile(np.array([2.0, 0.0, 1.0]) / np.sqrt(5.0), (len(points), 1))
    face = ranked_face(number, Contacts.of(points, normals), MergeOptions())
    return KnownFace(face, face.fit, 1.0 if face.fit.convex else -1.0, points, NOWHERE)


def chamfer(number):
    """Of the step at x = 6, at its top."""
    y, z = np.meshgrid(np.linspace(-16.0, 16.0, 9), np.array([4.3, 5.0, 5.7]))
    points = np.column_stack([12.0 - z.ravel(), y.ravel(), z.ravel()])
    normals = np.tile(np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0), (len(points), 1))
    face = ranked_face(number, Contacts.of(points, normals), MergeOptions())
    return KnownFace(face, face.fit, 1.0 if face.fit.convex else -1.0, points, NOWHERE)


def test_below_a_chamfer_all_that_is_missing_is_missing():
    def step(world, height):
        return soft(world[..., 0] - 8.0 if height < 0.0 else 6.0 - world[..., 0])

    (found,) = plates([TOP, side(2, -2.0, 1.0), chamfer(3)], Drawn(step))
    own = transform_points(inverse(found.pose), np.array([[9.0, 0.0, 2.0], [0.0, 0.0, 2.0]]))
    assert (depth_inside(found.missing, own[:, :2]) > 0.0).tolist() == [True, False]


def test_where_a_slope_stands_on_a_floor_nothing_is_missing():
    def sloped(world, height):
        return soft(world[..., 0] - 10.0 if height < 0.0 else 6.0 - world[..., 0])

    asked = np.array([[8.0, 0.0, 2.0], [15.0, 0.0, 2.0], [0.0, 0.0, 2.0]])
    floor = side(2, -2.0, 1.0)
    for faces, missing in (([], [True, True, False]), ([slope(3)], [False, True, False])):
        (step,) = plates([TOP, floor, *faces], Drawn(sloped))
        own = transform_points(inverse(step.pose), asked)
        assert (depth_inside(step.missing, own[:, :2]) > 0.0).tolist() == missing


class HalfSeen(Drawn):
    """The same, of which nobody saw what is left of x = -15."""

    def picture(self, anchor, normal, lattice):
        seen = super().picture(anchor, normal, lattice)
        rows = np.arange(lattice.shape[0])[:, None], np.arange(lattice.shape[1])[None]
        flat = np.stack(np.broadcast_arrays(*rows), axis=-1) * lattice.step + lattice.origin
        known = seen.known & ((flat @ lattice.along.T)[..., 0] > -15.0)
        return Picture(np.where(known, seen.share, 0.0), known)


def upright(number, x):
    """A wall at x that stands on the upper face and looks right."""
    y, z = np.meshgrid(np.linspace(-6.0, 6.0, 7), np.linspace(7.0, 11.0, 5))
    points = np.column_stack([np.full(y.size, x), y.ravel(), z.ravel()])
    face = ranked_face(
        number, Contacts.of(points, np.tile([1.0, 0.0, 0.0], (len(points), 1))), MergeOptions()
    )
    return KnownFace(face, face.fit, 1.0 if face.fit.convex else -1.0, points, NOWHERE)


def test_beside_what_goes_on_through_a_plate_nothing_is_missing_where_nobody_looked():
    def bar(world, height):
        return soft(world[..., 0] + 10.0)

    sides = [replace(own, cells=own.cells[own.cells[:, 0] > -10.0]) for own in (TOP, BOTTOM)]
    boss = upright(3, -17.5)
    for faces, gone in (([], True), ([boss], False)):
        plate = next(each for each in plates([*sides, *faces], HalfSeen(bar)) if each.thick == 12.0)
        own = transform_points(inverse(plate.pose), np.array([[-17.5, 0.0, 0.0]]))
        assert bool((depth_inside(plate.missing, own[:, :2]) > 0.0)[0]) is gone


def test_faces_that_look_one_way_are_seen_once_each_for_all_their_steps():
    mosaic, seen = Drawn(notched), []
    picture = mosaic.picture
    mosaic.picture = lambda anchor, normal, lattice: seen.append(1) or picture(anchor, normal, lattice)
    plates([side(number, 2.0 * number, 1.0) for number in range(5)], mosaic)
    assert len(seen) == 5


def test_of_a_long_bar_slots_go_through_and_holes_in_both_ends_may_be_blind():
    def drilled(world, height):
        hole = np.minimum(6.0 - np.abs(world[..., 0] + 8.0), 4.0 - np.abs(world[..., 1]))
        return np.minimum(notched(world, -1.0), soft(-hole))

    asked = np.array([[15.0, 0.0, 0.0], [-8.0, 0.0, 0.0], [24.0, 0.0, 0.0]])
    for bottom, gone in ((-6.0, [True, True, True]), (-80.0, [True, False, True])):
        (plate,) = plates([TOP, side(2, bottom, -1.0)], Drawn(drilled))
        own = transform_points(inverse(plate.pose), asked)[:, :2]
        assert (depth_inside(plate.missing, own) > 0.0).tolist() == gone


def test_on_a_table_what_is_missing_of_the_upper_side_is_missing_down_to_it():
    (plate,) = plates([TOP], Drawn(notched), table=-3.0)
    assert abs(plate.thick - 9.0) < 1e-6
    assert plate.lies
    asked = np.array([[15.0, 0.0, -2.0], [-10.0, 0.0, -2.0], [0.0, 12.0, -2.0]])
    own = transform_points(inverse(plate.pose), asked)
    assert (np.abs(own[:, 2]) < 4.5).all()
    assert (depth_inside(plate.missing, own[:, :2]) > 0.0).tolist() == [True, False, False]
    assert plates([BOTTOM], Drawn(notched), table=-9.0) == []


def test_a_wall_through_what_both_sides_have_is_denied_and_one_along_the_outline_is_not():
    (plate,) = plates([TOP, BOTTOM], Drawn(notched))
    along = np.linspace(-16.0, -6.0, 9)
    inside = np.column_stack([along, np.full(9, 12.0), np.zeros(9)])
    outline = np.column_stack([along, np.full(9, 20.0), np.zeros(9)])
    assert denies(plate, inside)
    assert not denies(plate, outline)
    assert not denies(plate, outline + 9.0 * Z)


def wall(number, points, normal):
    """A felt one."""
    return ranked_face(number, Contacts.of(points, np.tile(normal, (len(points), 1))), MergeOptions())


def side_of_square(number, way):
    across = np.cross(Z, way)
    points = [20.0 * way + t * across + h * Z for t in np.linspace(-18.0, 18.0, 9) for h in (-3.0, 3.0)]
    return wall(number, np.array(points), way)


SIDES = [side_of_square(10 + k, way) for k, way in enumerate(np.array([[0.0, 1, 0], [0, -1, 0], [-1, 0, 0]]))]


def test_walls_stand_along_straight_pieces_of_an_outline_that_no_face_makes():
    (plate,) = plates([TOP, BOTTOM], Drawn(notched))
    found = [lot for lot, kind in plate_walls(plate, SIDES) if kind == "plane"]
    levels = sorted(
        (
            *lot.normals.mean(axis=0).round(2)[:2].tolist(),
            float((lot.points * lot.normals).sum(axis=1).mean()),
        )
        for lot in found
    )
    wanted = [(0, -1, -4), (0, 1, -4), (1, 0, 10), (1, 0, 20), (1, 0, 20)]  # the side has two parts
    np.testing.assert_allclose(levels, wanted, atol=0.3)
    for lot in found:
        assert np.ptp(lot.points[:, 2]) > 6.0


def test_an_outline_of_which_walls_make_little_is_freeform():
    (plate,) = plates([TOP, BOTTOM], Drawn(notched))
    assert freeform(plate, SIDES[:1])
    assert not freeform(plate, SIDES)
    assert along_it(plate, np.array([[20.0, 0.0, 0.0]]))
    assert not along_it(plate, np.array([[20.0, 0.0, 30.0]]))


def keyhole(world, height):
    x, y = world[..., 0], world[..., 1]
    return soft(np.minimum(np.hypot(x + 4.0, y) - 8.0, 24.0 - np.hypot(x, y)))


def test_a_round_piece_is_a_cylinder_that_looks_to_its_axis():
    (plate,) = plates([TOP, BOTTOM], Drawn(keyhole))
    lots = [lot for lot, kind in plate_walls(plate, []) if kind == "cylinder"]
    hole = min(lots, key=lambda lot: np.ptp(lot.points[:, 0]))
    away = hole.points[:, :2] - [-4.0, 0.0]
    assert np.abs(np.linalg.norm(away, axis=1) - 8.0).max() < 0.4
    assert ((hole.normals[:, :2] * away).sum(axis=1) < 0.0).all()


def windows(world, height):
    x, y = np.abs(world[..., 0]), world[..., 1]
    square = 19.0 - np.maximum(x, np.abs(y))
    holes = [np.maximum(np.abs(world[..., 0] - at) - 5.5, np.abs(y) - 5.5) for at in (-12.5, 12.5)]
    above = np.maximum(x - 5.5, np.abs(y - 11.5) - 5.5)
    return soft(np.minimum.reduce([square, *holes, above, np.maximum(x - 5.5, np.abs(y + 11.5) - 5.5)]))


def test_each_of_many_square_holes_has_its_walls():
    (plate,) = plates([TOP, BOTTOM], Drawn(windows))
    flat = [lot for lot, kind in plate_walls(plate, []) if kind == "plane"]
    assert len(flat) >= 16


def toothed(world, height):
    x, y = world[..., 0], world[..., 1]
    return soft(18.0 + 4.0 * np.sign(np.sin(9.0 * np.arctan2(y, x))) - np.hypot(x, y))


def test_outlines_that_walls_leave_unexplained_make_none_of_several_plates():
    """A gear's and, beside it, that of a square: of the one nothing is inferred, of the other its free side."""
    top, bottom = side(3, 36.0, 1.0), side(4, 24.0, -1.0)
    found = Findings(graph=PatchGraph(tuple(SIDES)))
    found.plates = [*plates([top, bottom], Drawn(toothed)), *plates([TOP, BOTTOM], Drawn(notched))]
    _add_outlines(found, [])
    inferred = [face for face in found.graph.faces if (face.contacts.touch == NOT_FELT).all()]
    assert inferred
    assert all(np.abs(face.contacts.points[:, 2]).max() < 6.0 for face in inferred)


def test_no_wall_stands_where_faces_end_inside_a_side_that_was_felt_past_them():
    """As of a side that is chamfered on both sides, or bulges."""
    (plate,) = plates([TOP, BOTTOM], Drawn(notched))
    out = [
        wall(
            50,
            np.array([[23.0, t, h] for t in np.linspace(-18.0, 18.0, 9) for h in (-2.0, 2.0)]),
            np.eye(3)[0],
        )
    ]
    before, after = plate_walls(plate, SIDES), plate_walls(plate, [*SIDES, *out])
    level = [lot for lot, _ in before if abs(float(lot.points[:, 0].mean()) - 20.0) < 0.5]
    assert len(level) == 2
    assert not [lot for lot, _ in after if abs(float(lot.points[:, 0].mean()) - 20.0) < 0.5]


ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))


def pressed(at, height, up):
    """A pad at (2,) places on the upper or lower side of the notched square, as rubber shows it."""
    turn = rotation_exp([np.pi, 0.0, 0.0]) if up > 0.0 else np.eye(3)
    where = pose(turn, [*at, height - 0.6 * up])
    x, y = np.meshgrid(ARRAY.x, ARRAY.y)
    places = transform_points(where, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))
    share = soft(0.7 * (2.0 * notched(places, -1.0) - 1.0))
    seen = SimpleNamespace(
        array=ARRAY, depth=0.6 * share.reshape(ARRAY.shape), sigma=np.full(ARRAY.shape, 0.03), spread=SOFT
    )
    return SimpleNamespace(image=seen, world_from_sensor=where)


def test_images_of_both_sides_make_a_plate_with_its_notch():
    mosaic = Mosaic()
    for x in np.arange(-16.0, 26.0, 7.0):
        for y in np.arange(-18.0, 19.0, 6.0):
            for height, up in ((6.0, 1.0), (-6.0, -1.0)):
                mosaic.look(pressed((x, y), height, up))
    (plate,) = plates([TOP, BOTTOM], mosaic)
    rim = np.array([[10.0, 0.0, 0.0], [15.0, 4.0, 0.0], [20.0, 10.0, 0.0], [-20.0, 0.0, 0.0]])
    on = transform_points(inverse(plate.pose), rim)[:, :2]
    assert np.abs(depth_inside(plate.there, on)).max() < 0.6
    in_it = transform_points(inverse(plate.pose), np.array([[15.0, 0.0, 0.0]]))[:, :2]
    assert depth_inside(plate.missing, in_it) > 2.0

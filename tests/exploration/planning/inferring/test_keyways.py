"""Keyways along a cylinder, from images of a pad that lay along it and on its end."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.planning.inferring.keyways import keyways
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.known_face import KnownFace
from exploration.sensing.frame import TaxelArray
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, ranked_face
from primitives.pose import pose

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
RADIUS, END, SIGMA, SPREAD, FINE = 14.0, 30.0, 0.03, 1.2, 6
X, Y, Z = np.eye(3)
KEY = np.deg2rad(200.0)  # where round the axis the middle of the keyway is
OUT = np.array([0.0, np.cos(KEY), np.sin(KEY)])
ROUND = np.deg2rad(np.arange(0.0, 360.0, 20.0))


def keyway(width, low, high, depth=None):
    """Whether there is wall at (n, 3) places on the cylinder or its end, but for a slot with round ends."""
    half, deep = 0.5 * width, depth or 0.5 * width

    def there(at):
        beside = np.abs(at @ np.cross(X, OUT))
        within = np.clip(at[:, 0], low + half, max(high - half, low + half))
        gone = (np.hypot(at[:, 0] - within, beside) < half) & (at @ OUT > RADIUS - deep)
        return ~gone & (at[:, 0] < END + 1e-6)

    return there


def press(mosaic, where, surface, there, rng):
    """An image of a pad at a pose, of what a (n, 3) grid far finer than its taxels has before it."""
    rows, columns = ARRAY.shape
    y = (np.arange(rows * FINE) + 0.5) / FINE * 1.8 - rows * 0.9
    x = (np.arange(columns * FINE) + 0.5) / FINE * 1.8 - columns * 0.9
    across, up = np.meshgrid(x, y)
    skin = where[:3, 3] + across.ravel()[:, None] * where[:3, 0] + up.ravel()[:, None] * where[:3, 1]
    before, at = surface(skin)
    depth = np.where(there(at), np.maximum(before, 0.0), 0.0).reshape(rows * FINE, columns * FINE)
    spread = gaussian_filter(depth, SPREAD / 1.8 * FINE, mode="nearest")
    seen = spread.reshape(rows, FINE, columns, FINE).mean(axis=(1, 3))
    image = SimpleNamespace(
        array=ARRAY,
        depth=seen + SIGMA * rng.normal(size=seen.shape),
        sigma=np.full(ARRAY.shape, SIGMA),
        spread=SPREAD,
    )
    mosaic.look(SimpleNamespace(image=image, world_from_sensor=where))


def looked(there, end=False, over=(-20.0, -10.0, 0.0, 10.0, 20.0), pressed=1.3):
    """A pad that lay along the cylinder at many turns round it, and on its end."""
    mosaic, rng = Mosaic(), np.random.default_rng(1)
    for turn in [*ROUND, *np.deg2rad([190.0, 195.0, 205.0, 212.0])]:
        out = np.array([0.0, np.cos(turn), np.sin(turn)])

        def along(skin, out=out):
            level = np.sqrt(np.maximum(RADIUS**2 - (skin @ np.cross(X, out)) ** 2, 0.0))
            lift = level - skin @ out
            return lift, skin + lift[:, None] * out

        frame = np.column_stack([X, np.cross(-out, X), -out])
        near = np.cos(turn - KEY) > 0.8
        for at in over if near else (-20.0, -10.0, 0.0, 10.0, 20.0):
            press(mosaic, pose(frame, (RADIUS - pressed) * out + at * X), along, there, rng)
    if end:
        for middle in (0.0, 6.0):
            where = pose(np.column_stack([Y, np.cross(-X, Y), -X]), (END - 0.8) * X + middle * OUT)
            press(
                mosaic, where,
                lambda skin: (END - skin[:, 0], np.column_stack([np.full(len(skin), END), skin[:, 1:]])),
                lambda at: there(at) & (np.hypot(at[:, 1], at[:, 2]) < RADIUS), rng,
            )  # fmt: skip
    return mosaic


def known(number=0, amidst=None):
    """A cylinder that was felt all round but where the keyway is, or so deep there [mm]."""
    turns, along = (lot.ravel() for lot in np.meshgrid(ROUND, np.linspace(-28.0, 29.0, 9)))
    in_it = np.abs(turns - KEY) < 0.1
    out = np.column_stack([0.0 * turns, np.cos(turns), np.sin(turns)])
    contacts = Contacts.of(
        (RADIUS - np.where(in_it, amidst or 0.0, 0.0))[:, None] * out + along[:, None] * X, out
    )
    contacts = contacts.select(~in_it | (amidst is not None))
    face = ranked_face(number, contacts, MergeOptions())
    return KnownFace(face, face.fit, 1.0, contacts.points, np.empty((0, 3)))


def flat_end():
    spots = np.array([[END, y, z] for y in (-5.0, 0.0, 5.0) for z in (-5.0, 0.0, 5.0)])
    return ranked_face(1, Contacts.of(spots, np.broadcast_to(X, spots.shape)), MergeOptions())


@pytest.mark.parametrize("width", [4.0, 6.0, 8.0])
def test_a_slot_with_straight_sides_is_a_keyway_half_as_deep_as_wide(width):
    own = known()
    (key,) = keyways([own], [own.face], looked(keyway(width, -12.0, 9.0)))
    assert key.out @ OUT > np.cos(np.deg2rad(1.5))
    assert key.width == pytest.approx(width, abs=0.4)
    ends = sorted(
        float(at @ X) for at in (key.shaft.anchor + h * key.shaft.direction for h in (key.low, key.high))
    )
    assert ends == pytest.approx([-12.0, 9.0], abs=0.8)
    assert key.depth == pytest.approx(0.5 * key.width)
    assert not key.seen


def test_the_rounding_of_an_edge_is_no_shaft():
    own, mosaic = known(), looked(keyway(6.0, -12.0, 9.0))
    edge = own.cells[own.cells @ OUT > 0.3 * RADIUS]
    assert len(keyways([own], [own.face], mosaic)) == 1
    assert keyways([replace(own, cells=edge)], [own.face], mosaic) == []


def test_where_the_cylinder_was_felt_amidst_it_there_is_none():
    own, facet = known(amidst=0.22), looked(keyway(6.0, -20.0, 20.0), pressed=0.3)
    assert keyways([own], [own.face], facet) == []


def test_what_was_read_where_skin_came_deeper_and_felt_nothing_was_not_felt():
    own = known(amidst=0.5)
    (key,) = keyways([own], [own.face], looked(keyway(6.0, -20.0, 20.0)))
    assert key.width == pytest.approx(6.0, abs=0.4)


def test_its_walls_face_into_it_and_nobody_felt_them():
    own = known()
    (key,) = keyways([own], [own.face], looked(keyway(6.0, -12.0, 9.0)))
    walls = [(fit(kind, lot), kind) for lot, kind in key.walls()]
    assert [kind for _, kind in walls] == ["plane", "plane", "plane", "cylinder", "cylinder"]
    assert all(wall.kind == kind for wall, kind in walls)
    middle = key.shaft.anchor + 0.5 * (key.low + key.high) * key.shaft.direction
    middle = middle + (RADIUS - 0.5 * key.depth) * key.out
    for lot, _ in key.walls():
        assert (((middle - lot.points) * lot.normals).sum(axis=1) > 0.0).all()
        assert (lot.touch == NOT_FELT).all()
    ends = [wall.shape for wall, kind in walls if kind == "cylinder"]
    assert all(end.radius == pytest.approx(0.5 * key.width, rel=1e-6) for end in ends)
    assert all(abs(float(end.direction @ key.out)) == pytest.approx(1.0) for end in ends)
    floor = list(key.walls())[2][0].points  # it ends the round ends, too
    assert all(
        (np.linalg.norm(np.cross(floor - end.anchor, end.direction), axis=1) < end.radius).any()
        for end in ends
    )
    assert np.ptp((floor - key.shaft.anchor) @ key.shaft.direction) > key.high - key.low - key.width


@pytest.mark.parametrize("depth", [2.5, 5.0])
def test_the_end_that_it_goes_on_through_shows_how_deep_it_is(depth):
    own, end = known(), flat_end()
    (key,) = keyways([own], [own.face, end], looked(keyway(7.0, -5.0, 50.0, depth), end=True))
    assert key.seen
    assert key.depth == pytest.approx(depth, abs=0.3)
    assert len(list(key.walls())) == 4


@pytest.mark.parametrize(
    "there",
    [
        keyway(7.0, -4.0, 3.0),  # a round hole
        keyway(7.0, -50.0, 50.0),  # on through both ends, as between teeth
        keyway(1.5, -12.0, 9.0),  # narrower than rubber shows
        lambda at: np.abs(at @ np.cross(X, OUT) - 0.3 * at[:, 0]) > 3.0,  # it winds about the axis
        lambda at: (at[:, 0] < -4.0) | (at[:, 0] > 3.0),  # a groove
    ],
)
def test_what_is_no_slot_along_the_axis_is_none(there):
    own = known()
    assert keyways([own], [own.face], looked(there)) == []


def test_where_a_face_is_known_in_it_it_is_left_to_that():
    own, seen = known(), looked(keyway(8.0, -12.0, 9.0))
    spots = (RADIUS - 2.0) * OUT + np.linspace(-6.0, 4.0, 4)[:, None] * X
    floor = Face(
        1,
        fit("plane", Contacts.of(spots, np.broadcast_to(OUT, spots.shape))),
        Contacts.of(spots, OUT + 0 * spots),
    )
    assert keyways([own], [own.face, floor], seen) == []
    assert keyways([], [], Mosaic()) == []


def test_a_bore_behind_it_is_no_face_in_it():
    own, seen = known(), looked(keyway(8.0, -12.0, 9.0))
    turns, along = (lot.ravel() for lot in np.meshgrid(ROUND, np.linspace(-28.0, 28.0, 9)))
    out = np.column_stack([0.0 * turns, np.cos(turns), np.sin(turns)])
    for radius in (4.0, 7.0):
        bore = ranked_face(1, Contacts.of(radius * out + along[:, None] * X, -out), MergeOptions())
        assert len(keyways([own], [own.face, bore], seen)) == 1


@pytest.mark.parametrize("over", [(-20.0, -10.0), (0.0,)])
def test_where_nobody_looked_at_its_end_it_is_none(over):
    own = known()
    assert keyways([own], [own.face], looked(keyway(8.0, -50.0, 50.0), over=over)) == []


def test_one_that_two_faces_of_a_cylinder_show_is_one():
    both = [known(0), known(1)]
    assert len(keyways(both, [own.face for own in both], looked(keyway(6.0, -12.0, 9.0)))) == 1


def test_one_that_ends_at_a_shoulder_is_left_out():
    own, seen = known(), looked(keyway(7.0, -5.0, 50.0), end=True)
    ring = np.column_stack([np.full(18, END), 17.0 * np.cos(ROUND), 17.0 * np.sin(ROUND)])
    shoulder = ranked_face(2, Contacts.of(ring, np.broadcast_to(-X, ring.shape)), MergeOptions())
    assert keyways([own], [own.face, shoulder], seen) == []

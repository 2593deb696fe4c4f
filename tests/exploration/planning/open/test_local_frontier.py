from dataclasses import replace

import numpy as np

from exploration.planning.faces.consistency import flattened
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.local_frontier import LocalFrontier
from exploration.planning.ways.routes import Tool, route
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.shapes import Cylinder

UP = np.array([0.0, 0.0, 1.0])


def plane_face(number, points, normal):
    return ranked_face(number, Contacts.of(points, np.tile(normal, (len(points), 1))), MergeOptions())


def grid(x, y, step=2.0):
    axes = np.arange(*x, step), np.arange(*y, step)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def floor(x=(0.0, 30.0), y=(0.0, 30.0)):
    flat = grid(x, y)
    return np.column_stack([flat, np.zeros(len(flat))])


def mapped(*lots):
    felt = SurfaceMap()
    for points, normal in lots:
        felt.add(points, np.tile(normal, (len(points), 1)))
    return felt


def test_a_face_goes_on_where_nothing_was_felt_and_not_past_a_rim():
    points = floor()
    beyond = grid((31.0, 40.0), (-10.0, 40.0), 1.0)
    free = np.column_stack([beyond, np.full(len(beyond), -0.5)])
    frontier = LocalFrontier([plane_face(0, points, UP)], mapped((points, UP)), free, 10.0)
    opened = frontier.open.points
    assert (opened[:, 0] < -1.0).any()
    assert (opened[:, 0] < 30.0).all()


def test_a_rim_is_open_until_the_face_behind_it_is_known():
    points = floor()
    beyond = grid((31.0, 40.0), (-10.0, 40.0), 1.0)
    free = np.column_stack([beyond, np.full(len(beyond), -0.5)])
    top = plane_face(0, points, UP)
    (rim, face), *_ = LocalFrontier([top], mapped((points, UP)), free, 10.0).rims
    assert face == 0
    assert rim.outward @ [1.0, 0.0, 0.0] > 0.9
    side = np.column_stack([np.full(150, 30.0), *(grid((0.0, 30.0), (-20.0, 0.0)).T)])
    out = np.array([1.0, 0.0, 0.0])
    behind = plane_face(1, side, out)
    assert not LocalFrontier([top, behind], mapped((points, UP), (side, out)), free, 10.0).rims


def test_a_face_ends_at_a_touched_wall():
    points = floor()
    wall = np.column_stack([np.full(225, 31.0), *grid((0.0, 30.0), (0.0, 30.0)).T])
    faces = [plane_face(0, points, UP), plane_face(1, wall, [-1.0, 0.0, 0.0])]
    none = np.empty((0, 3))
    felt = mapped((points, UP), (wall, np.array([-1.0, 0.0, 0.0])))
    opened = LocalFrontier(faces, felt, none, 10.0).open
    assert (opened.points[opened.face == 0][:, 0] < 32.0).all()
    assert (opened.points[opened.face == 1][:, 2] > -1.0).all()


def test_a_way_never_leads_the_housing_through_what_was_touched():
    tool = Tool(np.array([-15.0, -10.0, -40.0]), np.array([15.0, 10.0, 0.0]))
    flat = grid((-30.0, 30.0), (-30.0, 30.0), 4.0)
    wall = np.column_stack([np.zeros(len(flat)), flat])
    down = np.diag([1.0, -1.0, -1.0])
    start, goal = se3.pose(down, [-40.0, 0.0, 0.0]), se3.pose(down, [40.0, 0.0, 0.0])
    poses = route(tool, start, goal, wall, np.array([UP]))
    assert poses is not None
    for a, b in zip([start, *poses[:-1]], poses, strict=True):
        for share in np.linspace(0.0, 1.0, 60):
            at = se3.pose(down, (1.0 - share) * a[:3, 3] + share * b[:3, 3])
            local = (wall - at[:3, 3]) @ at[:3, :3]
            assert not ((local > tool.low) & (local < tool.high)).all(axis=1).any()


def test_the_rim_of_a_hole_is_a_circle_of_its_radius():
    flat = grid((-30.0, 30.0), (-30.0, 30.0), 1.0)
    away = np.linalg.norm(flat - [3.0, -2.0], axis=1)
    points = np.column_stack([flat, np.zeros(len(flat))])
    free = points[away < 9.0] - [0.0, 0.0, 0.5]
    points = points[away > 9.0]
    (rim,) = LocalFrontier([plane_face(0, points, UP)], mapped((points, UP)), free, 10.0).openings
    assert abs(rim.radius - 9.0) < 1.0  # of what is felt, cells of 2 mm are kept
    assert np.linalg.norm(rim.center - [3.0, -2.0, 0.0]) < 1.0


def test_a_round_pocket_beside_the_middle_of_a_drum_is_its_own_and_no_ring_of_the_drums():
    flat = grid((-26.0, 26.0), (-26.0, 26.0), 1.0)
    away, beside = np.linalg.norm(flat, axis=1), np.linalg.norm(flat - [6.0, 0.0], axis=1)
    points = np.column_stack([flat, np.zeros(len(flat))])
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    out = np.tile(np.column_stack([np.cos(turn), np.sin(turn), np.zeros(60)]), (3, 1))
    barrel = 25.0 * out - np.repeat([3.0, 12.0, 20.0], 60)[:, None] * UP
    drum = ranked_face(1, Contacts.of(barrel, out), MergeOptions())
    for middle, gap in (([0.0, 0.0, 0.0], away), ([6.0, 0.0, 0.0], beside)):
        top, free = points[(away < 25.0) & (gap > 12.0)], points[gap < 11.0] - [0.0, 0.0, 0.5]
        both = mapped((top, UP))
        both.add(barrel, out)
        (rim,) = LocalFrontier([plane_face(0, top, UP), drum], both, free, 10.0).openings
        assert np.linalg.norm(rim.center - middle) < 1.0
        assert abs(rim.radius - 12.0) < 1.2


def test_where_a_boss_stands_in_a_gap_there_is_no_hole():
    turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    points = np.concatenate([np.column_stack([r * ring, np.zeros(40)]) for r in (11.0, 13.0, 15.0, 17.0)])
    free = np.concatenate([np.column_stack([r * ring, np.full(40, -0.6)]) for r in (4.0, 6.0, 8.0)])
    top = np.column_stack([6.0 * ring, np.full(40, 5.0)])
    plate, lots = plane_face(0, points, UP), [(points, UP), (top, UP)]
    assert LocalFrontier([plate], mapped(lots[0]), free, 10.0).openings
    assert not LocalFrontier([plate, plane_face(1, top, UP)], mapped(*lots), free, 10.0).openings


def test_the_outline_of_a_disc_is_no_opening():
    flat = grid((-30.0, 30.0), (-30.0, 30.0), 1.0)
    away = np.linalg.norm(flat, axis=1)
    points = np.column_stack([flat, np.zeros(len(flat))])
    free = points[away > 12.0] - [0.0, 0.0, 0.5]
    points = points[away < 12.0]
    assert not LocalFrontier([plane_face(0, points, UP)], mapped((points, UP)), free, 10.0).openings


def test_a_narrow_face_that_reads_slightly_curved_is_a_plane_and_a_bar_is_none():
    flat = grid((0.0, 6.0), (0.0, 40.0))
    slight = np.column_stack([flat, -((flat[:, 0] - 3.0) ** 2) / (2.0 * 850.0)])
    across = np.column_stack([-(flat[:, 0] - 3.0) / 850.0, np.zeros(len(flat)), np.ones(len(flat))])
    contacts = Contacts.of(slight, across / np.linalg.norm(across, axis=1, keepdims=True), 0.003, 0.001)
    curved = fit("cylinder", contacts)
    turn = np.linspace(-0.5, 0.5, 12)
    ring = np.column_stack([np.sin(turn), np.zeros(12), np.cos(turn)])
    bar = Contacts.of(
        np.concatenate([20.0 * ring + [0.0, y, 0.0] for y in (0.0, 20.0)]), np.tile(ring, (2, 1))
    )
    rough = floor((-30.0, 30.0), (0.0, 20.0)) + 0.07 * UP * np.random.default_rng(0).normal(size=(300, 1))
    poor = Contacts.of(rough, np.tile(UP, (300, 1)), 0.03, 0.02)
    faces = (
        Face(0, replace(curved, shape=Cylinder([3.0, 0.0, -850.0], [0.0, 1.0, 0.0], 850.0)), contacts),
        Face(1, fit("cylinder", bar), bar),
        Face(
            2, replace(fit("plane", poor), shape=Cylinder([0.0, 0.0, -1600.0], [0.0, 1.0, 0.0], 1600.0)), poor
        ),
    )
    kinds = [face.fit.kind for face in flattened(PatchGraph(faces)).faces]
    assert kinds == ["plane", "cylinder", "plane"]


def test_a_long_land_that_bends_slightly_across_is_a_plane_and_a_rounded_corner_is_none():
    def strip(radius):
        """5 mm wide, 40 mm long, on a cylinder."""
        turn = np.repeat(np.linspace(-2.5, 2.5, 6) / radius, 12)
        along = np.tile(np.linspace(0.0, 40.0, 12), 6)
        out = np.column_stack([np.sin(turn), np.zeros(72), np.cos(turn)])
        contacts = Contacts.of(radius * (out - UP) + along[:, None] * [0.0, 1.0, 0.0], out, 0.01, 0.01)
        found = fit("cylinder", contacts)
        return Face(0, replace(found, shape=Cylinder([0.0, 0.0, -radius], [0.0, 1.0, 0.0], radius)), contacts)

    kinds = [flattened(PatchGraph((strip(radius),))).faces[0].fit.kind for radius in (180.0, 48.0)]
    assert kinds == ["plane", "cylinder"]

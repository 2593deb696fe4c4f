"""Frames of a disc and of a stadium, blurred on a fine grid, say where their outline runs."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, map_coordinates, uniform_filter

from exploration.control.edge_refined import Frames, moved_outward, nodes_along
from exploration.sensing.response import rubber
from primitives.pose import pose, rotation_exp

SPREAD, PITCH, SHAPE = 1.2, 1.8, (10, 16)  # [mm]
FINE = PITCH / 15  # [mm] an odd part, so that a mean over a taxel is about its middle
RESPONSE = rubber(SPREAD, (PITCH, PITCH))
DEPTH = 0.5


def stadium(radius, straight):
    """Its outline, counterclockwise from the middle of the lower side, and what the skin shows of it at points."""
    half = 0.5 * straight
    length = 2.0 * straight + 2.0 * np.pi * radius

    def at(s):
        s = np.asarray(s) % length
        first = np.clip((s - half) / radius, 0.0, np.pi)
        angle = first + np.clip((s - 3 * half - np.pi * radius) / radius, 0.0, np.pi)
        x = np.clip(s, 0, half) - np.clip(s - half - np.pi * radius, 0, straight)
        x = x + np.clip(s - 3 * half - 2 * np.pi * radius, 0, half)
        return np.column_stack([x + radius * np.sin(angle), -radius * np.cos(angle), np.zeros(len(s))]), angle

    size = half + radius + 20.0
    grid = np.arange(-size, size, FINE)
    x, y = np.meshgrid(grid, grid)
    away = np.hypot(np.maximum(np.abs(x) - half, 0.0), y)
    mask = np.clip((radius - away) / FINE + 0.5, 0.0, 1.0)
    shown = uniform_filter(gaussian_filter(DEPTH * mask, SPREAD / FINE), round(PITCH / FINE))
    return at, lambda points: map_coordinates(shown, ((points[:, ::-1] - grid[0]) / FINE).T, order=1)


def frames_along(at, shown, places, noise=0.0, rng=None):
    """Pads over the outline: x along it, the middle 1 mm inside, the material at +y."""
    xs = (np.arange(SHAPE[1]) - (SHAPE[1] - 1) / 2) * PITCH
    ys = (np.arange(SHAPE[0]) - (SHAPE[0] - 1) / 2) * PITCH
    local = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    depths, poses = [], []
    for (x, y, _), angle in zip(*at(places), strict=True):
        turn = rotation_exp([0.0, 0.0, angle])
        middle = np.array([x, y, 0.0]) + turn @ [0.0, 1.0, 0.0]
        depth = shown(local @ turn[:2, :2].T + middle[:2])
        depth = depth + noise * (0.0 if rng is None else rng.standard_normal(len(depth)))
        depths.append(depth.reshape(SHAPE))
        poses.append(pose(turn, middle))
    depths, faces = np.array(depths), np.tile([DEPTH, 0.0], (len(places), 1))
    sigma = np.full(depths.shape, 0.025)
    return Frames(depths, sigma, (PITCH, PITCH), np.array(poses), faces, 1.0, np.asarray(places, dtype=float))


@pytest.mark.parametrize(("radius", "straight"), [(8.0, 0.0), (6.0, 20.0)])
def test_a_curve_beside_the_outline_is_brought_onto_it(radius, straight):
    at, shown = stadium(radius, straight)
    places = np.arange(0.0, 30.0, 0.25)
    frames = frames_along(at, shown, places)
    nodes = nodes_along(0.0, 29.75)
    true, angle = at(nodes)
    outward = np.column_stack([np.sin(angle), -np.cos(angle), np.zeros(len(angle))])
    aside = 0.15 * np.sin(nodes / 5.0)
    for _ in range(3):
        off, information = moved_outward(true + aside[:, None] * outward, frames, 0.0, RESPONSE)
        aside = aside + off
    assert (information > 0.0).all()
    within = slice(8, -8)
    assert np.abs(aside[within]).max() < 0.05
    assert np.sqrt(np.mean(aside[within] ** 2)) < 0.025


def test_noise_moves_the_nodes_by_what_their_information_says():
    at, shown = stadium(12.0, 0.0)
    places, nodes = np.arange(0.0, 20.0, 0.5), nodes_along(0.0, 19.5)
    curve, _ = at(nodes)
    rng, still = (
        np.random.default_rng(4),
        moved_outward(curve, frames_along(at, shown, places), 0.0, RESPONSE)[0],
    )
    normal = []
    for _ in range(20):
        off, information = moved_outward(curve, frames_along(at, shown, places, 0.025, rng), 0.0, RESPONSE)
        normal.append((off - still) * np.sqrt(information))
    assert np.std(normal) == pytest.approx(1.0, rel=0.1)

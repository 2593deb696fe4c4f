"""How much of pose space a loose pose really stands for: a normal density knows of no face's edge.

Contacts on one face leave a pose free to slide along it.  How far is that of a face: a finger that is to stay on a
face turns back at its end, so that contacts all over a small face are no less likely than as many on a part of a
large one.  So the room of a wide mode is that of one contact in the middle of all: its likelihood L is asked at
twists x drawn from N(0, s^2 C) at several widths s, C the mode's covariance, and each draw weighed by all widths
together (Veach and Guibas 1995, the balance heuristic)::

    room = integral of L(x) / L(0) = mean over draws of  L(x) / L(0) / q(x),   q = mean over s of N(x; 0, s^2 C)

Summed over the faces of an object the rooms of a single contact are its surface, so that one touch says nothing of
the name (our derivation).  The twists are those of the wide axes of C: along the narrow ones the normal density is
right.  What slides on itself does so by a lower pair, a group of motions (Reuleaux 1875), so that the exponential
of a twist stays on it however long it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp
from scipy.stats import norm, qmc

from primitives.arrays import Floats, frozen
from primitives.pose import exp, pose
from recognition.matching.search_kernels import weighed
from recognition.matching.target import Target, field_error


@dataclass(frozen=True)
class RoomConfig:
    """What is wide, and how often it is asked."""

    wide: float = 0.04  # of the object's size, sigma at an arm of half of it, from which an axis is checked
    widths: tuple[float, ...] = (1.0, 0.5, 0.25, 0.125, 0.06)  # s
    each: int = 256  # draws at each of them, a power of two; with 48 one touch told names apart threefold
    cap: float = 12.0  # cost of a contact beyond which it says no more than that it is off
    steep: float = 0.05  # [rad] by which the field's normals err


class Lone(NamedTuple):
    """One contact."""

    point: Floats  # (3,) [mm]
    normal: Floats  # (3,), 0 where none was felt
    felt: bool
    sigma: float  # [mm]
    tau: float  # [rad]


def log_room(
    found: Floats, covariance: Floats, contact: Lone, target: Target, config: RoomConfig = RoomConfig()
) -> float:
    """Logarithm of the room over that of the normal density, of a (3, 4) pose object_from_world.

    `covariance` (6, 6) is of (v [mm], w [rad]) in the object's frame about its center.
    """
    arm = 0.5 * target.size
    scale = np.array([1.0, 1.0, 1.0, arm, arm, arm])
    values, axes = np.linalg.eigh(covariance * np.outer(scale, scale))
    loose = values > (config.wide * target.size) ** 2
    if not loose.any():
        return 0.0
    z, log_q = _draws(int(loose.sum()), config)
    twists = (z * np.sqrt(values[loose])) @ (axes[:, loose] / scale[:, None]).T
    once = np.linalg.norm(twists[:, 3:], axis=1) <= np.pi
    about = pose(None, target.center) @ exp(twists[once]) @ pose(None, -target.center)
    poses = np.concatenate([np.eye(4)[None], about]) @ pose(found[:, :3], found[:, 3])
    costs = _costs(np.ascontiguousarray(poses[:, :3]), contact, target, config)
    like = np.exp(-0.5 * np.maximum(costs[1:] - costs[0], 0.0))
    room = float((like * np.exp(-log_q[once])).sum()) / len(z)
    return float(np.log(max(room, 1e-12)) - 0.5 * loose.sum() * np.log(2.0 * np.pi))


def _costs(poses: Floats, contact: Lone, target: Target, config: RoomConfig) -> Floats:
    """(k,) -2 log likelihood of the contact, but for a constant, at (k, 3, 4) poses."""
    fine = float(np.hypot(field_error(target), contact.sigma))
    steep = float(np.hypot(config.steep, contact.tau))
    told = contact.point[None], contact.normal[None], np.array([contact.felt])
    field = target.values, target.origin, target.spacing, target.step
    return np.asarray(weighed(poses, *told, fine, steep, config.cap, field))


@cache
def _draws(axes: int, config: RoomConfig) -> tuple[Floats, Floats]:
    """(k, axes) of all widths together, in sigmas, and the logarithms of their density."""
    even = qmc.Sobol(axes, seed=0).random(config.each)
    z = np.concatenate([s * norm.ppf(even) for s in config.widths])
    widths = np.array(config.widths)
    square = (z**2).sum(axis=1)[:, None] / widths**2
    each = -0.5 * square - axes * np.log(widths) - 0.5 * axes * np.log(2.0 * np.pi)
    return frozen(z), frozen(logsumexp(each, axis=1) - np.log(len(widths)))

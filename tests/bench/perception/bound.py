"""Cramer-Rao: the least covariance of whoever is told all but the unknown numbers of a scene.

With f the simulator's own frame without noise, J = df/d(unknown) by central differences and sigma the deviation of
each taxel, the Fisher information of the mean is F = J^T diag(1/sigma^2) J.  What is to be found, t(numbers),
then has covariance T F^-1 T^T with T = dt/d(unknown).  No detector's formula enters.
"""

from collections.abc import Iterable

import numpy as np
from perception.noise import Noise
from perception.scene import Scene, clean

from primitives.arrays import Floats

STEP = {  # half-widths of the differences: small against the blur, large against the facets
    "x": 0.02,
    "y": 0.02,
    "offset": 0.02,
    "turn": 0.002,
    "depth": 0.005,
    "tilt_x": 2e-4,
    "tilt_y": 2e-4,
    "background": 1e-3,
    "radius": 0.02,
    "width": 0.02,
    "opening": 0.004,
}
RELATIVE = {"radius": 0.01}  # of the number itself, where that is more


def information(scene: Scene, unknown: Iterable[str], sigma: Floats) -> Floats:
    """(u, u) Fisher information; taxels of infinite sigma tell nothing."""
    weight = np.where(np.isfinite(sigma), 1 / sigma, 0.0)
    jacobian = np.array([(_difference(scene, name) * weight).ravel() for name in unknown])
    return jacobian @ jacobian.T


def bound(scene: Scene, noise: Noise, unknown: Iterable[str] | None = None) -> Floats:
    """(m, k, k) covariance of each thing that the scene holds."""
    whole = joint(scene, noise, unknown)
    m, k = scene.found.shape
    return np.stack([whole[i * k : (i + 1) * k, i * k : (i + 1) * k] for i in range(m)])


def joint(scene: Scene, noise: Noise, unknown: Iterable[str] | None = None) -> Floats:
    """(m k, m k) covariance of all that the scene holds; dead taxels known, and left out."""
    unknown = tuple(scene.unknown if unknown is None else unknown)
    sigma = noise.sigma_at(clean(scene))
    if scene.dead is not None:
        sigma = np.where(scene.dead, np.inf, sigma)
    fisher = information(scene, unknown, sigma)
    scale = 1 / np.sqrt(np.maximum(np.diag(fisher), 1e-30))
    covariance = np.linalg.inv(fisher * np.outer(scale, scale)) * np.outer(scale, scale)
    turn = np.array([_turn(scene, name) for name in unknown]).T
    return turn @ covariance @ turn.T


def _half(scene: Scene, name: str) -> float:
    return max(STEP[name], RELATIVE.get(name, 0.0) * abs(scene.numbers[name]))


def _difference(scene: Scene, name: str) -> Floats:
    if name == "background":
        return np.ones(scene.spec.array.shape)
    h = _half(scene, name)
    return (clean(scene.moved(**{name: h})) - clean(scene.moved(**{name: -h}))) / (2 * h)


def _turn(scene: Scene, name: str) -> Floats:
    h = _half(scene, name)
    return (scene.moved(**{name: h}).found - scene.moved(**{name: -h}).found).ravel() / (2 * h)

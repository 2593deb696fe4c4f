"""Cramer-Rao: the least covariance of whoever is told all but the unknown numbers of a scene.

With f the simulator's own frame without noise, J = df/d(unknown) by central differences and sigma the deviation of
each taxel, the Fisher information of the mean is F = J^T diag(1/sigma^2) J.  What is to be found, t(numbers),
then has covariance T F^-1 T^T with T = dt/d(unknown).  No detector's formula enters.  All angles are unknown: no
estimator is told that a corner is square, or that the sides of a wall are parallel.
"""

from collections.abc import Iterable
from dataclasses import dataclass

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
    "cut": 0.004,
    "first": 0.004,
    "second": 0.004,
    "taper": 0.004,
    "dihedral": 0.02,
}
RELATIVE = {"radius": 0.01}  # of the number itself, where that is more

NOTHING = 1e-8  # of the other unknowns' information, that differences make of what changes no frame

ZERO = ("background",)  # known to who trusts the untouched frame


@dataclass(frozen=True)
class Fisher:
    """What a frame of a scene tells."""

    unknown: tuple[str, ...]
    information: Floats  # (u, u)
    turn: Floats  # (m, k, u) how what is to be found moves with the unknowns

    def joint(self, told: Iterable[str] = ()) -> Floats:
        """(m k, m k) least covariance of all that is to be found; `told` are known after all."""
        free = [i for i, name in enumerate(self.unknown) if name not in set(told)]
        information = self.information[np.ix_(free, free)]
        scale = 1 / np.sqrt(np.diag(information))
        values, axes = np.linalg.eigh(information * np.outer(scale, scale))
        felt = values > NOTHING  # not that a bar turns about its own axis
        covariance = (axes[:, felt] / values[felt]) @ axes[:, felt].T * np.outer(scale, scale)
        turn = self.turn[..., free].reshape(-1, len(free))
        return turn @ covariance @ turn.T

    def each(self, told: Iterable[str] = ()) -> Floats:
        """(m, k, k) covariance of each thing."""
        m, k = self.turn.shape[:2]
        whole = self.joint(told)
        return np.stack([whole[i * k : (i + 1) * k, i * k : (i + 1) * k] for i in range(m)])

    def variances(self, told: Iterable[str] = ()) -> Floats:
        """(m, k)."""
        return np.diag(self.joint(told)).reshape(self.turn.shape[:2])


def fisher(scene: Scene, noise: Noise, unknown: Iterable[str] | None = None) -> Fisher:
    """By differences; dead taxels known, and left out."""
    unknown = tuple(scene.unknown if unknown is None else unknown)
    sigma = noise.sigma_at(clean(scene))
    weight = 1 / sigma if scene.dead is None else np.where(scene.dead, 0.0, 1 / sigma)
    jacobian = np.array([(difference(scene, name) * weight).ravel() for name in unknown])
    turn = np.stack([_turn(scene, name) for name in unknown], axis=-1)
    return Fisher(unknown, jacobian @ jacobian.T, turn)


def bound(scene: Scene, noise: Noise, unknown: Iterable[str] | None = None) -> Floats:
    """(m, k, k) covariance of each thing that the scene holds."""
    return fisher(scene, noise, unknown).each()


def _half(scene: Scene, name: str) -> float:
    return max(STEP[name], RELATIVE.get(name, 0.0) * abs(scene.numbers[name]))


def difference(scene: Scene, name: str) -> Floats:
    if name == "background":
        return np.ones(scene.spec.array.shape)
    h = _half(scene, name)
    return (clean(scene.moved(**{name: h})) - clean(scene.moved(**{name: -h}))) / (2 * h)


def _turn(scene: Scene, name: str) -> Floats:
    h = _half(scene, name)
    change = scene.moved(**{name: h}).found - scene.moved(**{name: -h}).found
    if change.shape[1] == 2:  # an angle that passed half a turn between the two
        change[:, 0] -= 2 * np.pi * np.round(change[:, 0] / (2 * np.pi))
    return change / (2 * h)

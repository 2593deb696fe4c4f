"""The gain map and the dead taxels, from presses on a flat at several unknown depths and tilts.

Press m lays a plane under the pad, so taxel i feels signal_mi = g_i F(p_m .  b_i), with b = (1, x, y) as the
rubber carries it (it bends where the skin ends), F the sensor's curve, p_m the unknown plane and g_i the gain
over nominal.  Gauss-Newton on all g and p at once, the g eliminated first (Schur's complement; each appears in
its own readings only).  One press cannot tell a tilt from a trend in the gains: presses at several tilts can, as
the plane of one times the trend is no plane for another; what they leave open is held by the prior that gains
scatter independently.  Where F is straight a common factor of all gains shows as well in the depths: their mean is
set to one.

Planes are first fitted robustly.  A taxel that reads less than `DEAD` of its share, or whose readings do not
follow the presses, is dead (our derivation).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.sensing.calibration import Calibration
from exploration.sensing.curve import STRAIGHT
from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.surfaces.pressed_field import geometry
from primitives.arrays import Bools, Floats, frozen
from primitives.errors import PalpateError


@dataclass(frozen=True)
class FlatConfig:
    """What is taken for a press, and for a dead taxel."""

    least_presses: int = 2
    prior: float = 0.15  # relative 1 sigma of the gains, where the calibration gives none
    dead: float = 0.25  # of its share, below which a taxel is dead
    straying: float = 0.2  # of its share, root mean square about its own gain, above which it is dead too
    shallow: float = 0.25  # of a press's median depth; shallower taxels may lie beyond its rim
    whole: float = 0.5  # share of the readings below full scale, at least
    steps: int = 12


@dataclass(frozen=True)
class Gains:
    """Relative to the nominal calibration that they were estimated with."""

    relative: Floats  # (rows, columns); 1 where dead
    sigma: Floats  # (rows, columns) relative, the common scale left out
    dead: Bools  # (rows, columns)
    planes: Floats  # (presses, 3) [mm], [1], [1]: depth at the pad's center and its slopes
    chi2: float
    dof: int


def gains_from_flat(
    presses: Sequence[TaxelFrame],
    nominal: Calibration,
    array: TaxelArray,
    averaged: int = 1,
    config: FlatConfig = FlatConfig(),
) -> Gains:
    """Gains from presses that cover the whole pad, each the mean of `averaged` frames."""
    if len(presses) < config.least_presses:
        raise PalpateError(f"gains need {config.least_presses} presses on a flat, not {len(presses)}")
    per_count = 1.0 / nominal.counts_per_depth
    felt = np.array([((press.counts - nominal.zero) * per_count).ravel() for press in presses])
    noise = np.broadcast_to(nominal.noise * per_count / np.sqrt(averaged), array.shape).ravel()
    basis = _basis(nominal, array)
    prior = float(np.sqrt(np.mean(np.square(nominal.gain_sigma)))) or config.prior
    usable = ~nominal.dead.ravel()
    whole = np.array([press.counts.ravel() for press in presses]) < nominal.full_scale - 0.5
    if whole.mean() < config.whole:
        raise PalpateError("the presses on the flat drive most taxels to full scale; press more lightly")
    planes = np.array(
        [_plane(nominal, basis[usable & w], y[usable & w], prior) for y, w in zip(felt, whole, strict=True)]
    )
    expected = nominal.curve.signal(planes @ basis.T)
    if np.median(expected) < 5.0 * np.median(noise):
        raise PalpateError("the presses on the flat are no deeper than the noise; press further")
    told = whole & (expected > config.shallow * np.median(expected, axis=1, keepdims=True))
    share = np.sum(told * felt * expected, axis=0) / np.maximum(np.sum(told * expected**2, axis=0), 1e-12)
    strays = np.sqrt(
        np.sum(told * (felt - share * expected) ** 2, axis=0)
        / np.maximum(np.sum(told * expected**2, axis=0), 1e-12)
    )
    dead = ~usable | (share < config.dead) | (strays > config.straying) | ~told.any(axis=0)
    gain, planes, sigma, chi2, dof = _solve(
        felt, noise, basis, planes, told & ~dead, nominal, prior, config.steps
    )
    if nominal.curve is STRAIGHT and not dead.all():
        mean = float(gain[~dead].mean())
        gain, planes, sigma = gain / mean, planes * mean, sigma / mean
    return Gains(
        frozen(np.where(dead, 1.0, gain).reshape(array.shape)),
        frozen(np.where(dead, 0.0, sigma).reshape(array.shape)),
        frozen(dead.reshape(array.shape), np.bool_),
        frozen(planes),
        chi2,
        dof,
    )


def _basis(nominal: Calibration, array: TaxelArray) -> Floats:
    """(taxels, 3) 1, x and y as the taxels feel them."""
    grid = geometry(array.rows, array.columns, array.pitch, nominal.spread, nominal.margin)
    x, y = grid[2][1].sum(axis=0), grid[3][1].sum(axis=1)
    u, v = np.meshgrid(x, y)
    return np.stack([np.ones(u.size), u.ravel(), v.ravel()], axis=1)


def _plane(nominal: Calibration, basis: Floats, signal: Floats, prior: float) -> Floats:
    """(3,) robust: from the median, weights fall as Cauchy's beyond the gains' scatter."""
    depth = nominal.curve.depth(signal)
    center = float(np.median(depth[depth > 0.3 * np.max(depth, initial=0.0)])) if depth.max() > 0.0 else 0.0
    plane = np.array([center, 0.0, 0.0])
    for step in range(30):
        scale = max(prior * abs(center), 1e-9) * (3.0 if step < 10 else 1.0)
        root = 1.0 / np.sqrt(1.0 + ((depth - basis @ plane) / scale) ** 2)
        plane = np.linalg.lstsq(basis * root[:, None], depth * root, rcond=None)[0]
    return np.asarray(plane)


def _solve(
    felt: Floats,
    noise: Floats,
    basis: Floats,
    planes: Floats,
    told: Bools,
    nominal: Calibration,
    prior: float,
    steps: int,
) -> tuple[Floats, Floats, Floats, float, int]:
    count, taxels = felt.shape
    gain = np.ones(taxels)
    weight = told / noise**2
    for _ in range(steps):
        depth = planes @ basis.T
        signal = nominal.curve.signal(depth)
        slope = 1.0 / nominal.curve.slope(signal)
        residual = felt - gain * signal
        by_plane = (gain * slope)[:, :, None] * basis
        diagonal = np.sum(weight * signal**2, axis=0) + 1.0 / prior**2
        cross = (weight * signal)[:, :, None] * by_plane
        columns = np.transpose(cross, (1, 0, 2)).reshape(taxels, 3 * count)
        normal = -columns.T @ (columns / diagonal[:, None])
        for m in range(count):
            normal[3 * m : 3 * m + 3, 3 * m : 3 * m + 3] += (by_plane[m] * weight[m][:, None]).T @ by_plane[m]
        toward_gain = np.sum(weight * signal * residual, axis=0) - (gain - 1.0) / prior**2
        toward_plane = np.einsum("mi,mij->mj", weight * residual, by_plane).ravel()
        inverse = np.linalg.inv(normal)
        step = inverse @ (toward_plane - columns.T @ (toward_gain / diagonal))
        planes = planes + step.reshape(count, 3)
        gain = gain + (toward_gain - columns @ step) / diagonal
        if np.abs(step).max() < 1e-9:
            break
    scaled = columns / diagonal[:, None]
    live = told.any(axis=0)
    centered = scaled - scaled[live].mean(axis=0)
    own = 1.0 / diagonal
    sigma = np.sqrt(
        own * (1.0 - 1.0 / max(1, live.sum())) + np.einsum("ij,jk,ik->i", centered, inverse, centered)
    )
    chi2 = float(np.sum(weight * (felt - gain * nominal.curve.signal(planes @ basis.T)) ** 2))
    return gain, planes, sigma, chi2, int(told.sum() - live.sum() - 3 * count)

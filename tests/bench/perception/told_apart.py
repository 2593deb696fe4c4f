"""Which lines a detector can find that hardly ever sees one on a smooth surface.

Whoever says "line" on at most `FALSE` of the frames of every smooth surface says it on at most

    Phi(d - z),    d^2 = sum ((f - g) / sigma)^2,    z = Phi^-1(1 - FALSE),

of a press, f being its clean frame and g that of the smooth surface nearest to it (the lemma of Neyman and
Pearson).  Smooth is what is nowhere sharper than a ball whose radius is the pad's length.  The nearest is the best
plane, ridge, ball or dome by the smooth fit if that is smooth; else a simulated bar or ball of that very radius.
A line that is seen must then lie near the truth, which errors as small as the bound's leave to chance too.
"""

from dataclasses import replace

import numpy as np
from perception import presses
from perception.bound import difference, fisher
from perception.noise import Noise
from perception.scene import Scene, clean
from perception.score import FAR_ANGLE, FAR_OFFSET
from scipy.special import ndtr, ndtri
from scipy.stats import multivariate_normal

from exploration.sensing.calibration import correct
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.surfaces.smooth_fit import fit_dome, fit_shape, smooth_contact
from exploration.sensing.surfaces.smooth_shapes import BALL, PLANE, RIDGE
from primitives.arrays import Floats

FALSE = 3e-4  # of the frames of a smooth surface
CLEAR = 60.0  # [chi2] beyond which a line is missed less than once in 10,000
STEPS = 15
DONE = 0.02  # [chi2]
ROUNDING = 1.001  # by which the sharpest ball may be surpassed
DEEPEST, STEEPEST = 2.0, 0.1  # [mm], [rad] of a press


def findable(scenes: list[Scene], noise: Noise) -> float:
    """The greatest share of the lines of these scenes that can be found, and near the truth."""
    shares = []
    for scene in scenes:
        seen = told(scene, noise)
        limits = np.array([FAR_ANGLE, FAR_OFFSET * scene.spec.array.pitch[0]])
        for covariance in fisher(scene, noise).each():
            near = multivariate_normal(np.zeros(2), covariance).cdf(limits, lower_limit=-limits)
            shares.append(seen * float(near))
    return float(np.mean(shares))


def told(scene: Scene, noise: Noise) -> float:
    """The greatest share of presses of a scene that are told from all smooth surfaces."""
    return float(ndtr(np.sqrt(apart(scene, noise)) - ndtri(1 - FALSE)))


def apart(scene: Scene, noise: Noise) -> float:
    """[chi2] between a press and the smooth surface nearest to it; `CLEAR` or more where none is near."""
    depth, calibration = clean(scene), noise.calibration(scene.spec)
    counts = depth * noise.counts / presses.PRESS
    image = replace(correct(TaxelFrame(counts, 0.0, 0), calibration, scene.spec.array), depth=depth)
    contact = smooth_contact(image)
    if not contact:
        return 0.0
    dome = fit_dome(contact)
    if dome.chi2 > CLEAR:
        return dome.chi2
    sharpest = ROUNDING / max(scene.spec.array.size)
    fits = [dome, *(fit_shape(contact, dome, shape) for shape in (PLANE, RIDGE, BALL))]
    near = [f.chi2 for f in fits if f.converged and _curvatures(f.parameters)[0].max() < sharpest]
    sigma = noise.sigma_at(depth)
    near += [_nearest(depth, sigma, *rival) for rival in _sharpest(scene, dome.parameters)]
    return min(near)


def _curvatures(p: Floats) -> tuple[Floats, Floats]:
    """Principal curvatures of a dome, and their directions as columns."""
    values, axes = np.linalg.eigh([[p[3], p[4]], [p[4], p[5]]])
    return values, axes


def _sharpest(scene: Scene, p: Floats) -> list[tuple[Scene, tuple[str, ...]]]:
    """The sharpest bar and ball that are smooth, where a fitted dome is; and what of each is free."""
    rng, spec = np.random.default_rng(0), scene.spec
    radius = float(max(spec.array.size))
    across = _curvatures(p)[1][:, 1]
    away, at = radius * float(across @ p[1:3]), radius * p[1:3]
    bar, ball = presses.bar(rng, radius, spec=spec), presses.ball(rng, radius, spec=spec)
    turn = float(np.arctan2(-across[0], across[1]))
    return [
        (
            _bounded(bar, turn=turn, offset=away, depth=p[0] + away**2 / (2 * radius)),
            ("turn", "offset", "depth", "tilt_x", "tilt_y"),
        ),
        (_bounded(ball, x=at[0], y=at[1], depth=p[0] + at @ at / (2 * radius)), ("x", "y", "depth")),
    ]


def _bounded(scene: Scene, **given: float) -> Scene:
    """A press with some of its numbers, none beyond what presses are."""
    size = max(scene.spec.array.size)
    ranges = {
        "depth": (0.0, DEEPEST),
        "turn": (-np.inf, np.inf),
        **dict.fromkeys(("tilt_x", "tilt_y"), (-STEEPEST, STEEPEST)),
    }
    held = {k: float(np.clip(v, *ranges.get(k, (-size / 2, size / 2)))) for k, v in given.items()}
    return replace(scene, numbers={**scene.numbers, **held})


def _nearest(depth: Floats, sigma: Floats, rival: Scene, free: tuple[str, ...]) -> float:
    """[chi2] between a clean frame and that of a smooth press, its free numbers at their best (Levenberg)."""
    left = ((depth - clean(rival)) / sigma).ravel()
    damping = 1e-2
    for _ in range(STEPS):
        jacobian = np.array([(difference(rival, name) / sigma).ravel() for name in free])
        normal = jacobian @ jacobian.T
        normal[np.diag_indices_from(normal)] *= 1 + damping
        normal[np.diag_indices_from(normal)] += 1e-9
        step = np.linalg.solve(normal, jacobian @ left)
        moved = {name: rival.numbers[name] + by for name, by in zip(free, step, strict=True)}
        trial = _bounded(rival, **moved)
        new = ((depth - clean(trial)) / sigma).ravel()
        gained = float(left @ left - new @ new)
        if gained > 0.0:
            rival, left, damping = trial, new, damping / 10
        else:
            damping *= 30
        if 0.0 <= gained < DONE or damping > 1e4:
            break
    return float(left @ left)

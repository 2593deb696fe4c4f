"""Which lines a detector can find that hardly ever says one too many.

Whoever says "line" on at most `FALSE` of the frames of every smooth surface says it on at most

    Phi(d - z),    d^2 = sum ((f - g) / sigma)^2,    z = Phi^-1(1 - FALSE),

of a press, f being its clean frame and g that of the smooth surface nearest to it (the lemma of Neyman and
Pearson).  Smooth is what is nowhere sharper than a ball whose radius is the pad's length, and on the pad of the
table a ball as small as the rows of false lines have, pressed as those rows press: within `AWAY` of the pad's
center, leaning no more than the tilted edges, not twice as deep.  The nearest is the best plane, ridge, ball or
dome by the smooth fit if that is smooth; the best dome that is (`nearest_dome`); or a simulated bar or ball of the
very least radius.  No detector is told radius, place or depth, so every such surface counts by itself.  Who says
lines oftener there may find more: ours does so on the other pads, of whose false lines nothing is asked.

Whoever in the same way hardly ever says a second or third line where there is none says it no more often than the
nearest frame of one or of two lines lets him.  What is said must then lie near the truth, which errors as small as
the bound's leave to chance too.
"""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
from perception import presses
from perception.arrays import PAD
from perception.bound import difference, fisher
from perception.nearest_dome import nearest_dome
from perception.noise import Noise
from perception.scene import Scene, clean
from perception.score import FAR_ANGLE, FAR_OFFSET
from scipy.special import ndtr, ndtri
from scipy.stats import multivariate_normal

from exploration.sensing.calibration import correct
from exploration.sensing.frame import TactileImage, TaxelFrame
from exploration.sensing.lines.region import NO_TERMS, ONE, TWO, Region
from exploration.sensing.lines.region_fit import fit_region
from exploration.sensing.response import response_of
from exploration.sensing.surfaces.smooth_fit import fit_dome, fit_shape, smooth_contact
from exploration.sensing.surfaces.smooth_shapes import BALL, PLANE, RIDGE
from primitives.arrays import Floats

FALSE = 3e-4  # of the frames of a smooth surface
CLEAR = 60.0  # [chi2] beyond which a line is missed less than once in 10,000
STEPS = 15
DONE = 0.02  # [chi2]
ROUNDING = 1.001  # by which the sharpest ball may be surpassed
DEEPEST, STEEPEST, AWAY = 2 * presses.PRESS, np.radians(2.0), 6.0  # [mm], [rad], [mm] of a press
FLAT = 1e-4  # [1/mm] below which nothing tells where a pole is
NEAREST = 4  # outlines of fewer lines, of which all steps are taken


def findable(scenes: list[Scene], noise: Noise, times: float = np.inf) -> float:
    """The greatest share of the lines of these scenes that can be found, within `times` the bound of the truth."""
    found, total = 0.0, 0
    for scene in scenes:
        limits = np.array([FAR_ANGLE, FAR_OFFSET * scene.spec.array.pitch[0]])
        near = []
        for covariance in fisher(scene, noise).each():
            within = np.minimum(limits, times * np.sqrt(np.diag(covariance)))
            near.append(float(multivariate_normal(np.zeros(2), covariance).cdf(within, lower_limit=-within)))
        smooth = apart(scene, noise)
        for count, right in enumerate(sorted(near, reverse=True)):
            rival = min(smooth, fewer(scene, noise, count)) if count else smooth
            found += min(right, _power(rival))
        total += len(near)
    return found / total


def told(scene: Scene, noise: Noise) -> float:
    """The greatest share of presses of a scene that are told from all smooth surfaces."""
    return _power(apart(scene, noise))


def _power(chi2: float) -> float:
    return float(ndtr(np.sqrt(chi2) - ndtri(1 - FALSE)))


def fewer(scene: Scene, noise: Noise, count: int) -> float:
    """[chi2] between a press and the nearest outline of `count` lines that some of its own lead to."""
    image = quiet(scene, noise)
    response = response_of(image)
    starts = []
    for lines in combinations(scene.found, count):
        for sides in product((1.0, -1.0), repeat=count):
            region = Region(sides, TWO[0] if count > 1 else ONE[0])
            starts.append(fit_region(image, response, region, np.ravel(lines), 0))
    starts.sort(key=lambda fit: fit.chi2)
    ends = [fit_region(image, response, at.region, at.parameters[3:]) for at in starts[:NEAREST]]
    return min((fit.chi2 for fit in ends if fit.converged), default=np.inf)


def even(scene: Scene, noise: Noise) -> float:
    """How often at most a ball and the flat pin nearest to it are each called what they are, both as often."""
    image, n = quiet(scene, noise), scene.numbers
    response, pin = response_of(image), Region((), NO_TERMS, (1.0,))
    widths = np.array([0.5, 0.8, 1.1]) * np.sqrt(2 * n["depth"] * n["radius"])
    fits = [fit_region(image, response, pin, [n["x"], n["y"], width]) for width in widths]
    return float(ndtr(np.sqrt(min((fit.chi2 for fit in fits if fit.converged), default=CLEAR)) / 2))


def quiet(scene: Scene, noise: Noise) -> TactileImage:
    """What noise would have been added to, but for the deviations that stay."""
    depth = clean(scene)
    counts = TaxelFrame(depth * noise.counts / presses.PRESS, 0.0, 0)
    return replace(correct(counts, noise.calibration(scene.spec), scene.spec.array), depth=depth)


def apart(scene: Scene, noise: Noise) -> float:
    """[chi2] between a press and the smooth surface nearest to it; `CLEAR` or more where none is near."""
    image = quiet(scene, noise)
    depth, contact = image.depth, smooth_contact(image)
    if not contact:
        return 0.0
    dome = fit_dome(contact)
    if dome.chi2 > CLEAR:
        return dome.chi2
    least, roundest = max(scene.spec.array.size), _smallest_ball(scene)
    fits = [(dome, least), *((fit_shape(contact, dome, shape), least) for shape in (PLANE, RIDGE))]
    fits.append((fit_shape(contact, dome, BALL), roundest))
    near = [f.chi2 for f, radius in fits if f.converged and _is_smooth(f.parameters, ROUNDING / radius)]
    near.append(nearest_dome(contact, 1 / least, AWAY, DEEPEST, STEEPEST))
    sigma = noise.sigma_at(depth)
    near += [_nearest(depth, sigma, *rival) for rival in _sharpest(scene, dome.parameters)]
    return min(near)


def _smallest_ball(scene: Scene) -> float:
    """[mm] radius of the smallest ball on which no line may be said."""
    return min(presses.BALLS) if scene.spec == PAD else float(max(scene.spec.array.size))


def _curvatures(p: Floats) -> tuple[Floats, Floats]:
    """Principal curvatures of a dome, and their directions as columns."""
    values, axes = np.linalg.eigh([[p[3], p[4]], [p[4], p[5]]])
    return values, axes


def _is_smooth(p: Floats, sharpest: float) -> bool:
    """Whether a fitted dome is, and its pole no farther away than smooth surfaces are pressed."""
    bend, axes = _curvatures(p)
    curved = np.abs(bend) > FLAT
    pole = axes[:, curved] @ (axes[:, curved].T @ p[1:3] / bend[curved])
    return bool(bend.max() < sharpest and np.hypot(*pole) < AWAY)


def _sharpest(scene: Scene, p: Floats) -> list[tuple[Scene, tuple[str, ...]]]:
    """The sharpest bar and balls that are smooth, where a fitted dome is; and what of each is free."""
    rng, spec = np.random.default_rng(0), scene.spec
    radius = float(max(spec.array.size))
    across = _curvatures(p)[1][:, 1]
    away = radius * float(across @ p[1:3])
    turn = float(np.arctan2(-across[0], across[1]))
    bar = presses.bar(rng, radius, spec=spec)
    depth = p[0] + away**2 / (2 * radius)
    out: list[tuple[Scene, tuple[str, ...]]] = [
        (_bounded(bar, turn=turn, offset=away, depth=depth), ("turn", "offset", "depth", "tilt_x", "tilt_y"))
    ]
    for least in sorted({radius, _smallest_ball(scene)}):
        ball, at = presses.ball(rng, least, spec=spec), least * p[1:3]
        depth = p[0] + at @ at / (2 * least)
        out.append((_bounded(ball, x=at[0], y=at[1], depth=depth), ("x", "y", "depth")))
    return out


def _bounded(scene: Scene, **given: float) -> Scene:
    """A press with some of its numbers, none beyond what presses are."""
    reach = min(AWAY, max(scene.spec.array.size) / 2)
    ranges = {
        "depth": (0.0, DEEPEST),
        "turn": (-np.inf, np.inf),
        **dict.fromkeys(("tilt_x", "tilt_y"), (-STEEPEST, STEEPEST)),
    }
    held = {k: float(np.clip(v, *ranges.get(k, (-reach, reach)))) for k, v in given.items()}
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

"""The kind of a touch by evidence: nothing, flat, edge, ridge, corner or curved, with a probability each.

Each reading of a frame, with chi2 at its best, has evidence (Laplace; our derivation)

    log E = log prior - chi2 / 2 s + log det(2 pi C)/2 + log p,

C the covariance of its unknowns, p their density before touch, and s = max(1, chi2 per degree of freedom of the
best reading), so that what no reading explains is not held for any.  Before touch depth is even over 2 mm; slopes
are N(0, 0.1), but where the surface is curved its pole is even over the pad; curvatures are N(0, 0.1 / mm) by
`order`; what lines and arcs are even over is in `cut_readings`.  "Nothing" has no unknowns.

One line or arc is an edge; two nearly parallel lines are a ridge, or a slot's two edges; any others are a corner;
a smooth surface sharper than `SHARP` is a ridge or a corner as far as its curvature is known (our choice).

What was never fitted, as a third edge or a wall too short for the search, has no evidence.  It keeps the share
that it had among simulated frames which were told for sure as something else (`UNFITTED`): faces, edges, corners,
walls, discs, holes, balls and bars at 2 to 10 % noise.
"""

from collections.abc import Sequence
from math import exp, hypot, inf, log, sqrt

import numpy as np
from scipy.special import ndtr

from exploration.sensing.cut_readings import LEVEL, TURNED, Reading
from exploration.sensing.surfaces.local_surface import LocalSurface
from exploration.sensing.surfaces.order import Ordered
from exploration.sensing.surfaces.smooth_fit import SmoothContact

KINDS = ("nothing", "flat", "edge", "ridge", "corner", "curved")
SHARP = 0.3  # [1/mm] curvature from which a smooth contact is a ridge or a corner
LEAST = 0.002  # probability left to every kind
PRIOR = {"nothing": 0.1, "smooth": 0.3, "edge": 0.12, "ridge": 0.35, "corner": 0.13}
UNFITTED = {
    "nothing": {"curved": 0.02, "corner": 0.04},
    "edge": {"corner": 0.1, "curved": 0.01},
    "curved": {"corner": 0.04, "ridge": 0.03, "edge": 0.01},
}  # least probability of another kind, by the likeliest
CERTAIN = 1.0 - LEAST  # probability of a plane that nothing rivals, from which no other kind is weighed


def probabilities(
    contact: SmoothContact, ordered: Ordered, smooth: LocalSurface, readings: Sequence[Reading]
) -> tuple[dict[str, float], Reading | None]:
    """(`KINDS`) of a frame whose smooth reading is `ordered`, beside those with lines; the one that stands.

    None stands where the smooth reading is the likeliest of all.
    """
    if not readings and ordered.probability[0] > CERTAIN:
        return only("flat"), None
    empty = float(np.sum((contact.depth * contact.precision) ** 2))
    best = min([(smooth.chi2, smooth.dof), *((r.chi2, r.dof) for r in readings)])
    scale = max(1.0, best[0] / max(1, best[1]))
    logs = dict.fromkeys(KINDS, -inf)
    values, sharp, both = sharpness(smooth)
    size = hypot(contact.x[-1] - contact.x[0], contact.y[-1] - contact.y[0])
    whole = -0.5 * ordered.chi2 / scale + log(PRIOR["smooth"]) + ordered.evidence + ordered.volume
    poles = exp(-log(2.0) - sum(log(max(TURNED, abs(k) * size)) for k in values))
    odds = [max(float(p), 1e-300) * (poles if i else exp(LEVEL)) for i, p in enumerate(ordered.probability)]
    whole += log(sum(odds))
    flat = odds[0] / sum(odds)
    for kind, share in (
        ("flat", flat),
        ("curved", (1.0 - flat) * (1.0 - sharp)),
        ("ridge", (1.0 - flat) * sharp * (1.0 - both)),
        ("corner", (1.0 - flat) * sharp * both),
    ):
        if share > 0.0:
            logs[kind] = whole + log(share)
    logs["nothing"] = -0.5 * empty / scale + log(PRIOR["nothing"])
    stands, highest = None, max(logs.values())
    for reading in readings:
        value = -0.5 * reading.chi2 / scale + reading.volume + log(PRIOR[reading.kind])
        logs[reading.kind] = float(np.logaddexp(logs[reading.kind], value))
        if value > highest:
            stands, highest = reading, value
    top = max(logs.values())
    return floored({kind: exp(logs[kind] - top) for kind in KINDS}), stands


def floored(weight: dict[str, float]) -> dict[str, float]:
    """Probabilities in proportion to weights, but none below `LEAST` or what the likeliest leaves the unfitted."""
    total = sum(weight.values())
    floor = dict.fromkeys(KINDS, LEAST) | UNFITTED.get(max(weight, key=lambda kind: weight[kind]), {})
    raised = {kind: max(weight[kind] / total, floor[kind]) for kind in KINDS}
    whole = sum(raised.values())
    return {kind: value / whole for kind, value in raised.items()}


def only(kind: str) -> dict[str, float]:
    """All that is left to a kind which nothing rivals."""
    return {name: 1.0 - LEAST * (len(KINDS) - 1) if name == kind else LEAST for name in KINDS}


def sharpness(surface: LocalSurface) -> tuple[tuple[float, float], float, float]:
    """Principal curvatures, and the probabilities that the greater, and the lesser, is sharp."""
    (kxx, kxy), (_, kyy) = surface.curvature.tolist()
    mean, half = 0.5 * (kxx + kyy), hypot(0.5 * (kxx - kyy), kxy)
    values = mean + half, mean - half
    if not surface.curved:
        return values, 0.0, 0.0
    variance = surface.curvature_covariance
    sigma = sqrt(max(float(variance[0, 0]), float(variance[2, 2]))) + 1e-6
    return (
        values,
        float(ndtr((values[0] - SHARP) / sigma)),
        float(ndtr((values[1] - SHARP / 2) / sigma)),
    )

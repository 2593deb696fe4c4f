"""Whether all contacts lie on one round face: a cylinder, cone, sphere or torus that explains them.

Contacts from anywhere on a body with other faces, too, hardly ever do so, and where they do, as on a long rod, how
far they reach along the face still tells its size.  So they are taken to be drawn from that face (`places`).

The normals of each of these faces meet its axis, or are square to it: with p a contact from the middle of all in
sizes, the rows (n, p x n) leave one direction of six free (Pottmann and Randrup 1998).  Where they do not, none of
the shapes need be fitted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.evidence import Contacts
from primitives.fit import Fit, FitOptions, fit
from primitives.shapes import Shape
from recognition.matching.contact_pairs import spread

KINDS = ("sphere", "cylinder", "cone", "torus")


@dataclass(frozen=True)
class RoundConfig:
    """When a shape explains contacts."""

    least: int = 10  # residuals more than a shape has parameters
    most: int = 60  # contacts that are asked; of more, those farthest apart
    explained: float = 3.0  # chi squared of each degree of freedom: models of what is touched are coarse
    turning: float = 3.0  # sigmas of the free direction, beyond which no axis is met
    fit: FitOptions = FitOptions(gain=1e-4, iterations=12, starts=2)  # noqa: RUF009


def round_face(contacts: Contacts, config: RoundConfig = RoundConfig()) -> Shape | None:
    """The simplest round shape that explains contacts whose sigmas are their own."""
    few = contacts.select(spread(contacts, config.most))
    residuals = len(few) + 2 * int(few.has_normal.sum())
    if residuals < config.least + 4 or not _about_an_axis(few, config):
        return None
    for kind in KINDS:
        found = fit(kind, few, config.fit)
        if isinstance(found, Fit) and found.dof >= config.least and found.chi2 < config.explained * found.dof:
            return found.shape
    return None


def _about_an_axis(c: Contacts, config: RoundConfig) -> bool:
    felt = c.has_normal
    if felt.sum() < 6:
        return True
    points, normals = c.points[felt], c.normals[felt]
    arms = points - points.mean(axis=0)
    size = max(float(np.sqrt((arms**2).sum(axis=1).mean())), 1e-9)
    rows = np.hstack([normals, np.cross(arms, normals) / size])
    off = float(np.linalg.svd(rows, compute_uv=False)[-1]) / np.sqrt(len(rows))
    expected = np.hypot(float(np.median(c.normal_sigma[felt])), float(np.median(c.sigma[felt])) / size)
    return bool(off < config.turning * expected)

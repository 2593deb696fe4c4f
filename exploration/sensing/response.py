"""How a straight edge looks to a taxel: the sensor's physics, tabulated once, used by every detector.

Rubber over pressure taxels (our derivation).  A half-plane pressed z0 deep into the skin makes a step of pressure.
The rubber spreads it with a Gaussian of standard deviation `spread`, so at distance d from the edge

    z(d) = z0/2 (1 - erf(d / (sqrt(2) spread))),

and the taxel averages that over its own area.  Across an edge with unit normal m the taxel is a box of
variance v = (px^2 mx^2 + py^2 my^2)/12 and fourth cumulant -(px^4 mx^4 + py^4 my^4)/120, which for any taxel not
much wider than the blur is exact enough to second order of the Edgeworth series.  With w^2 = spread^2 + v,
u = t/w the distance into the material in widths, k = fourth cumulant / w^4 and He the Hermite polynomials,

    line(u) = phi(u) (1 + k/24 He4(u))                  what a thin line of pressure looks like,
    edge(u) = Phi(u) - k/24 He3(u) phi(u)               its integral: a step,
    ramp(u) = u Phi(u) + phi(u) + k/24 He2(u) phi(u)    its integral: a plateau that slopes away from the edge,
    bend(u) = ((u^2 + 1) Phi(u) + u phi(u))/2 - k/24 u phi(u)    and again: one that curves.

The half-height crossing is the edge.  Another physics is another `line`: `Response.of_line_spread` integrates
any that is sampled, `capacitive` derives one, and all detectors take the `Response` as an argument.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

import numba
import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr

from primitives.arrays import Floats, frozen

REACH = 6.0  # [widths] beyond this a step is over
CELLS = 1536  # of the table; linear interpolation errs by less than 2e-6 of the step


@dataclass(frozen=True)
class Response:
    """The response across a straight edge, in units of its width."""

    table: Floats  # (CELLS + 1, 4) line, edge, ramp and bend at u = -REACH .. REACH
    variance: Floats  # (2,) [mm^2] of the width across edges whose normal is x, and y

    def width(self, normal: ArrayLike) -> float:
        """[mm] standard deviation of the response across an edge with this unit normal."""
        mx, my = np.asarray(normal, dtype=float)
        return float(np.sqrt(self.variance[0] * mx * mx + self.variance[1] * my * my))

    @cached_property
    def mean_width(self) -> float:
        """[mm] root mean square of the width over all directions."""
        return float(np.sqrt(np.mean(self.variance)))

    def edge(self, distance: ArrayLike, width: float) -> Floats:
        """Share of the plateau that is seen `distance` [mm] inside the material."""
        return np.interp(np.asarray(distance) / width, _abscissa(), self.table[:, 1], left=0.0, right=1.0)

    @staticmethod
    def of_line_spread(line: Floats, variance: ArrayLike) -> "Response":
        """A response from a line spread of unit variance, at `CELLS + 1` points of u in -REACH .. REACH."""
        step = 2 * REACH / CELLS
        line = line / (np.sum(line) * step)
        edge = np.concatenate([[0.0], np.cumsum((line[1:] + line[:-1]) * step / 2)])
        ramp = np.concatenate([[0.0], np.cumsum((edge[1:] + edge[:-1]) * step / 2)])
        bend = np.concatenate([[0.0], np.cumsum((ramp[1:] + ramp[:-1]) * step / 2)])
        return Response(frozen(np.stack([line, edge, ramp, bend], axis=1)), frozen(variance))


@lru_cache(maxsize=64)
def rubber(spread: float, pitch: tuple[float, float]) -> Response:
    """The response of a rubber skin over pressure taxels; see the module's derivation."""
    px, py = pitch
    variance = np.array([spread**2 + px**2 / 12, spread**2 + py**2 / 12])
    mean_fourth = -3 / 8 * (px**4 + py**4) / 120
    k = mean_fourth / np.mean(variance) ** 2 / 24
    u = _abscissa()
    phi = np.exp(-u * u / 2) / np.sqrt(2 * np.pi)
    line = phi * (1 + k * (u**4 - 6 * u**2 + 3))
    edge = ndtr(u) - k * (u**3 - 3 * u) * phi
    ramp = u * ndtr(u) + phi * (1 + k * (u**2 - 1))
    bend = ((u**2 + 1) * ndtr(u) + u * phi) / 2 - k * u * phi
    return Response(frozen(np.stack([line, edge, ramp, bend], axis=1)), frozen(variance))


class Pitched(Protocol):
    """A layout, as far as a response depends on it."""

    @property
    def pitch(self) -> tuple[float, float]:
        """(x, y) [mm]."""
        ...


class Blurred(Protocol):
    """An image that knows how its sensor blurs (`frame.TactileImage`)."""

    @property
    def array(self) -> Pitched:
        """Its layout."""
        ...

    @property
    def spread(self) -> float:
        """[mm] standard deviation."""
        ...

    @property
    def response(self) -> Response | None:
        """The sensor's own; None for rubber of that spread."""
        ...


def response_of(image: Blurred, response: Response | None = None) -> Response:
    """`response`, or the image's own, or rubber of the image's spread and pitch."""
    response = response or image.response
    return rubber(image.spread, image.array.pitch) if response is None else response


def _abscissa() -> Floats:
    return np.linspace(-REACH, REACH, CELLS + 1)


@numba.njit(cache=True, inline="always")
def look_up(table: Floats, u: float, order: int) -> tuple[float, float, float]:
    """Line, edge and ramp at u; or edge, ramp and bend, of `order` 1."""
    if u <= -REACH:
        return 0.0, 0.0, 0.0
    if u >= REACH:
        return (0.0, 1.0, u) if order == 0 else (1.0, u, 0.5 * (u * u + 1.0))
    place = (u + REACH) * (CELLS / (2 * REACH))
    i = int(place)
    f = place - i
    return (
        table[i, order] + f * (table[i + 1, order] - table[i, order]),
        table[i, order + 1] + f * (table[i + 1, order + 1] - table[i, order + 1]),
        table[i, order + 2] + f * (table[i + 1, order + 2] - table[i, order + 2]),
    )

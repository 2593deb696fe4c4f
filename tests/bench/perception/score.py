"""How far lines lie from the truth, and rows of the table from many such errors.

Errors are paired with the true lines so that their normalized squares are least.  Ratios over the bound are root
mean squares of error over those of the bound, all frames pooled; `frame by frame` divides each error by its own
frame's bound first, so that no ill-determined frame speaks for all.  Failures are left out of both, and counted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from scipy.optimize import linear_sum_assignment

from primitives.arrays import Floats

FAR = 1e9  # cost of a pair that is none
FAR_ANGLE, FAR_OFFSET = np.radians(15.0), 1.5  # [rad], [taxel] a failure
HELD = 1 / 5  # of a failure: the bound of a line that a frame holds


class Straight(Protocol):
    """What is scored of a line: [rad], [mm]."""

    @property
    def angle(self) -> float: ...
    @property
    def offset(self) -> float: ...


def row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, Any]:
    found = {"bench": "perception", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return found | ({} if asked is None else {"asked": asked})


def line_error(line: tuple[float, float], truth: Floats) -> Floats:
    """(2,) angle [rad] and offset [mm] of a line less those of the truth, whichever way each points."""
    turns = np.floor((line[0] - truth[0]) / np.pi + 0.5)
    sign = -1.0 if turns % 2 else 1.0
    return np.array([line[0] - truth[0] - turns * np.pi, sign * line[1] - truth[1]])


def is_far(error: Floats, pitch: float) -> bool:
    return bool(abs(error[0]) > FAR_ANGLE or abs(error[1]) > FAR_OFFSET * pitch)


def paired(lines: Sequence[Straight], truth: Floats, least: Floats, pitch: float) -> list[Floats | None]:
    """The error of the line that stands for each true one; None where there is none near."""
    out: list[Floats | None] = [None] * len(truth)
    if not lines:
        return out
    errors = np.array([[line_error((line.angle, line.offset), t) for line in lines] for t in truth])
    far = [[is_far(e, pitch) for e in of_one] for of_one in errors]
    cost = np.where(far, FAR, np.minimum(FAR / 2, (errors**2 / least[:, None]).sum(axis=2)))
    for i, k in zip(*linear_sum_assignment(cost), strict=True):
        if not far[i][k]:
            out[i] = errors[i, k]
    return out


@dataclass
class Tally:
    """The errors of one method over many frames."""

    method: str
    pitch: float
    errors: list[Floats] = field(default_factory=list)  # (2,)
    least: list[Floats] = field(default_factory=list)  # (2,) variances of the bound, beside each
    told: list[Floats] = field(default_factory=list)  # the same for who knows the zero
    held: list[bool] = field(
        default_factory=list
    )  # of every true line, whether its bound is well below failure
    held_near: int = 0  # of those, found within 5 times the bound
    times: list[float] = field(default_factory=list)  # [s]
    missed: int = 0
    surplus: int = 0
    frames: int = 0

    def add(self, lines: Sequence[Straight], truth: Floats, least: Floats, told: Floats, took: float) -> None:
        self.frames += 1
        self.times.append(took)
        if len(truth) == 1:
            error = line_error((lines[0].angle, lines[0].offset), truth[0]) if lines else None
            found = [None if error is None or is_far(error, self.pitch) else error]
        else:
            found = paired(lines[:6], truth, least, self.pitch)
        for error, variance, sharper in zip(found, least, told, strict=True):
            limits = HELD * np.array([FAR_ANGLE, FAR_OFFSET * self.pitch])
            self.held.append(bool(np.all(variance < limits**2)))
            if self.held[-1] and error is not None:
                self.held_near += bool(np.all(np.square(error) < 25.0 * variance))
            if error is None:
                self.missed += 1
            else:
                self.errors.append(error)
                self.least.append(variance)
                self.told.append(sharper)
        self.surplus += max(0, len(lines) - len(truth))

    @property
    def total(self) -> int:
        return self.missed + len(self.errors)

    def pooled(self, told: bool = False) -> Floats:
        """(2,) RMS over that of the bound, of who is told the zero or is not."""
        if not self.errors:
            return np.full(2, np.inf)
        least = self.told if told else self.least
        return np.sqrt(np.mean(np.square(self.errors), axis=0) / np.mean(least, axis=0))

    def by_frame(self) -> Floats:
        """(2,) RMS of error over its own bound."""
        if not self.errors:
            return np.full(2, np.inf)
        return np.sqrt(np.mean(np.square(self.errors) / np.array(self.least), axis=0))

    def within(self, times: float) -> float:
        """Share of true lines found within so many times the bound, in angle and offset both [%]."""
        if not self.errors:
            return 0.0
        near = np.all(np.square(self.errors) < times**2 * np.array(self.least), axis=1)
        return 100.0 * float(near.sum()) / self.total

    def held_within(self) -> float:
        """The same [%] of the lines that their frames hold: nobody finds the others."""
        return 100.0 * self.held_near / max(1, sum(self.held))

    def median_time(self) -> float:
        """[us]."""
        return 1e6 * float(np.median(self.times))

"""What recognition trials say together: right names against touches, calibration, and who is taken for whom."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from recognition.experiments.statistics import Estimate, Unit, mean_of_units, share
from recognition.experiments.trial import Row

BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0)  # of confidence; stated ones crowd near 1
AREA = "touch_curve_area"


def held(told: str, touches: int) -> list[bool]:
    """Whether the right name led after each of so many touches; what led last goes on leading."""
    right = [mark == "1" for mark in told[:touches]]
    return right + [bool(right and right[-1])] * (touches - len(right))


def against_touches(rows: Sequence[Row], units: Sequence[Unit]) -> dict[str, Any] | None:
    """The share of right names after each touch, and the area under it (its mean over the touches)."""
    marked = [
        (row, unit)
        for row, unit in zip(rows, units, strict=True)
        if row.get("first_touches_right") is not None
    ]
    if not marked:
        return None
    most = max(int(row["max_touches"] or 0) for row, _ in marked)
    led = [held(str(row["first_touches_right"]), most) for row, _ in marked]
    mine = [unit for _, unit in marked]
    curve = [share([one[touch] for one in led], mine) for touch in range(most)]
    area = _share_bounds(mean_of_units([float(np.mean(one)) for one in led], mine))
    return {
        "curve": [{"touch": k + 1, **asdict(point)} for k, point in enumerate(curve) if point is not None],
        "area": None if area is None else {"of": "mean", **asdict(area)},
    }


def _share_bounds(found: Estimate | None) -> Estimate | None:
    """An area is a mean of shares, and so is what it may be."""
    if found is None or found.low is None or found.high is None:
        return found
    return replace(found, low=max(0.0, found.low), high=min(1.0, found.high))


def calibration(rows: Sequence[Row], units: Sequence[Unit]) -> dict[str, Any] | None:
    """Stated confidence against the share that was right, with its expected error (Naeini et al. 2015)."""
    told = [
        (float(row["confidence"] or 0.0), bool(row["correct"]), unit)
        for row, unit in zip(rows, units, strict=True)
        if row.get("decision") is not None and row.get("correct") is not None
    ]
    if not told:
        return None
    confidence, right = np.array([t[0] for t in told]), np.array([t[1] for t in told], dtype=float)
    place = np.clip(np.searchsorted(BINS, confidence, side="right") - 1, 0, len(BINS) - 2)
    bins, error = [], 0.0
    for k in np.unique(place).tolist():
        mine = np.flatnonzero(place == k)
        found = share([told[i][1] for i in mine], [told[i][2] for i in mine])
        assert found is not None
        stated = float(confidence[mine].mean())
        error += len(mine) / len(told) * abs(stated - found.value)
        bins.append({"from": BINS[k], "to": BINS[k + 1], "confidence": stated, **asdict(found)})
    return {
        "bins": bins,
        "expected_calibration_error": error,
        "brier": float(np.mean((confidence - right) ** 2)),
    }


def confusion(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """How often each object was decided to be what; what never happened is left out."""
    counts = Counter(
        (str(row["answer"]), "nothing" if row["decision"] is None else str(row["decision"]))
        for row in rows
        if row.get("answer") is not None
    )
    return [
        {"answer": answer, "decision": decision, "trials": n}
        for (answer, decision), n in sorted(counts.items())
    ]

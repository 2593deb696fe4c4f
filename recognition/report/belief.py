"""What an identification believed after each touch, as its page shows it over time."""

from __future__ import annotations

from typing import Any

_LINES = 6  # names that are drawn: those that were believed most at some touch


def belief_payload(history: Any) -> dict[str, Any] | None:
    """Names, times [s], and a share for each name at each time; None where a run believes nothing.

    A step lists its likeliest names only; one that is not listed counts as 0 there.
    """
    steps = [step for step in history or [] if step.get("top") and step.get("device_seconds") is not None]
    if not steps:
        return None
    most: dict[str, float] = {}
    for step in steps:
        for name, share in step["top"]:
            most[name] = max(most.get(name, 0.0), share)
    last = dict(map(tuple, steps[-1]["top"]))
    names = sorted(most, key=lambda name: (-last.get(name, 0.0), -most[name]))
    drawn = set(sorted(names, key=lambda name: -most[name])[:_LINES])
    names = [name for name in names if name in drawn]
    shares = [dict(map(tuple, step["top"])) for step in steps]
    return {
        "names": names,
        "times": [step["device_seconds"] for step in steps],
        "shares": [[row.get(name, 0.0) for name in names] for row in shares],
        "touches": [step["touch"] for step in steps],
        "felt": [str(step.get("felt") or "") for step in steps],
        "entropy": [step.get("entropy_bits") for step in steps],
    }

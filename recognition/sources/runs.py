"""The run folders that are there to choose from, as rows for a table."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from recognition.running.folder import RECORDING, SUMMARY

RUNS = Path("runs")  # where runs go that nobody said a folder for


def run_rows(below: Path = RUNS, most: int = 20) -> list[dict[str, Any]]:
    """The latest runs below a folder; none where it is not there."""
    try:
        found = [path for path in below.iterdir() if (path / RECORDING).is_file()]
        found.sort(key=lambda path: -path.stat().st_mtime_ns)
    except OSError:
        return []
    return [_row(path) for path in found[:most]]


def _row(run: Path) -> dict[str, Any]:
    try:
        told = json.loads((run / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        told = {}
    told = told if isinstance(told, dict) else {}
    ended = str(told.get("ended") or "cut short")
    return {
        "run": str(run),
        "part": str(told.get("part") or ""),
        "touches": told.get("touches"),
        "ended": ended,
    }

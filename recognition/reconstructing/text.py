"""What `palpate reconstruct` prints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from recognition.report.terminal import summary_text as run_text


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """As a run is told, its first lines those of a source."""
    s = summary
    ended = "closed" if s["closed"] else f"not closed ({s['ended']})"
    sigma = f"{s['contact_sigma_mm']:.3g} mm"
    told = f"{s['part']}: {ended} from {s['contacts']} contacts of {sigma} (1 sigma), in {s['wall_seconds']:.1f} s"
    return "\n".join([told, *run_text(s, folder).split("\n")[2:]])

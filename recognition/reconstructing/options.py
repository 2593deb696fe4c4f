"""What `palpate reconstruct` can be told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from primitives.errors import PalpateError


@dataclass(frozen=True)
class ReconstructSourceOptions:
    """Checked once; lengths in mm."""

    source: Path
    contact_sigma: float | None = None  # [mm] of the contacts; None: as measured, else estimated
    seed: int = 0
    out: Path | None = None  # None: a new folder below runs/
    overwrite: bool = False

    def __post_init__(self) -> None:
        require_sigma(self.contact_sigma)
        if self.seed < 0:
            raise PalpateError(f"--seed must be 0 or more, not {self.seed}")
        if self.out is not None and self.source.is_dir() and self.out.resolve() == self.source.resolve():
            raise PalpateError(f"--out {self.out} is the source itself; give another folder")

    def as_settings(self) -> dict[str, object]:
        """Under the names that they have in `config.toml`."""
        sigma = "auto" if self.contact_sigma is None else self.contact_sigma
        return {"source": str(self.source), "contact_sigma_mm": sigma, "seed": self.seed}


def parse_sigma(text: str) -> float | None:
    """`auto`, or a length in mm."""
    if text == "auto":
        return None
    try:
        sigma = float(text)
    except ValueError:
        sigma = math.nan
    require_sigma(sigma, text)
    return sigma


def require_sigma(sigma: float | None, text: str = "") -> None:
    """Refuse what no contact's sigma can be."""
    if sigma is not None and not (math.isfinite(sigma) and sigma > 0):
        raise PalpateError(f"--contact-sigma must be auto or a positive length in mm, not {text or sigma}")

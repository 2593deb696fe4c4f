"""The settings of `palpate probe`: those of exploring, which procedure, and what the object is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from exploration.control.procedures.catalog import CANNOT, PROCEDURES, Procedure, named
from models.material import Materials
from primitives.errors import PalpateError
from recognition.config import ExploreOptions


@dataclass(frozen=True)
class ProbeOptions(ExploreOptions):
    """Everything `palpate probe` can be told."""

    sensors: tuple[str, ...] = ("lts210",)
    procedure: str = ""
    force_n: float = 20.0  # of an approach, and of compliance
    stiffness_n_mm3: float | None = None  # of the simulated object, all over; None: as `material`, or rigid
    roughness_mm: float | None = None  # likewise; None: as `material`, or smooth
    material: str | None = None  # a TOML file with both, face by face
    latency_s: float = 0.02  # of the simulated stage; measured, never told

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (math.isfinite(self.force_n) and self.force_n > 0.0):
            raise PalpateError(f"--force-n must be a positive number, not {self.force_n}")
        if not (math.isfinite(self.latency_s) and 0.0 <= self.latency_s <= 0.2):
            raise PalpateError(f"--latency-s must lie between 0 and 0.2, not {self.latency_s}")

    def known(self) -> Procedure:
        """The procedure, or a line that says why there is none of that name."""
        if why := CANNOT.get(self.procedure):
            raise PalpateError(f"no {self.procedure}: {why}")
        if found := named(self.procedure):
            return found
        if not self.procedure:
            raise PalpateError("probe needs a part and a procedure: palpate probe block hardness")
        near = get_close_matches(self.procedure, [p.name for p in PROCEDURES], n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise PalpateError(f"no procedure {self.procedure!r}{hint}")

    def materials(self) -> Materials:
        """What the object is made of; the two flags change the whole body, and no face that a file names."""
        told = Materials() if self.material is None else Materials.from_toml(Path(self.material))
        changed = {
            name: value
            for name, value in (("stiffness", self.stiffness_n_mm3), ("roughness", self.roughness_mm))
            if value is not None
        }
        return replace(told, whole=replace(told.whole, **changed))


def procedure_rows() -> list[dict[str, object]]:
    """Every procedure, and at the end those that one array on one stage cannot do."""
    can: list[dict[str, object]] = [
        {"procedure": p.name, "property": p.serves, "does": p.does} for p in PROCEDURES
    ]
    return can + [
        {"procedure": name, "property": "not possible", "does": why} for name, why in CANNOT.items()
    ]

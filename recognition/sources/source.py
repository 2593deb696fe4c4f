"""A SOURCE read: contacts, what is known of their noise, and the free space and cost that go with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from primitives.arrays import Ints
from primitives.evidence import Contacts, FreeSpace
from recognition.running.evidence_log import Explored
from recognition.sources.noise import estimated_sigma


@dataclass(frozen=True)
class Felt:
    """What a recording cost; zero where nobody counted."""

    touches: int = 0
    strokes: int = 0
    frames: int = 0
    travel: float = 0.0  # [mm]
    seconds: float = 0.0  # [s] on the device's clock
    sensor: str | None = None


@dataclass(frozen=True)
class Source:
    """Evidence that exists."""

    path: Path
    kind: str  # "contacts", "run" or "episode"
    name: str  # of the part if anybody said it, else of the file
    contacts: Contacts  # where `measured_sigma` is false their sigma is only a placeholder
    measured_sigma: bool  # whether whoever felt them said how surely
    felt: Felt = Felt()
    warnings: tuple[str, ...] = ()
    sweep: Callable[[], FreeSpace] | None = None  # what pad and housing swept, where poses were recorded
    explored: Explored | None = None  # what an exploration made of these contacts

    @property
    def rows(self) -> Ints | None:
        """(n,) the row of each contact in a file that repeats some; None where it is the contact's own."""
        return self.contacts.touch if self.kind == "contacts" else None

    def with_sigma(self, sigma: float | None) -> Source:
        """With the contacts' sigma [mm] as given; None: as measured, else as the contacts' own scatter says."""
        if sigma is None and self.measured_sigma:
            return self
        said = estimated_sigma(self.contacts) if sigma is None else sigma
        c = self.contacts
        table = Contacts.of(
            c.points, c.normals, said, c.normal_sigma, c.touch, c.stroke, c.sensor, c.body
        )  # fmt: skip
        return replace(self, contacts=table, measured_sigma=True, explored=None)

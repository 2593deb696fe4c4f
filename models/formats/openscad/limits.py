"""How much work a file may ask for, and the one line that says where it asked for more."""

from __future__ import annotations

from dataclasses import dataclass, field

from primitives.errors import PalpateError


@dataclass(frozen=True)
class Limits:
    """Bounds on what evaluating one file may cost."""

    steps: int = 1_500_000  # operations on single values; some seconds
    calls: int = 400  # functions and modules within one another
    length: int = 100_000  # elements of a list, characters of a string, turns of a loop
    solids: int = 5_000  # shapes that the file draws
    depth: int = 150  # booleans and placements within one another
    files: int = 100  # files read through use and include


@dataclass
class Budget:
    """What is left of the limits; `place` is where evaluation is, as errors show it."""

    limits: Limits = field(default_factory=Limits)
    steps: int = 0
    calls: int = 0
    solids: int = 0
    files: int = 0
    place: str = ""

    def spend(self, steps: int = 1) -> None:
        """Account for work."""
        self.steps += steps
        if self.steps > self.limits.steps:
            raise self.error("the file computes too long (does a loop or a recursion end?); simplify it")

    def check_length(self, length: float, what: str) -> None:
        """Refuse a list, a string or a loop before it is made."""
        if not length <= self.limits.length:
            raise self.error(f"{what} has more than {self.limits.length} elements; make it shorter")

    def count_solid(self) -> None:
        """Account for one shape."""
        self.solids += 1
        if self.solids > self.limits.solids:
            raise self.error(
                f"the file draws more than {self.limits.solids} shapes; export it as a mesh (STL)"
            )

    def error(self, words: str) -> PalpateError:
        """An error that names the place."""
        return PalpateError(f"{self.place}: {words}" if self.place else words)

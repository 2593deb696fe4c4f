"""What a trial may be told and what it tells, each as one line of a table that checks, documents and sorts.

A setting has a type, a default and bounds; a metric a type, a unit and which way is better.  Both become columns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches

from primitives.errors import PalpateError

Value = str | int | float | bool | None
_WORDS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}


@dataclass(frozen=True)
class Setting:
    """One thing that a trial may be told."""

    type: type
    default: Value
    about: str
    least: float = -math.inf
    most: float = math.inf
    choices: tuple[str, ...] = ()

    def checked(self, value: object, where: str) -> Value:
        """The value as its type; what is wrong with it is said with what would be right."""
        if self.type is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, str | int | float | bool) or type(value) is not self.type:
            raise PalpateError(f"{where} must be {_WORDS[self.type]}, not {value!r}")
        if isinstance(value, str) and not value.isprintable():
            raise PalpateError(f"{where} must be one line of plain text, not {value!r}")
        if self.choices and value not in self.choices:
            raise PalpateError(f"{where} is {value!r}; it may be {', '.join(self.choices)}")
        if isinstance(value, int | float) and not self._within(value):
            raise PalpateError(f"{where} is {value}; it must be {self._bounds()}")
        return value

    def _within(self, value: float) -> bool:
        """Within the bounds, and a number that the table can hold."""
        return abs(value) < (math.inf if self.type is float else 2**63) and self.least <= value <= self.most

    def _bounds(self) -> str:
        if self.most == math.inf:
            return f"{self.least:g} or more, and finite"
        return f"between {self.least:g} and {self.most:g}"


@dataclass(frozen=True)
class Metric:
    """One thing that a trial tells."""

    type: type
    about: str
    better: str = ""  # "high", "low", or "" where neither is
    most: float = math.inf  # 1 for a share; no metric is below 0


def closest(key: str, valid: Mapping[str, object]) -> str:
    """How to go on after an unknown key."""
    near = get_close_matches(key, valid, n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    return f"{hint} (valid keys: {', '.join(valid)})"

"""OpenSCAD's values and what its operators do to them.

Numbers and booleans are Python's, vectors are tuples, `undef` is None.  An operator that has no meaning for its
operands gives undef, as in OpenSCAD.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeGuard

from models.formats.openscad.limits import Budget

Value = Any  # float | bool | str | tuple | Range | Closure | None


@dataclass(frozen=True)
class Range:
    """[first : step : last]."""

    first: float
    step: float
    last: float

    def __len__(self) -> int:
        count = (self.last - self.first) / self.step if self.step else math.inf
        if math.isnan(count):
            return 0
        return max(int(min(count * (1 + 1e-15) + 1e-12, 1e15)) + 1, 0) if count >= 0 else 0

    def __iter__(self) -> Iterator[float]:
        return (self.first + i * self.step for i in range(len(self)))


@dataclass(frozen=True, eq=False)
class Closure:
    """A function, with the scope that it was written in."""

    parameters: list[Any]
    body: Any
    scope: Any


def is_number(value: Value) -> TypeGuard[float]:
    """Whether it is a number; a boolean is none."""
    return isinstance(value, float)


def true(value: Value) -> bool:
    """Whether OpenSCAD takes the value for true."""
    return bool(value) if isinstance(value, bool | float | str | tuple) else value is not None


def text(value: Value, budget: Budget) -> str:
    """The value as `str` and `echo` write it."""
    budget.spend()
    match value:
        case None:
            return "undef"
        case bool():
            return "true" if value else "false"
        case float():
            shown = f"{value:.6g}"
            return "0" if shown == "-0" else shown.replace("e+0", "e+").replace("e-0", "e-")
        case tuple():
            pieces, length = [], 0
            for x in value:
                pieces.append(f'"{x}"' if isinstance(x, str) else text(x, budget))
                length += len(pieces[-1])
                budget.check_length(length, "a string")
            return "[" + ", ".join(pieces) + "]"
        case Range():
            return f"[{value.first:g} : {value.step:g} : {value.last:g}]"
        case str():
            return value
    return "function"


def add(a: Value, b: Value, budget: Budget) -> Value:
    """Numbers, or vectors element by element."""
    return _paired(a, b, budget, lambda x, y: x + y)


def subtract(a: Value, b: Value, budget: Budget) -> Value:
    """Numbers, or vectors element by element."""
    return _paired(a, b, budget, lambda x, y: x - y)


def negated(a: Value, budget: Budget) -> Value:
    """A number, or a vector."""
    return scaled(a, -1.0, budget)


def scaled(a: Value, factor: float, budget: Budget) -> Value:
    """A number or a nested vector times a number."""
    budget.spend()
    if isinstance(a, tuple):
        return tuple([scaled(x, factor, budget) for x in a])
    return a * factor if is_number(a) else None


def multiply(a: Value, b: Value, budget: Budget) -> Value:
    """Numbers, number and vector, dot product, or matrix products."""
    if is_number(a) and is_number(b):
        return a * b
    if is_number(a) or is_number(b):
        vector, factor = (b, a) if is_number(a) else (a, b)
        return scaled(vector, factor, budget) if isinstance(vector, tuple) else None
    if not (isinstance(a, tuple) and isinstance(b, tuple) and a and b):
        return None
    if all(map(is_number, a)):
        if all(map(is_number, b)):
            return _dot(a, b, budget)
        columns = _columns(b)
        return tuple([_dot(a, c, budget) for c in columns]) if columns and len(a) == len(b) else None
    rows = [r for r in a if isinstance(r, tuple)]
    if len(rows) != len(a):
        return None
    if all(map(is_number, b)):
        return tuple([_dot(r, b, budget) for r in rows])
    columns = _columns(b)
    return tuple([tuple([_dot(r, c, budget) for c in columns]) for r in rows]) if columns else None


def divide(a: Value, b: Value, budget: Budget) -> Value:
    """A number or vector by a number, or a number by each element of a vector."""
    if is_number(a) and is_number(b):
        return _quotient(a, b)
    if isinstance(a, tuple) and is_number(b):
        budget.spend(len(a))
        return tuple([divide(x, b, budget) for x in a])
    if is_number(a) and isinstance(b, tuple):
        budget.spend(len(b))
        return tuple([divide(a, x, budget) for x in b])
    return None


def modulo(a: Value, b: Value, budget: Budget) -> Value:
    """The remainder, with the sign of the first."""
    if not (is_number(a) and is_number(b)):
        return None
    return math.fmod(a, b) if b and math.isfinite(a) else math.nan


def power(a: Value, b: Value, budget: Budget) -> Value:
    """A number to a number."""
    if not (is_number(a) and is_number(b)):
        return None
    try:
        return math.pow(a, b)
    except OverflowError:
        return math.inf
    except ValueError:
        return math.nan


def equal(a: Value, b: Value, budget: Budget) -> bool:
    """Of the same kind, and the same all through."""
    budget.spend()
    if isinstance(a, tuple) and isinstance(b, tuple):
        same = [equal(x, y, budget) for x, y in zip(a, b, strict=True)] if len(a) == len(b) else [False]
        return False not in same
    return type(a) is type(b) and bool(a == b)


def less(a: Value, b: Value) -> Value:
    """Of two numbers, two strings or two booleans."""
    comparable = type(a) is type(b) and isinstance(a, float | str | bool)
    return bool(a < b) if comparable else None


def element(value: Value, index: Value, budget: Budget) -> Value:
    """One element, counted from zero; undef outside."""
    if not (isinstance(value, tuple | str) and is_number(index) and math.isfinite(index)):
        return None
    place = math.floor(index)
    return value[place] if 0 <= place < len(value) else None


def _paired(a: Value, b: Value, budget: Budget, operator: Callable[[float, float], float]) -> Value:
    budget.spend()
    if is_number(a) and is_number(b):
        return operator(a, b)
    if isinstance(a, tuple) and isinstance(b, tuple):
        shorter = min(len(a), len(b))
        return tuple([_paired(a[i], b[i], budget, operator) for i in range(shorter)])
    return None


def _quotient(a: float, b: float) -> float:
    if b:
        return a / b
    return math.nan if a == 0 or math.isnan(a) else math.copysign(math.inf, a) * math.copysign(1, b)


def _dot(a: tuple[Value, ...], b: tuple[Value, ...], budget: Budget) -> Value:
    budget.spend(len(a))
    if len(a) != len(b) or not (all(map(is_number, a)) and all(map(is_number, b))):
        return None
    return sum(map(lambda x, y: x * y, a, b), 0.0)


def _columns(matrix: tuple[Value, ...]) -> list[tuple[Value, ...]]:
    if not all(isinstance(row, tuple) and len(row) == len(matrix[0]) for row in matrix):
        return []
    return list(zip(*matrix, strict=True))

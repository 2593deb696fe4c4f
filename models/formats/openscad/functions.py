"""OpenSCAD's own functions: degrees in, degrees out, exact at the multiples of 30 and 45 that people use."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from models.formats.openscad.limits import Budget
from models.formats.openscad.values import Closure, Value, is_number, power, text

Function = Callable[[Sequence[Value], Budget], Value]


def sine(degrees: float) -> float:
    """Of an angle in degrees; exact where the result is a half, one or nothing."""
    if not math.isfinite(degrees):
        return math.nan
    turn = math.fmod(degrees, 360.0)
    exact = {0.0: 0.0, 30.0: 0.5, 90.0: 1.0, 150.0: 0.5, 180.0: 0.0, 210.0: -0.5, 270.0: -1.0, 330.0: -0.5}
    turn = turn + 360.0 if turn < 0 else turn
    return exact[turn] if turn in exact else math.sin(math.radians(turn))


def cosine(degrees: float) -> float:
    """Of an angle in degrees."""
    return sine(degrees + 90.0)


def _tangent(degrees: float) -> float:
    below = cosine(degrees)
    return sine(degrees) / below if below else math.copysign(math.inf, sine(degrees))


def _root(x: float) -> float:
    return math.sqrt(x) if x >= 0 else math.nan


def _logarithm(base: float | None) -> Callable[[float], float]:
    def of(x: float) -> float:
        if x <= 0:
            return -math.inf if x == 0 else math.nan
        return math.log(x) if base is None else math.log10(x)

    return of


def _nearest(x: float) -> float:
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _arc(function: Callable[[float], float]) -> Callable[[float], float]:
    def of(x: float) -> float:
        return round(math.degrees(function(x)), 13)

    return of


_OF_ONE: dict[str, Callable[[float], float]] = {
    "abs": abs,
    "sign": lambda x: float((x > 0) - (x < 0)),
    "sin": sine,
    "cos": cosine,
    "tan": _tangent,
    "asin": _arc(math.asin),
    "acos": _arc(math.acos),
    "atan": _arc(math.atan),
    "floor": lambda x: float(math.floor(x)),
    "ceil": lambda x: float(math.ceil(x)),
    "round": _nearest,
    "sqrt": _root,
    "exp": math.exp,
    "ln": _logarithm(None),
    "log": _logarithm(10.0),
}


def _numeric(function: Callable[[float], float]) -> Function:
    def call(values: Sequence[Value], budget: Budget) -> Value:
        if len(values) != 1 or not is_number(values[0]):
            return None
        try:
            return float(function(values[0]))
        except (ValueError, OverflowError):
            return math.nan

    return call


def _atan2(values: Sequence[Value], budget: Budget) -> Value:
    if len(values) != 2 or not all(map(is_number, values)):
        return None
    return round(math.degrees(math.atan2(*values)), 13)


def _power(values: Sequence[Value], budget: Budget) -> Value:
    return power(values[0], values[1], budget) if len(values) == 2 else None


def _extreme(choose: Callable[..., float]) -> Function:
    def call(values: Sequence[Value], budget: Budget) -> Value:
        given = values[0] if len(values) == 1 and isinstance(values[0], tuple) else values
        budget.spend(len(given))
        return choose(given) if given and all(map(is_number, given)) else None

    return call


def _length(values: Sequence[Value], budget: Budget) -> Value:
    return float(len(values[0])) if len(values) == 1 and isinstance(values[0], tuple | str) else None


def _concat(values: Sequence[Value], budget: Budget) -> Value:
    joined: list[Value] = []
    for value in values:
        joined += value if isinstance(value, tuple) else [value]
        budget.check_length(len(joined), "a list")
    budget.spend(len(joined))
    return tuple(joined)


def _str(values: Sequence[Value], budget: Budget) -> Value:
    pieces, length = [], 0
    for value in values:
        pieces.append(text(value, budget))
        length += len(pieces[-1])
        budget.check_length(length, "a string")
    budget.spend(length // 16)
    return "".join(pieces)


def _chr(values: Sequence[Value], budget: Budget) -> Value:
    codes = values[0] if values and isinstance(values[0], tuple) else values[:1]
    budget.spend(len(codes))
    return "".join(chr(int(code)) for code in codes if is_number(code) and 0 < code < 0xD800)


def _ord(values: Sequence[Value], budget: Budget) -> Value:
    return float(ord(values[0][0])) if values and isinstance(values[0], str) and values[0] else None


def _norm(values: Sequence[Value], budget: Budget) -> Value:
    if len(values) != 1 or not isinstance(values[0], tuple) or not all(map(is_number, values[0])):
        return None
    budget.spend(len(values[0]))
    return math.hypot(*values[0])


def _cross(values: Sequence[Value], budget: Budget) -> Value:
    if len(values) != 2 or not all(isinstance(v, tuple) and all(map(is_number, v)) for v in values):
        return None
    a, b = values
    if len(a) == len(b) == 2:
        return a[0] * b[1] - a[1] * b[0]
    if len(a) == len(b) == 3:
        return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return None


def _lookup(values: Sequence[Value], budget: Budget) -> Value:
    if len(values) != 2 or not is_number(values[0]) or not isinstance(values[1], tuple):
        return None
    x, table = values[0], [p for p in values[1] if isinstance(p, tuple) and len(p) == 2]
    budget.spend(len(table))
    if not table or not all(is_number(k) and is_number(v) for k, v in table):
        return None
    below = max((p for p in table if p[0] <= x), default=min(table))
    above = min((p for p in table if p[0] >= x), default=max(table))
    if above[0] <= below[0]:
        return below[1]
    share = (x - below[0]) / (above[0] - below[0])
    return below[1] + share * (above[1] - below[1])


def _kind(test: Callable[[Value], bool]) -> Function:
    def call(values: Sequence[Value], budget: Budget) -> Value:
        return len(values) == 1 and test(values[0])

    return call


FUNCTIONS: dict[str, Function] = {
    **{name: _numeric(function) for name, function in _OF_ONE.items()},
    "atan2": _atan2,
    "pow": _power,
    "min": _extreme(min),
    "max": _extreme(max),
    "len": _length,
    "concat": _concat,
    "str": _str,
    "chr": _chr,
    "ord": _ord,
    "norm": _norm,
    "cross": _cross,
    "lookup": _lookup,
    "is_undef": _kind(lambda v: v is None),
    "is_num": _kind(lambda v: is_number(v) and not math.isnan(v)),
    "is_bool": _kind(lambda v: isinstance(v, bool)),
    "is_string": _kind(lambda v: isinstance(v, str)),
    "is_list": _kind(lambda v: isinstance(v, tuple)),
    "is_function": _kind(lambda v: isinstance(v, Closure)),
    "version_num": lambda values, budget: 20210100.0,
    "version": lambda values, budget: (2021.0, 1.0),
}

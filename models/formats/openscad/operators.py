"""What OpenSCAD's literals and its operators of two values are worth, by kind of syntax node."""

from collections.abc import Callable
from typing import Any

import openscad_lalr_parser as syntax

from models.formats.openscad import values
from models.formats.openscad.limits import Budget
from models.formats.openscad.values import Value


def _not_less(a: Value, b: Value) -> Value:
    answer = values.less(a, b)
    return None if answer is None else not answer and a == a and b == b


def _unescaped(raw: str) -> str:
    return raw.replace('\\"', '"').replace("\\n", "\n").replace("\\t", "\t").replace("\\\\", "\\")


LITERALS: dict[type, Callable[[Any], Value]] = {
    syntax.NumberLiteral: lambda node: float(node.val),
    syntax.StringLiteral: lambda node: _unescaped(node.val),
    syntax.BooleanLiteral: lambda node: bool(node.val),
    syntax.UndefinedLiteral: lambda node: None,
}
BINARY: dict[type, Callable[[Value, Value, Budget], Value]] = {
    syntax.AdditionOp: values.add,
    syntax.SubtractionOp: values.subtract,
    syntax.MultiplicationOp: values.multiply,
    syntax.DivisionOp: values.divide,
    syntax.ModuloOp: values.modulo,
    syntax.ExponentOp: values.power,
    syntax.EqualityOp: values.equal,
    syntax.InequalityOp: lambda a, b, budget: not values.equal(a, b, budget),
    syntax.LessThanOp: lambda a, b, budget: values.less(a, b),
    syntax.GreaterThanOp: lambda a, b, budget: values.less(b, a),
    syntax.LessThanOrEqualOp: lambda a, b, budget: _not_less(b, a),
    syntax.GreaterThanOrEqualOp: lambda a, b, budget: _not_less(a, b),
}

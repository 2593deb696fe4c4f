"""What an OpenSCAD expression is worth in a scope.

Functions may end in a call of themselves through `?:`, `let`, `assert` and `echo`: such a call replaces the one
that made it, so that a loop written as a recursion costs no depth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

import openscad_lalr_parser as syntax

from models.formats.openscad import values
from models.formats.openscad.comprehension import listed
from models.formats.openscad.functions import FUNCTIONS
from models.formats.openscad.limits import Budget
from models.formats.openscad.operators import BINARY, LITERALS
from models.formats.openscad.scope import Scope
from models.formats.openscad.values import Closure, Range, Value, is_number, true

_TAIL = (syntax.TernaryOp, syntax.LetOp, syntax.AssertOp, syntax.EchoOp)
_MEMBERS = {"x": 0, "y": 1, "z": 2}


class Evaluator:
    """Expressions of one file set, all on one budget."""

    def __init__(self, budget: Budget) -> None:
        self.budget = budget

    def value(self, node: Any, scope: Scope) -> Value:
        """What an expression is worth."""
        self.budget.spend()
        while isinstance(node, _TAIL):
            node, scope = self._step(node, scope)
        kind = type(node)
        if kind in LITERALS:
            return LITERALS[kind](node)
        if kind is syntax.Identifier:
            return self.named(node, scope)
        if kind in BINARY:
            left = self.value(node.left, scope)
            return BINARY[kind](left, self.value(node.right, scope), self.budget)
        if (method := _METHODS.get(kind)) is not None:
            return method(self, node, scope)
        raise self.error(node, f"no {_words(kind)} in this subset; write it another way")

    def error(self, node: Any, words: str) -> Exception:
        """An error that names the node's line."""
        self.at(node)
        return self.budget.error(words)

    def at(self, node: Any) -> None:
        """Remember where evaluation is."""
        self.budget.place = f"{node.position.origin}, line {node.position.line}"

    def named(self, node: Any, scope: Scope) -> Value:
        """What a name stands for."""
        known, value = scope.variable(node.name)
        if known:
            return value
        if (function := scope.function(node.name)) is not None:
            return function
        if node.name == "PI":
            return math.pi
        raise self.error(node, f"nothing is called {node.name}; define it, or check its spelling")

    def bind(self, assignments: Iterable[Any], scope: Scope) -> Scope:
        """A scope in which `let`'s names hold, each seeing those before it."""
        inner = scope.inner()
        for assignment in assignments:
            inner.variables[assignment.name.name] = self.value(assignment.expr, inner)
        return inner

    def arguments(self, given: list[Any], scope: Scope) -> tuple[list[Value], dict[str, Value]]:
        """Positional and named arguments."""
        placed: list[Value] = []
        named: dict[str, Value] = {}
        for argument in given:
            value = self.value(argument.expr, scope)
            if isinstance(argument, syntax.NamedArgument):
                named[argument.name.name] = value
            else:
                placed.append(value)
        return placed, named

    def enter(self, closure: Closure, given: list[Any], scope: Scope, caller: Scope | None = None) -> Scope:
        """The scope inside a call of a function or module."""
        placed, named = self.arguments(given, scope)
        inner = Scope(closure.scope, caller or scope)
        for number, parameter in enumerate(closure.parameters):
            name = parameter.name.name
            if number < len(placed):
                inner.variables[name] = placed[number]
            elif name not in named:
                default = parameter.default
                inner.variables[name] = None if default is None else self.value(default, closure.scope)
        inner.variables.update(named)
        return inner

    def each(self, value: Value, node: Any) -> Iterable[Value]:
        """The elements that a loop runs over."""
        if isinstance(value, Range | tuple | str):
            self.at(node)
            self.budget.check_length(len(value), "a loop")
            return value
        return () if value is None else (value,)

    def loops(self, assignments: list[Any], scope: Scope, place: int = 0) -> Iterable[Scope]:
        """A scope for every turn of a loop over one variable or more."""
        if place == len(assignments):
            yield scope
            return
        assignment = assignments[place]
        for value in self.each(self.value(assignment.expr, scope), assignment):
            self.budget.spend()
            inner = scope.inner()
            inner.variables[assignment.name.name] = value
            yield from self.loops(assignments, inner, place + 1)

    def check(self, node: Any, scope: Scope) -> None:
        """Hold an `assert`."""
        placed, named = self.arguments(node.arguments, scope)
        condition = placed[0] if placed else named.get("condition")
        if not true(condition):
            words = (
                values.text((*placed, named.get("message"))[1], self.budget)
                if len(placed) + len(named) > 1
                else ""
            )
            raise self.error(node, f"the file's own assertion fails{': ' if words else ''}{_one_line(words)}")

    def _step(self, node: Any, scope: Scope) -> tuple[Any, Scope]:
        """One step into an expression whose last part is its value."""
        self.budget.spend()
        if isinstance(node, syntax.TernaryOp):
            return (node.true_expr if true(self.value(node.condition, scope)) else node.false_expr), scope
        if isinstance(node, syntax.LetOp):
            return node.body, self.bind(node.assignments, scope)
        if isinstance(node, syntax.AssertOp):
            self.check(node, scope)
        return node.body or syntax.UndefinedLiteral(position=node.position), scope

    def _call(self, node: Any, scope: Scope) -> Value:
        budget, caller = self.budget, scope
        budget.calls += 1
        try:
            while True:
                self.at(node)
                budget.spend()
                if budget.calls > budget.limits.calls:
                    raise self.error(
                        node, f"calls go more than {budget.limits.calls} deep; end the recursion"
                    )
                closure = self._function(node, scope)
                if closure is None:
                    if node.left.name == "is_undef" and self._unknown(node.arguments, scope):
                        return True
                    placed, named = self.arguments(node.arguments, scope)
                    self.at(node)
                    return FUNCTIONS[node.left.name]((*placed, *named.values()), budget)
                body, scope = closure.body, self.enter(closure, node.arguments, scope, caller)
                while isinstance(body, _TAIL):
                    body, scope = self._step(body, scope)
                if not isinstance(body, syntax.PrimaryCall):
                    return self.value(body, scope)
                node = body
        finally:
            budget.calls -= 1

    def _function(self, node: Any, scope: Scope) -> Closure | None:
        """What is called; None for one of OpenSCAD's own functions."""
        if isinstance(node.left, syntax.Identifier):
            name = node.left.name
            known, value = scope.variable(name)
            if known and isinstance(value, Closure):
                return value
            if (function := scope.function(name)) is not None:
                return function
            if name in FUNCTIONS:
                return None
            raise self.error(node, f"no function {name} in this subset; define it, or write the value")
        value = self.value(node.left, scope)
        if not isinstance(value, Closure):
            raise self.error(node, "what is called here is no function; check the brackets")
        return value

    def _unknown(self, given: list[Any], scope: Scope) -> bool:
        """Whether the one argument is a name that stands for nothing."""
        name = given[0].expr if len(given) == 1 else None
        return isinstance(name, syntax.Identifier) and not (
            scope.variable(name.name)[0] or scope.function(name.name) or name.name == "PI"
        )

    def _index(self, node: Any, scope: Scope) -> Value:
        return values.element(self.value(node.left, scope), self.value(node.index, scope), self.budget)

    def _member(self, node: Any, scope: Scope) -> Value:
        place = _MEMBERS.get(node.member.name)
        if place is None:
            raise self.error(node, f"no member .{node.member.name}; use .x, .y, .z or an index")
        return values.element(self.value(node.left, scope), float(place), self.budget)

    def _range(self, node: Any, scope: Scope) -> Value:
        first, last = self.value(node.start, scope), self.value(node.end, scope)
        step = 1.0 if node.implicit_step else self.value(node.step, scope)
        if not (is_number(first) and is_number(step) and is_number(last)):
            return None
        backward = node.implicit_step and last < first  # OpenSCAD turns such a range over
        return Range(last, step, first) if backward else Range(first, step, last)


def _one_line(words: str) -> str:
    return " ".join(words.split())[:120]


def _words(kind: type) -> str:
    names = {"FunctionLiteral": "function literal", "RenderExpression": "render() as a value"}
    return names.get(kind.__name__, f"{kind.__name__} expression")


_METHODS: dict[type, Callable[[Evaluator, Any, Scope], Value]] = {
    syntax.UnaryMinusOp: lambda self, node, scope: values.negated(self.value(node.expr, scope), self.budget),
    syntax.LogicalNotOp: lambda self, node, scope: not true(self.value(node.expr, scope)),
    syntax.LogicalAndOp: lambda self, node, scope: (
        true(self.value(node.left, scope)) and true(self.value(node.right, scope))
    ),
    syntax.LogicalOrOp: lambda self, node, scope: (
        true(self.value(node.left, scope)) or true(self.value(node.right, scope))
    ),
    syntax.FunctionLiteral: lambda self, node, scope: Closure(node.parameters, node.body, scope),
    syntax.ListComprehension: listed,
    syntax.RangeLiteral: Evaluator._range,
    syntax.PrimaryCall: Evaluator._call,
    syntax.PrimaryIndex: Evaluator._index,
    syntax.PrimaryMember: Evaluator._member,
}

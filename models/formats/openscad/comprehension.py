"""List comprehensions: what the elements of a vector stand for."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Protocol

import openscad_lalr_parser as syntax

from models.formats.openscad.limits import Budget
from models.formats.openscad.scope import Scope
from models.formats.openscad.values import Value, true


class Evaluates(Protocol):
    """What comprehensions need of expressions."""

    budget: Budget

    def value(self, node: Any, scope: Scope) -> Value:
        """What an expression is worth."""

    def bind(self, assignments: Iterable[Any], scope: Scope) -> Scope:
        """A scope in which names hold."""

    def loops(self, assignments: list[Any], scope: Scope) -> Iterable[Scope]:
        """A scope for every turn of a loop."""

    def each(self, value: Value, node: Any) -> Iterable[Value]:
        """The elements of a value."""

    def at(self, node: Any) -> None:
        """Remember where evaluation is."""


def listed(evaluate: Evaluates, node: Any, scope: Scope) -> tuple[Value, ...]:
    """The vector that brackets stand for."""
    out: list[Value] = []
    for element in node.elements:
        _collect(evaluate, element, scope, out)
    return tuple(out)


def _collect(evaluate: Evaluates, node: Any, scope: Scope, out: list[Value]) -> None:
    """Add what one element of a list stands for."""
    evaluate.budget.spend()
    evaluate.budget.check_length(len(out), "a list")
    match node:
        case syntax.ListCompFor():
            for inner in evaluate.loops(node.assignments, scope):
                _collect(evaluate, node.body, inner, out)
        case syntax.ListCompIf():
            if true(evaluate.value(node.condition, scope)):
                _collect(evaluate, node.true_expr, scope, out)
        case syntax.ListCompIfElse():
            holds = true(evaluate.value(node.condition, scope))
            _collect(evaluate, node.true_expr if holds else node.false_expr, scope, out)
        case syntax.ListCompLet():
            _collect(evaluate, node.body, evaluate.bind(node.assignments, scope), out)
        case syntax.ListCompEach():
            found: list[Value] = []
            _collect(evaluate, node.body, scope, found)
            for value in found:
                out.extend(evaluate.each(value, node))
        case syntax.ListCompCFor():
            _count(evaluate, node, scope, out)
        case _:
            out.append(evaluate.value(node, scope))


def _count(evaluate: Evaluates, node: Any, scope: Scope, out: list[Value]) -> None:
    """A loop with a start, a condition and steps, each of which sees those before it."""
    inner = evaluate.bind(node.inits, scope)
    while true(evaluate.value(node.condition, inner)):
        evaluate.at(node)
        _collect(evaluate, node.body, inner, out)
        after = Scope(inner.outer, inner.caller, dict(inner.variables))
        for assignment in node.incrs:
            after.variables[assignment.name.name] = evaluate.value(assignment.expr, after)
        inner = after

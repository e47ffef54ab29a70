"""The stack machine gives what the compiled Python function of a condition gives."""

from __future__ import annotations

from math import inf, isnan, nan
from random import Random

import pytest

from pirate_sm.core._expressions.compiler import Code, code_of, depth_of, never_true, words_in
from pirate_sm.core._expressions.machine import DEEPEST, value_of
from pirate_sm.core.expressions import BOOLEAN, Expression, tree

VALUES = (nan, nan, 0.0, -0.0, 1.0, -1.0, 0.1, 0.30000000000000004, 3.0, -2.5, inf, 1e-300)
CONSTANTS = [value for value in VALUES if abs(value) < inf]
WORDS = ("close", "in", "past")
COUNT = 4


def number(lot: Random, depth: int) -> tree.Node:
    kind = lot.randrange(6) if depth else lot.randrange(2)
    if kind == 0:
        return tree.Number(lot.choice(CONSTANTS))
    if kind == 1:
        return tree.Signal("n", "number", lot.randrange(2 * COUNT))
    if kind == 2:
        return tree.Negate(number(lot, depth - 1))
    if kind == 3:
        some = tuple(number(lot, depth - 1) for _ in range(lot.randint(1, 3)))
        return tree.Call(lot.choice(("min", "max")), some)
    if kind == 4:
        return tree.Call("abs", (number(lot, depth - 1),))
    sides = number(lot, depth - 1), number(lot, depth - 1)
    return tree.Arithmetic(lot.choice(("+", "-", "*", "/")), *sides)


def condition(lot: Random, depth: int) -> tree.Node:
    kind = lot.randrange(7) if depth else lot.randrange(4)
    if kind == 0:
        return tree.TruthValue(lot.random() < 0.5)
    if kind == 1:
        operator = lot.choice(("==", "!=", "<", "<=", ">", ">="))
        return tree.Compare(operator, number(lot, depth), number(lot, depth))
    if kind == 2:
        some = tuple(lot.sample(WORDS, lot.randint(1, 2)))
        return tree.Matches(tree.Signal("w", "word", lot.randrange(2)), some)
    if kind == 3:
        signal = tree.Signal("w", "word", lot.randrange(2))
        return tree.Known(signal if lot.random() < 0.3 else number(lot, depth))
    if kind == 4:
        return tree.Not(condition(lot, depth - 1))
    parts = tuple(condition(lot, depth - 1) for _ in range(lot.randint(2, 3)))
    return tree.And(parts) if kind == 5 else tree.Or(parts)


def run(code: Code, numbers: list[float], origin: list[float]) -> bool | None:
    value = value_of(code, 0, len(code), numbers, origin, [nan] * DEEPEST)
    return None if isnan(value) else value == 1.0


@pytest.mark.parametrize("seed", range(4))
def test_conditions_have_the_same_value_in_both(seed: int) -> None:
    lot = Random(seed)
    values = set()
    for _ in range(500):
        node = condition(lot, 3)
        numbers, origin = lot.choices(VALUES, k=COUNT), lot.choices(VALUES, k=COUNT)
        words = tuple(lot.choice((None, *WORDS)) for _ in range(2))
        changes = [now - then for now, then in zip(numbers, origin, strict=True)]
        expected = Expression("", BOOLEAN, node).evaluate((*numbers, *changes), words)
        code = code_of(node, words)
        assert depth_of(code) <= DEEPEST
        assert run(code, numbers, origin) == expected, node
        assert not (never_true(code) and expected is True)
        values.add(expected)

    assert values == {True, False, None}


def test_what_words_decide_leaves_no_code() -> None:
    word = tree.Matches(tree.Signal("w", "word", 0), ("close",))
    fast = tree.Compare(">", tree.Signal("n", "number", 0), tree.Number(1.0))
    both = tree.And((word, fast))

    assert never_true(code_of(both, ("past",)))
    assert code_of(both, ("close",)) == code_of(fast)
    assert words_in(both) == (0,)

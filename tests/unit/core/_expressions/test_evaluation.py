"""What expressions mean: by example, and against a slow reference interpreter."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._expressions import (
    BOOLEAN,
    EnumType,
    Expression,
    NumberType,
    Vocabulary,
    compile_condition,
    compile_expression,
    tree,
)
from pirate_sm.core.units import ANGLE, DIMENSIONLESS, LENGTH, SPEED, TIME, Quantity

NAN = math.nan
VOCABULARY = Vocabulary(
    {
        "bend": NumberType(ANGLE),
        "eye": EnumType(("close", "in", "past")),
        "path": NumberType(LENGTH),
        "speed": NumberType(SPEED),
        "load": NumberType(DIMENSIONLESS),
        "Lamp": EnumType(("Off", "On")),
        "Nose": EnumType(("Free", "Held", "Off")),
        "Tail": EnumType(("Held", "Free")),
    }
)
PARAMETERS = {
    "far": Quantity(2.0, LENGTH),
    "back": Quantity(-1.0, LENGTH),
    "sign": "past",
    "always": True,
}


def value(text: str, numbers: Sequence[float] = (), words: Sequence[str | None] = ()) -> object:
    """The value of an expression; signals not given are unknown."""
    known = (*numbers, *[NAN] * 4)[:4]
    said = (*words, *[None] * 4)[:4]
    return compile_expression(text, VOCABULARY, PARAMETERS).evaluate(known, said)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("eye == close", True),
        ("close == eye", True),
        ("eye != close", False),
        ("eye == in", False),
        ("eye in (in, past)", False),
        ("eye not in (in, past)", True),
        ("eye == $sign", False),
        ("Lamp == Off", True),
        ("Nose == Tail", False),
        ("Nose != Tail", True),
        ("bend > 28 deg", True),
        ("bend > 28 deg and path < 1 m", False),
        ("1 m < path < 2 m", True),
        ("1 m < path < 1.2 m", False),
        ("2 m > path > 1 m", True),
        ("abs(-path) == path", True),
        ("-path <= -1.5 m", True),
        ("max(path, $far, 3 cm) == $far", True),
        ("min(path, $far, 3 cm) == 30 mm", True),
        ("$back < path", True),
        ("path / speed >= 3 s", True),
        ("speed / 2 m/s < 1", True),
        ("path * 50 % < 1 m", True),
        ("path - 1 m - 0.25 m == 0.25 m", True),
        ("8 / 4 / 2 == 1", True),
        ("1 + 2 * 3 == 7", True),
        ("(1 + 2) * 3 == 9", True),
        ("not eye == in and not false", True),
        ("true or false and false", True),
        ("$always and load == 0", True),
        ("known(path) and known(eye) and known(bend > 1 deg)", True),
        ("load / 2", 0.0),
        ("path", 1.5),
    ],
)
def test_an_expression_has_the_value_that_it_reads_as(text: str, expected: object) -> None:
    result = value(text, (0.5, 1.5, 0.5, 0.0), ("close", "Off", "Held", "Free"))

    assert result == expected
    assert type(result) is type(expected)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("bend > 1 deg", None),
        ("bend != bend", None),
        ("eye == close", None),
        ("eye != close", None),
        ("eye in (close, past)", None),
        ("not eye == close", None),
        ("Nose == Tail", None),
        ("eye == close and false", False),
        ("false and eye == close", False),
        ("eye == close and true", None),
        ("eye == close or true", True),
        ("eye == close or false", None),
        ("bend > 1 deg and eye == close", None),
        ("1 deg < 0 deg < bend", False),
        ("known(bend)", False),
        ("known(eye)", False),
        ("known(bend > 1 deg)", False),
        ("known(bend) or known(1)", True),
        ("min(1, load) < 2", None),
        ("max(load, 1) > 0", None),
        ("abs(bend) >= 0 deg", None),
        ("1 / 0 > 1", None),
        ("load / load", None),
        ("bend", None),
    ],
)
def test_what_hangs_on_an_unknown_signal_is_unknown(text: str, expected: object) -> None:
    assert value(text) is expected


def test_an_expression_knows_its_signals_and_its_type() -> None:
    condition = compile_condition("eye == in or path > $far", VOCABULARY, PARAMETERS)
    length = compile_expression("path * 2", VOCABULARY)

    assert condition.names == {"eye", "path"}
    assert condition.type == BOOLEAN
    assert length.type == NumberType(LENGTH)
    assert compile_expression("path / speed", VOCABULARY).type == NumberType(TIME)


def test_equal_meaning_gives_equal_and_hashable_trees() -> None:
    one = compile_expression("path > 1 m and Lamp != Off", VOCABULARY)
    other = compile_expression("(path>1000mm)  and not (Lamp==Off)", VOCABULARY)

    assert one.tree == other.tree
    assert len({one.tree, other.tree}) == 1


def test_an_expression_survives_pickling() -> None:
    before = compile_expression("eye == in and path > 1 m", VOCABULARY)
    after = pickle.loads(pickle.dumps(before))

    assert after == before
    assert after.evaluate((0.0, 2.0, 0.0, 0.0), ("in", None, None, None)) is True


def test_an_expression_of_the_longest_length_compiles() -> None:
    joined = compile_condition(" or ".join(["eye == in"] * 70), VOCABULARY)

    assert joined.evaluate((), ("in",)) is True


# A slow interpreter, written from the rules and not from the compiler.


def interpret(node: tree.Node, numbers: Sequence[float], words: Sequence[str | None]) -> object:
    """The value of a tree; None is unknown for numbers too."""
    if isinstance(node, tree.Number | tree.TruthValue):
        return node.value
    if isinstance(node, tree.Signal):
        value = numbers[node.index] if node.kind == "number" else words[node.index]
        return none_for_nan(value)
    below = [interpret(child, numbers, words) for child in tree.children(node)]
    return logical(node, below) if isinstance(node, LOGICAL) else numeric(node, below)


LOGICAL = (tree.And, tree.Or, tree.Not, tree.Known)


def logical(node: tree.Node, below: list[object]) -> object:
    match node:
        case tree.And():
            return kleene_and(below)
        case tree.Or():
            return kleene_not(kleene_and([kleene_not(value) for value in below]))
        case tree.Not():
            return kleene_not(below[0])
        case _:
            return below[0] is not None


def numeric(node: tree.Node, below: list[object]) -> object:
    """The value of a node that is unknown as soon as anything below it is."""
    if None in below:
        return None
    match node:
        case tree.Matches(_, accepted):
            result: object = below[0] in accepted
        case tree.Call(function, _):
            result = FUNCTIONS[function](*below)
        case tree.Negate():
            result = 0.0 - below[0]  # type: ignore[operator]
        case tree.Arithmetic(operator) | tree.Compare(operator):
            result = OPERATORS[operator](*below)
    return none_for_nan(result)


def none_for_nan(value: object) -> object:
    return None if isinstance(value, float) and math.isnan(value) else value


FUNCTIONS: dict[str, Callable[..., object]] = {
    "abs": abs,
    "min": lambda *values: sorted(values)[0],
    "max": lambda *values: sorted(values)[-1],
}
OPERATORS: dict[str, Callable[..., object]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b if b != 0.0 else None,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}


def kleene_and(values: list[object]) -> object:
    if False in values:
        return False
    return None if None in values else True


def kleene_not(truth: object) -> object:
    return None if truth is None else not truth


NUMBER_SIGNALS = [
    tree.Signal(name, "number", index) for index, name in enumerate(VOCABULARY.numbers)
]
WORD_SIGNALS = [tree.Signal(name, "word", index) for index, name in enumerate(VOCABULARY.words)]


def word_of(signal: tree.Signal) -> st.SearchStrategy[str]:
    kind = VOCABULARY.types[signal.name]
    assert isinstance(kind, EnumType)
    return st.sampled_from(kind.values)


NUMBERS: st.SearchStrategy[tree.Node] = st.recursive(
    st.one_of(
        st.floats(-1e3, 1e3).map(tree.Number),
        st.just(tree.Number(0.0)),
        st.sampled_from(NUMBER_SIGNALS),
    ),
    lambda inner: st.one_of(
        st.builds(tree.Negate, inner),
        st.builds(tree.Arithmetic, st.sampled_from("+-*/"), inner, inner),
        st.builds(lambda a: tree.Call("abs", (a,)), inner),
        st.builds(
            tree.Call,
            st.sampled_from(["min", "max"]),
            st.lists(inner, min_size=1, max_size=3).map(tuple),
        ),
    ),
    max_leaves=6,
)
MATCHES = st.sampled_from(WORD_SIGNALS).flatmap(
    lambda signal: st.lists(word_of(signal), min_size=1, max_size=3).map(
        lambda words: tree.Matches(signal, tuple(words))
    )
)
COMPARISONS = st.builds(
    tree.Compare, st.sampled_from(["==", "!=", "<", "<=", ">", ">="]), NUMBERS, NUMBERS
)
CONDITIONS: st.SearchStrategy[tree.Node] = st.recursive(
    st.one_of(
        st.booleans().map(tree.TruthValue),
        MATCHES,
        COMPARISONS,
        st.one_of(NUMBERS, st.sampled_from(WORD_SIGNALS)).map(tree.Known),
    ),
    lambda inner: st.one_of(
        st.builds(tree.Not, inner),
        st.builds(tree.Known, inner),
        st.builds(tree.And, st.lists(inner, min_size=1, max_size=4).map(tuple)),
        st.builds(tree.Or, st.lists(inner, min_size=1, max_size=4).map(tuple)),
    ),
    max_leaves=8,
)
READINGS = st.tuples(
    *[st.one_of(st.just(NAN), st.just(0.0), st.floats(-1e3, 1e3)) for _ in NUMBER_SIGNALS]
)
SAYINGS = st.tuples(*[st.one_of(st.none(), word_of(signal)) for signal in WORD_SIGNALS])


@given(CONDITIONS, READINGS, SAYINGS)
def test_conditions_agree_with_the_reference(
    node: tree.Node, numbers: tuple[float, ...], words: tuple[str | None, ...]
) -> None:
    compiled = Expression("", BOOLEAN, node)

    assert compiled.evaluate(numbers, words) is interpret(node, numbers, words)


@given(NUMBERS, READINGS)
def test_numbers_agree_with_the_reference(node: tree.Node, numbers: tuple[float, ...]) -> None:
    compiled = Expression("", NumberType(DIMENSIONLESS), node)

    assert compiled.evaluate(numbers, ()) == interpret(node, numbers, ())

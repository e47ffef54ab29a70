"""Conditions over three numbers, two words and the state of a region, made by hypothesis."""

from __future__ import annotations

import math
from itertools import product
from random import Random
from typing import Any

from hypothesis import strategies as st

from pirate_sm.checking.exploring.conditions import Conditions, Fact
from pirate_sm.checking.exploring.signal_ranges import Range
from pirate_sm.core.expressions import EnumType, NumberType, Vocabulary, compile_condition
from pirate_sm.core.units import DIMENSIONLESS

VOCABULARY = Vocabulary(
    {
        "Arm": EnumType(("Up", "Down")),
        "a": NumberType(DIMENSIONLESS),
        "b": NumberType(DIMENSIONLESS),
        "c": NumberType(DIMENSIONLESS),
        "light": EnumType(("red", "green")),
        "sound": EnumType(("low", "high")),
    }
)
SPANS = {"a": Range(0.0, 2.0), "b": Range(-1.0, 1.0)}
STATES = (("Up", None, None), ("Down", None, None))

_SIGNAL = st.sampled_from(["a", "a", "a", "b", "c"])
_NUMBER = st.sampled_from(["0", "1", "2", "0.5", "0.25", "3", "1.5"])


def _join(*parts: st.SearchStrategy[str], between: str) -> st.SearchStrategy[str]:
    return st.tuples(*parts).map(lambda texts: "(" + between.join(texts) + ")")


def _operations(value: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    several = st.lists(value, min_size=2, max_size=3).map(", ".join)
    return st.one_of(
        _join(value, value, between=" + "),
        _join(value, value, between=" - "),
        _join(value, _NUMBER, between=" * "),
        _join(value, st.sampled_from(["2", "0.5"]), between=" / "),
        _join(value, value, between=" / "),
        value.map(lambda text: f"abs({text})"),
        several.map(lambda text: f"min({text})"),
        several.map(lambda text: f"max({text})"),
        value.map(lambda text: f"(-{text})"),
    )


VALUES = st.recursive(st.one_of(_SIGNAL, _SIGNAL, _NUMBER), _operations, max_leaves=4)
_OPERATOR = st.sampled_from(["<", "<=", ">", ">=", "==", "!="])
ATOMS = st.one_of(
    st.tuples(VALUES, _OPERATOR, VALUES).map(" ".join),
    st.tuples(_SIGNAL, _OPERATOR, _NUMBER).map(" ".join),
    st.tuples(_SIGNAL, _OPERATOR, _NUMBER).map(" ".join),
    VALUES.map(lambda text: f"known({text})"),
    st.sampled_from(["light == red", "light in (red, green)", "known(sound)", "sound != low"]),
    st.sampled_from(["Arm == Up", "true", "false"]),
)
CONDITIONS = st.recursive(
    ATOMS,
    lambda inner: st.one_of(
        inner.map(lambda text: f"not ({text})"),
        st.lists(inner, min_size=2, max_size=3).map(lambda each: f"({' and '.join(each)})"),
        st.lists(inner, min_size=2, max_size=3).map(lambda each: f"({' or '.join(each)})"),
    ),
    max_leaves=5,
)
FACTS = st.lists(st.tuples(CONDITIONS, st.booleans()), min_size=1, max_size=3)


def conditions() -> Conditions:
    return Conditions(VOCABULARY, SPANS, 1)


def facts_of(texts: list[tuple[str, bool]]) -> list[Fact]:
    return [(compile_condition(text, VOCABULARY).tree, wanted) for text, wanted in texts]


def hold(texts: list[tuple[str, bool]], numbers: Any, words: Any) -> bool:
    """Whether the facts hold with these values, as the engine would evaluate them."""
    values = [numbers.get(name, math.nan) for name in VOCABULARY.numbers]
    spoken = [words.get(name) for name in VOCABULARY.words]
    return all(
        (compile_condition(text, VOCABULARY).evaluate(values, spoken) is True) == wanted
        for text, wanted in texts
    )


_GRID = (0.0, 0.125, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, math.nan)


def somewhere(texts: list[tuple[str, bool]], state: str, lot: Random) -> dict[str, Any] | None:
    """Values with which the facts hold, found by trying a grid and many at random."""
    tests = [(compile_condition(text, VOCABULARY).evaluate, wanted) for text, wanted in texts]
    for numbers in (*product(_GRID, repeat=2), *(_any(lot) for _ in range(300))):
        a, b, c = (*numbers, lot.choice([*_GRID, lot.uniform(-4, 4)]))[:3]
        if not (math.isnan(b) or -1 <= b <= 1):
            continue
        words = [state, lot.choice(["red", "green", None]), lot.choice(["low", "high", None])]
        if all((test((a, b, c), words) is True) == wanted for test, wanted in tests):
            return {"a": a, "b": b, "c": c, "words": words}
    return None


def _any(lot: Random) -> tuple[float, float, float]:
    return (
        lot.choice([lot.uniform(0, 2), math.nan]),
        lot.choice([lot.uniform(-1, 1), math.nan]),
        lot.choice([lot.uniform(-4, 4), lot.uniform(-40, 40), math.nan]),
    )

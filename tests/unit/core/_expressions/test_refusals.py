"""What is no expression, or does not fit the names, is refused with place and remedy."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pirate_sm.core._expressions import (
    EnumType,
    ExpressionError,
    ExpressionFault,
    NumberType,
    Vocabulary,
    compile_condition,
    compile_expression,
)
from pirate_sm.core._expressions.parser import tokenize
from pirate_sm.core.units import ANGLE, LENGTH, SPEED, Quantity

VOCABULARY = Vocabulary(
    {
        "bend": NumberType(ANGLE),
        "path": NumberType(LENGTH),
        "speed": NumberType(SPEED),
        "eye": EnumType(("close", "in", "past")),
        "Lamp": EnumType(("Off", "On")),
    }
)
PARAMETERS = {"give_up": Quantity(2.0, LENGTH), "word": "close", "wrong": "clse"}


def refused(text: str) -> ExpressionError:
    with pytest.raises(ExpressionError) as raised:
        compile_condition(text, VOCABULARY, PARAMETERS)
    return raised.value


@pytest.mark.parametrize(
    ("text", "at", "suggestion"),
    [
        ("pth > 1 m", "pth", "path"),
        ("eye == clos", "clos", "close"),
        ("Lamp == off", "off", "Off"),
        ("eyes == close", "eyes", "eye"),
        ("close == eyes", "eyes", "eye"),
        ("eye in (close, Past)", "Past", "past"),
        ("eye == $wrong", "$wrong", "close"),
        ("path > $giveup", "$giveup", "$give_up"),
        ("bend > 90", "90", "90 deg"),
        ("bend > -90", "-", "-90 deg"),
        ("0 < path", "0", "0 mm"),
        ("path + 3 > 1 m", "3", "3 mm"),
        ("bend > 3 degrees", "degrees", "deg"),
        ("ABS(bend) > 3 deg", "ABS", "abs"),
        ("path > 1 m AND true", "AND", "and"),
        ("path > 1 m && true", "&&", "and"),
        ("path > 1 m || true", "||", "or"),
        ("path = 1 m", "=", "=="),
        ("path ≥ 1 m", "≥", ">="),
        ("path => 1 m", "=>", ">="),
        ("eye <> close", "<>", "!="),
        ("!true", "!", "not"),
        ("eye > close", ">", "=="),
    ],
)
def test_what_was_meant_is_suggested_where_it_is_written(
    text: str, at: str, suggestion: str
) -> None:
    error = refused(text)

    assert error.offset == text.index(at)
    assert error.suggestion == suggestion
    assert len(error.faults) == 1


COMPARISONS = {">=": (">=", "=>", "≥"), "<=": ("<=", "=<", "≤"), "!=": ("!=", "<>", "≠", "!==")}
JOINS = {"and": (" and ", "&&", "&"), "or": (" or ", "||", "|")}
NEGATIONS = {"": ("",), "not": ("not ", "!", "! ")}
blanks = st.sampled_from(("", " "))


@st.composite
def spellings(draw: st.DrawFn) -> tuple[str, str]:
    """A condition as other languages write it, and as it is written here."""
    foreign, right = "", ""
    for number in range(draw(st.integers(1, 4))):
        if number:
            join = draw(st.sampled_from(sorted(JOINS)))
            foreign += draw(blanks) + draw(st.sampled_from(JOINS[join])) + draw(blanks)
            right += f" {join} "
        negation = draw(st.sampled_from(sorted(NEGATIONS)))
        comparison = draw(st.sampled_from(sorted(COMPARISONS)))
        value = draw(st.sampled_from(("200 mm", "(1 m + 2 mm)", "$give_up")))
        atom = f"path{draw(blanks)}{{}}{draw(blanks)}{value}"
        if draw(st.booleans()):
            atom = f"({atom})"
        foreign += draw(st.sampled_from(NEGATIONS[negation]))
        foreign += atom.format(draw(st.sampled_from(COMPARISONS[comparison])))
        right += f"{negation} {atom.format(comparison)}"
    return foreign, right


def faults_of(text: str) -> tuple[ExpressionFault, ...]:
    try:
        compile_condition(text, VOCABULARY, PARAMETERS)
    except ExpressionError as error:
        return error.faults
    return ()


def made_right(text: str) -> str:
    """The text after all corrections, one after the other; each is certain."""
    while faults := faults_of(text):
        [fault] = faults
        assert fault.certain, (text, fault)
        text = text[: fault.offset] + fault.suggestion + text[fault.offset + fault.length :]
    return text


@given(spellings())
@example(("path>=200 mm&&path<=1 m", "path >= 200 mm and path <= 1 m"))
@example(("path>=200 mm||!path<=1 m", "path >= 200 mm or not path <= 1 m"))
def test_operators_of_other_languages_are_corrected_to_what_they_mean(
    written: tuple[str, str],
) -> None:
    foreign, right = written

    corrected = made_right(foreign)

    assert [each.text for each in tokenize(corrected)] == [each.text for each in tokenize(right)]


@pytest.mark.parametrize(
    "text",
    [
        "path = 1 m",  # or >=, or <=
        "path > = 1 m",
        "path ! = 1 m",
        "true & & true",
        "true !true",
        "true && (true",
        "path >= 2 metres",
        "path := 1 m",
        "pth > 1 m",
    ],
)
def test_no_correction_is_certain_where_the_result_is_no_condition(text: str) -> None:
    assert [fault.certain for fault in refused(text).faults] == [False]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bend > 1 m", "cannot compare an angle and a length"),
        ("path + bend > 1 m", "cannot add a length and an angle"),
        ("path - speed > 1 m", "cannot subtract a length and a speed"),
        ("max(path, bend) > 1 m", "cannot compare a length and an angle"),
        ("path", "a condition is expected, this is a length: compare it with something"),
        ("eye", "'eye' is a word: compare it, as in 'eye == close'"),
        ("eye and true", "'and' needs a condition, not 'eye', a word: compare it, as in"
         " 'eye == close'"),
        ("not path", "'not' needs a condition, not 'path', a length"),
        ("eye + 1 > 2", "'+' needs a number, not 'eye', a word"),
        ("true == true", "'==' needs a number, not a condition"),
        ("eye == 3", "'eye' is a word: one of close, in, past"),
        ("eye == Lamp", "'eye' and 'Lamp' have no word in common"),
        ("path in (close)", "'in' is for signals with words, not for a length"),
        ("$word", "'$word' is a word: it can only be compared with == or in"),
        ("eye == $give_up", "'eye' is never '$give_up = Quantity(value=2.0, "),
        ("abs(path, path) > 1 m", "'abs' takes one value, not 2"),
        ("eye == 'close'", "words stand without quotes here"),
        ("$ > 1", "a '$' needs the name of a parameter after it"),
        ("", "the end comes where a value is expected"),
        ("abs(path", "the end comes where ')' is expected"),
        ("path >", "the end comes where a value is expected"),
        ("true false", "'false' stands where an operator or the end is expected"),
        ("eye not close", "'close' stands where 'in' is expected"),
        ("path > 1e999 m", "'1e999 m' is not a finite number"),
        ("(" * 40 + "true" + ")" * 40, "the expression is nested deeper than 32 levels"),
        ("not " * 40 + "true", "the expression is nested deeper than 32 levels"),
        ("1" + "+1" * 60 + " > 2", "the expression is nested deeper than 48 levels"),
        ("true or " * 200 + "true", "the expression is longer than 1000 characters"),
    ],
)  # fmt: skip
def test_a_refusal_says_what_is_wrong(text: str, message: str) -> None:
    assert refused(text).message.startswith(message)


@pytest.mark.parametrize(
    "text",
    ["path.real > 1", "__import__(os)", "open(path) > 1", "lambda: 1", "[path]", "{path}",
     "path if true else path", "(x := 1) > 0", "path ** 2 > 1", "path // 2 > 1", "path % 2 > 1",
     "path[0] > 1", "f(path) > 1", "'a' == 'a'", '"a" == "a"', "path; path", "path\n> 1 m\\",
     "eval(path)", "path @ path", "~path > 1 m", "`id`", "path is path", "...", "None",
     "path > 1 m # why", "for x in y", "yield 1", "eye.__class__ == close", "max(*path) > 1 m"],
)  # fmt: skip
def test_nothing_outside_the_language_passes(text: str) -> None:
    refused(text)


def test_all_independent_faults_come_at_once() -> None:
    error = refused("pth > 1 m and bend > 90 or eye == clos")

    assert [fault.suggestion for fault in error.faults] == ["path", "90 deg", "close"]
    assert [fault.offset for fault in error.faults] == [0, 21, 34]
    assert "column 22" in str(error)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("path + bend > 90 deg", "cannot add a length and an angle"),
        ("path + 3 > 90 deg", "'3' needs a unit here: the other side is a length"),
    ],
)
def test_a_sum_that_does_not_exist_is_not_compared_as_well(text: str, message: str) -> None:
    (fault,) = refused(text).faults

    assert fault.message == message


@pytest.mark.parametrize("text", ["abs(eye) == close", "close != abs(eye)"])
def test_a_function_of_numbers_given_a_word_is_the_only_fault_reported(text: str) -> None:
    (fault,) = refused(text).faults

    assert fault.message == "'abs' needs a number, not 'eye', a word"


def test_a_word_that_is_compared_with_a_number_is_reported() -> None:
    assert refused("abs(path) == close").message == "unknown name 'close'"


def test_a_word_alone_is_no_expression() -> None:
    with pytest.raises(ExpressionError, match="compare it"):
        compile_expression("Lamp", VOCABULARY)


@pytest.mark.parametrize("name", ["and", "in", "true", "abs", "m", "deg", "two words", "", "é"])
def test_a_vocabulary_has_only_names_that_can_be_written(name: str) -> None:
    with pytest.raises(ValueError, match=f"'{name}' cannot be"):
        Vocabulary({name: NumberType(LENGTH)})


@pytest.mark.parametrize("word", ["and", "false", "two words", "1st"])
def test_a_vocabulary_has_only_words_that_can_be_written(word: str) -> None:
    with pytest.raises(ValueError, match="cannot be used"):
        Vocabulary({"eye": EnumType((word,))})


def test_slots_count_numbers_and_words_apart() -> None:
    assert VOCABULARY.numbers == ("bend", "path", "speed")
    assert VOCABULARY.words == ("eye", "Lamp")
    assert (VOCABULARY.slot("Lamp").kind, VOCABULARY.slot("Lamp").index) == ("word", 1)


FRAGMENTS = st.sampled_from(
    ["bend", "path", "eye", "Lamp", "close", "in", "Off", "and", "or", "not", "(", ")", ",", "==",
     "<", ">=", "!=", "+", "-", "*", "/", "1", "2.5", "3 deg", "1 m", "m/s", "%", "abs(", "max(",
     "known(", "true", "$give_up", "$", ".", "'", "\n", "°", "1e9", "^2"]
)  # fmt: skip


@given(st.one_of(st.text(max_size=60), st.lists(FRAGMENTS, max_size=20).map(" ".join)))
@example("((((" * 100)
@example("-" * 500)
@example("1" * 400)
@example("1 m" + "/s" * 400)
@example("1 m^9" + "*m^9" * 200)
def test_no_text_raises_anything_but_an_expression_error(text: str) -> None:
    try:
        expression = compile_expression(text, VOCABULARY, PARAMETERS)
    except ExpressionError as error:
        offsets = [fault.offset for fault in error.faults]
    else:
        offsets = []
        expression.evaluate((float("nan"), 1.0, 0.0), (None, "Off"))
    assert all(0 <= offset <= len(text) for offset in offsets)


def test_a_change_counts_from_the_beginning_of_a_wait_and_stands_nowhere_else() -> None:
    (fault,) = refused("change(path) > 1 m").faults

    assert fault.message.startswith("'change' counts from the beginning of a wait")


@pytest.mark.parametrize("part", ["not false", "path > -1 m", "(true)"])
def test_parts_that_stand_side_by_side_are_not_nested(part: str) -> None:
    assert compile_condition(" and ".join([part] * 40), VOCABULARY).text.count(part) == 40

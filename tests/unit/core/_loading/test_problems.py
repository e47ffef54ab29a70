"""Problems say what is wrong, where, and what to do; all of them at once."""

from __future__ import annotations

import pytest

from pirate_sm.core._expressions import ExpressionError, ExpressionFault
from pirate_sm.core._loading.problems import LoadError, Place, Problem, Problems, Severity
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core.errors import PirateError

DOCUMENT = parse_document("robot: two_arms\nwhen: 'pth > 1 && x'\n", "m.yaml")


def test_a_problem_shows_the_line_and_marks_the_place() -> None:
    problem = Problem(
        "unknown-key",
        Place("m.yaml", 3, 5),
        "unknown key 'stat'",
        expected="one of start, ends",
        suggestion="start",
        excerpt="\tx: {stat: 1}\n",
    )

    assert problem.render().splitlines() == [
        "m.yaml:3:5: unknown key 'stat'",
        "     x: {stat: 1}",
        "        ^",
        "  expected one of start, ends",
        "  did you mean 'start'?",
    ]


def test_a_problem_with_a_whole_file_names_only_the_file() -> None:
    assert str(Problem("file", Place("m.yaml"), "is a directory")) == "m.yaml: is a directory"


@pytest.mark.parametrize("column", [1, 60, 250, 500])
def test_a_long_line_is_cut_around_the_place(column: int) -> None:
    line = "." * (column - 1) + "X" + "." * (500 - column)

    _, shown, caret = Problem("c", Place("f", 1, column), "m", excerpt=line).render().splitlines()

    assert len(shown) <= 104
    assert shown[caret.index("^")] == "X"


def test_a_collector_places_values_keys_and_characters() -> None:
    problems = Problems(DOCUMENT)
    problems.add("value", ("robot",), "no such robot", suggestion="one_arm")
    problems.add("key", ("robot",), "deprecated", key=True, severity=Severity.WARNING)
    problems.add("char", ("when",), "odd", offset=6)

    assert [str(found.place) for found in problems.all] == [
        "m.yaml:1:1",
        "m.yaml:1:8",
        "m.yaml:2:14",
    ]
    assert [found.code for found in problems.errors] == ["value", "char"]
    assert "m.yaml:1:1: warning: deprecated" in str(problems.all[0])


def test_faults_of_an_expression_stand_at_their_own_columns() -> None:
    problems = Problems(DOCUMENT)
    problems.add_expression(
        ("when",),
        ExpressionError([ExpressionFault("bad", 8, "and"), ExpressionFault("unknown", 0, "path")]),
    )

    assert [(found.place.column, found.suggestion) for found in problems.all] == [
        (8, "path"),
        (16, "and"),
    ]


def test_collectors_of_several_documents_share_one_list() -> None:
    problems = Problems()
    problems.about(DOCUMENT).add("a", (), "first")
    problems.about(parse_document("x: 1", "a.yaml")).add("b", (), "second")

    with pytest.raises(LoadError) as raised:
        problems.raise_errors()
    assert [found.place.file for found in raised.value.problems] == ["a.yaml", "m.yaml"]
    assert isinstance(raised.value, PirateError)
    assert raised.value.exit_code == 2


def test_a_collector_without_a_document_has_no_places() -> None:
    with pytest.raises(ValueError, match="about"):
        Problems().add("a", (), "lost")


def test_the_same_problem_is_said_once() -> None:
    problems = Problems(DOCUMENT)
    problems.add("a", (), "again")
    problems.add("a", (), "again")

    assert len(problems.all) == 1


def test_a_message_stays_readable_whatever_a_file_holds() -> None:
    problems = [
        Problem("tag", Place("f", line + 1, 1), "x" * 1_000_000, "y" * 1_000_000, "z" * 1_000_000)
        for line in range(100)
    ]
    error = LoadError(problems)

    assert len(error.problems) == 100
    assert len(str(error)) < 60_000
    assert str(error).endswith("… and 50 more problems")


def test_warnings_alone_keep_nothing_from_loading() -> None:
    problems = Problems(DOCUMENT)
    problems.add("old", (), "an old word", severity=Severity.WARNING)

    problems.raise_errors()

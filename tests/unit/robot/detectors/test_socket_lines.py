from __future__ import annotations

import json
from math import isnan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core.events import DetectorWord, OutsideNumber
from pirate_sm.robot.detectors.socket_detector import (
    LONGEST_LINE,
    AcceptedLines,
    LineError,
    read_line,
)

FIELDS = ("word", "valid_for_s", "age_s", "signal", "value")
ACCEPTED = AcceptedLines(("near", "far"), 0.5, {"ruler": 0.3})


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b'{"word": "near"}', DetectorWord("near", 0.5)),
        (b' {"valid_for_s": 2, "word": "far"}\r', DetectorWord("far", 2.0)),
        (b'{"word": "far", "valid_for_s": 60}', DetectorWord("far", 60.0)),
        (b'{"word": "near"}' + b" " * (LONGEST_LINE - 16), DetectorWord("near", 0.5)),
        (b'{"word": "far", "age_s": 0.125}', DetectorWord("far", 0.375)),
        (b'{"signal": "ruler", "value": -0.05}', OutsideNumber("ruler", -0.05)),
        (b'{"signal": "ruler", "value": 2, "age_s": 0.2}', OutsideNumber("ruler", 2.0, 0.2)),
    ],
)
def test_a_line_says_a_word(line: bytes, said: DetectorWord) -> None:
    assert read_line(line, ACCEPTED) == said


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"near", "not a line of JSON"),
        (b"\xff\xfe", "not a line of JSON"),
        (b"[" * 4000, "not a line of JSON"),
        (b'["near"]', 'expected an object such as {"word": "near"}'),
        (b"{}", "'word' is a text, one of near, far"),
        (b'{"word": 3}', "'word' is a text"),
        (b'{"word": "Near"}', "did you mean 'near'"),
        (b'{"word": "elsewhere"}', "expected one of near, far"),
        (b'{"word": "near", "valid_for": 1}', "unknown field 'valid_for'"),
        (b'{"word": "near", "' + b"x" * 60 + b'": 1}', f"unknown field '{'x' * 60}'"),
        (b'{"word": "near", "' + b"x" * 61 + b'": 1}', f"unknown field '{'x' * 59}…'"),
        (b'{"word": "near", "valid_for_s": 0}', "more than 0 and at most 60"),
        (b'{"word": "near", "valid_for_s": 61}', "at most 60"),
        (b'{"word": "near", "valid_for_s": NaN}', "at most 60"),
        (b'{"word": "near", "valid_for_s": true}', "is a number"),
        (b'{"word": "near", "valid_for_s": "1 s"}', "is a number"),
        (b'{"word": "near", "valid_for_s": 1' + b"0" * 400 + b"}", "at most 60"),
        (b'{"word": "near", "age_s": 0.5}', "at least 0 and less than the validity, 0.5"),
        (b'{"word": "near", "age_s": -0.1}', "at least 0"),
        (b'{"word": "near", "age_s": NaN}', "at least 0"),
        (b'{"signal": "ruler"}', "'value' is a number in SI units"),
        (b'{"signal": "ruler", "value": "5 mm"}', "'value' is a number in SI units"),
        (b'{"signal": "ruler", "value": true}', "'value' is a number in SI units"),
        (b'{"signal": "ruler", "value": NaN}', "finite"),
        (b'{"signal": "ruler", "value": 1e300}', "finite"),
        (b'{"signal": "ruler", "value": 1e400}', "finite"),
        (b'{"signal": "ruler", "value": 1' + b"0" * 400 + b"}", "finite"),
        (b'{"signal": "rulr", "value": 1}', "did you mean 'ruler'"),
        (b'{"signal": 3, "value": 1}', "'signal' is a text, ruler"),
        (b'{"signal": "ruler", "value": 1, "age_s": 0.3}', "less than the validity, 0.3"),
        (b'{"signal": "ruler", "value": 1, "word": "near"}', "unknown field 'word'"),
        (b'{"word": "near"}' + b" " * LONGEST_LINE, "at most 4096 bytes"),
    ],
)
def test_a_line_that_cannot_be_used_is_refused_with_the_reason(line: bytes, why: str) -> None:
    with pytest.raises(LineError, match=why):
        read_line(line, ACCEPTED)


@pytest.mark.thorough
@given(
    st.binary(max_size=200)
    | st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(
                st.sampled_from(("word", "valid_for_s", "age_s", "signal", "value")) | st.text(),
                inner,
            )
        ),
    ).map(lambda value: json.dumps(value).encode())
)
def test_any_line_says_a_word_or_why_not(line: bytes) -> None:
    why, said = "", None
    try:
        said = read_line(line, ACCEPTED)
    except LineError as error:
        why = str(error)
    if said is None:
        assert 0 < len(why) < 200
        assert why.isprintable()
    else:
        age_s = said.age_s if isinstance(said, OutsideNumber) else 0.0
        assert 0 <= age_s < 0.3
        if isinstance(said, DetectorWord):
            assert said.word in ACCEPTED.words
            assert 0 < said.valid_for_s <= 60


def test_null_is_an_unknown_number() -> None:
    said = read_line(b'{"signal": "ruler", "value": null}', ACCEPTED)
    assert isinstance(said, OutsideNumber)
    assert isnan(said.value)


def test_who_may_send_numbers_only_sends_no_words() -> None:
    with pytest.raises(LineError, match="no word is accepted here"):
        read_line(b'{"word": "near"}', AcceptedLines((), signals={"ruler": 0.3}))
    with pytest.raises(LineError, match='"signal": "ruler"'):
        read_line(b"[]", AcceptedLines((), signals={"ruler": 0.3}))

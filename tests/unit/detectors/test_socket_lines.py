from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.detectors.socket_lines import LONGEST_LINE, LineError, read_line
from pirate_sm.model.events import DetectorWord

WORDS = ("near", "far")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b'{"word": "near"}', DetectorWord("near", 0.5)),
        (b' {"valid_for_s": 2, "word": "far"}\r', DetectorWord("far", 2.0)),
        (b'{"word": "far", "valid_for_s": 60}', DetectorWord("far", 60.0)),
    ],
)
def test_a_line_says_a_word(line: bytes, said: DetectorWord) -> None:
    assert read_line(line, WORDS, 0.5) == said


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (b"near", "not a line of JSON"),
        (b"\xff\xfe", "not a line of JSON"),
        (b"[" * 4000, "not a line of JSON"),
        (b'["near"]', "expected an object"),
        (b"{}", "'word' is a text, one of near, far"),
        (b'{"word": 3}', "'word' is a text"),
        (b'{"word": "Near"}', "did you mean 'near'"),
        (b'{"word": "elsewhere"}', "expected one of near, far"),
        (b'{"word": "near", "valid_for": 1}', "unknown field 'valid_for'"),
        (b'{"word": "near", "valid_for_s": 0}', "more than 0 and at most 60"),
        (b'{"word": "near", "valid_for_s": 61}', "at most 60"),
        (b'{"word": "near", "valid_for_s": NaN}', "at most 60"),
        (b'{"word": "near", "valid_for_s": true}', "is a number"),
        (b'{"word": "near", "valid_for_s": "1 s"}', "is a number"),
        (b'{"word": "near", "valid_for_s": 1' + b"0" * 400 + b"}", "at most 60"),
        (b'{"word": "near"}' + b" " * LONGEST_LINE, "at most 4096 bytes"),
    ],
)
def test_a_line_that_says_nothing_is_told_why(line: bytes, why: str) -> None:
    with pytest.raises(LineError, match=why):
        read_line(line, WORDS, 0.5)


@given(
    st.binary(max_size=200)
    | st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(st.sampled_from(("word", "valid_for_s")) | st.text(), inner)
        ),
    ).map(lambda value: json.dumps(value).encode())
)
def test_any_line_says_a_word_or_why_not(line: bytes) -> None:
    why, said = "", None
    try:
        said = read_line(line, WORDS, 0.5)
    except LineError as error:
        why = str(error)
    if said is None:
        assert 0 < len(why) < 200
        assert why.isprintable()
    else:
        assert said.word in WORDS
        assert 0 < said.valid_for_s <= 60

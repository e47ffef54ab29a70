"""YAML text becomes plain data that knows its places, or a list of problems."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st

from pirate_sm.core import library
from pirate_sm.core._loading.problems import LoadError, Problem
from pirate_sm.core._loading.yaml import composer
from pirate_sm.core._loading.yaml.document import parse_document, read_document

from ..conftest import ROOT

TEXT = """\
# a comment
robot: two_arms
steps:
  - Halt
  - {command: 'Go on', within: 5 s}
  - when: eye == close
    held: >
      a folded
      text
Off: on
"""


def problems_of(text: str | bytes) -> tuple[Problem, ...]:
    with pytest.raises(LoadError) as raised:
        parse_document(text, "f.yaml")
    return raised.value.problems


def places_of(text: str | bytes) -> list[tuple[str, int, int]]:
    return [(found.code, found.place.line, found.place.column) for found in problems_of(text)]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("Off", "Off"), ("on", "on"), ("yes", "yes"), ("No", "No"), ("y", "y"),
        ("12:30", "12:30"), ("2026-01-01", "2026-01-01"), ("1_000", "1_000"), ("0b1", "0b1"),
        ("120 mm", "120 mm"), ("60 %", "60 %"), ("'12'", "12"), ('"true"', "true"),
        ("! 12", "12"), ("!!str 12", "12"), ("1.2.3", "1.2.3"), ("+", "+"), (".", "."),
        ("true", True), ("False", False), ("null", None), ("~", None), ("", None),
        ("12", 12), ("-3", -3), ("+3", 3), ("007", 7), ("0x1F", 31), ("0o17", 15),
        ("1.5", 1.5), (".5", 0.5), ("1e3", 1000.0), ("5.", 5.0), ("!!float 3", 3.0),
        (".inf", math.inf), ("-.INF", -math.inf), ("!!int 3", 3), ("!!null ~", None),
    ],
)  # fmt: skip
def test_scalars_follow_the_core_schema_of_yaml_1_2(written: str, meant: object) -> None:
    data = parse_document(f"key: {written}", "f").data

    assert data == {"key": meant}
    assert type(data["key"]) is type(meant)


def test_nan_is_a_number() -> None:
    assert math.isnan(parse_document(".nan", "f").data)


def test_data_is_plain() -> None:
    document = parse_document(TEXT, "f.yaml")

    assert document.data == {
        "robot": "two_arms",
        "steps": [
            "Halt",
            {"command": "Go on", "within": "5 s"},
            {"when": "eye == close", "held": "a folded text\n"},
        ],
        "Off": "on",
    }


@pytest.mark.parametrize(
    ("path", "key", "offset", "line", "column"),
    [
        ((), False, None, 2, 1),
        (("robot",), False, None, 2, 8),
        (("robot",), True, None, 2, 1),
        (("steps",), True, None, 3, 1),
        (("steps", 0), False, None, 4, 5),
        (("steps", 1), True, None, 5, 5),
        (("steps", 1, "command"), False, None, 5, 15),
        (("steps", 1, "command"), False, 3, 5, 19),
        (("steps", 2, "when"), False, 7, 6, 18),
        (("steps", 2, "when"), False, 99, 6, 23),
        (("steps", 2, "held"), False, 2, 8, 9),
        (("Off",), True, None, 10, 1),
        (("steps", 7, "when"), False, None, 4, 3),
        (("steps", 1, "missing"), False, None, 5, 5),
        (("nowhere", 1), False, None, 2, 1),
    ],
)
def test_a_document_finds_places(
    path: tuple[str | int, ...], key: bool, offset: int | None, line: int, column: int
) -> None:
    place = parse_document(TEXT, "f.yaml").place_of(path, key=key, offset=offset)

    assert (place.file, place.line, place.column) == ("f.yaml", line, column)


def test_an_offset_counts_in_the_line_of_a_block() -> None:
    document = parse_document("when: |\n  one\n  and two\n", "f")

    place = document.place_of(("when",), offset=len("one\nand "))

    assert (place.line, place.column) == (3, 7)


def test_an_offset_counts_over_the_lines_of_a_folded_block() -> None:
    text = "when: >-\n  one\n    and two\n\n  or three\nthen: x\n"
    document = parse_document(text, "f")
    value = document.data["when"]

    places = [
        document.place_of(("when",), offset=value.index(word))
        for word in ("one", "and", "two", "three")
    ]
    beyond = document.place_of(("when",), offset=len(value))

    assert [(each.line, each.column) for each in places] == [(2, 3), (3, 5), (3, 9), (5, 6)]
    assert (beyond.line, beyond.column) == (5, 11)


def test_an_alias_has_its_own_place_and_its_anchors_content() -> None:
    document = parse_document("a: &x {b: 1}\nc: *x\n", "f")

    assert document.data == {"a": {"b": 1}, "c": {"b": 1}}
    assert str(document.place_of(("c",))) == "f:2:4"
    assert str(document.place_of(("c", "b"))) == "f:1:11"


def test_a_byte_order_mark_and_wide_characters_move_no_place() -> None:
    document = parse_document("\ufeffä: 😀\nb: c\n".encode(), "f")

    assert document.data == {"ä": "😀", "b": "c"}
    assert str(document.place_of(("b",))) == "f:2:4"


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("a: 1\nb: 2\na: 3", [("duplicate-key", 3, 1)]),
        ("{x: 1, 'x': 2}", [("duplicate-key", 1, 8)]),
        ("1: a\ntrue: b\n~: c", [("key", 1, 1), ("key", 2, 1), ("key", 3, 1)]),
        ("{a: 1}: b", [("key", 1, 1)]),
        ("a: &x {y: 1}\nb: {<<: *x}", [("merge-key", 2, 5)]),
        ("a: !!python/object/apply:os.system [ls]", [("tag", 1, 4)]),
        ("a: !custom 1\nb: !!int x\nc: !!set {}", [("tag", 1, 4), ("tag", 2, 4), ("tag", 3, 4)]),
        ("a: *gone", [("alias", 1, 4)]),
        ("a: &x [1, *x]", [("alias", 1, 11)]),
        ("a: 1\n---\nb: 2", [("documents", 2, 1)]),
        ("a: 99999999999999999999\nb: 1e999", [("number", 1, 4), ("number", 2, 4)]),
        ("a: 1\n\tb: 2", [("syntax", 2, 1)]),
        ("a:\n\tb: 2", [("syntax", 2, 1)]),
        ("a: [1, 2\nb: 3", [("syntax", 1, 4)]),
        ("a: {b: 1", [("syntax", 1, 4)]),
        ("a: 'open", [("syntax", 1, 4)]),
        ("a: [1,\nb: [", [("syntax", 2, 4)]),
        ("a: {b: c d: e}", [("syntax", 1, 11)]),
        ("a: {b: [}", [("syntax", 1, 9)]),
        ("a: ]", [("syntax", 1, 4)]),
        ("a: b: c", [("syntax", 1, 5)]),
        ("a: 1\nb c\nd: 2", [("syntax", 2, 1)]),
        ("a: 1\nb:c\n\n\nd: 2", [("syntax", 2, 1)]),
        ("a: %b", [("syntax", 1, 4)]),
        ("a: - b", [("syntax", 1, 4)]),
        ("- a\nb: 1", [("syntax", 2, 1)]),
        ("a: 1\n- b", [("syntax", 2, 1)]),
        ("a: \"\\q\"", [("syntax", 1, 5)]),
        ("[" * 33 + "]" * 33, [("too-deep", 1, 33)]),
        ("[" * 100_000, [("too-deep", 1, 33)]),
        ("a: 1\na: 2\nb: " + "[" * 5_000, [("duplicate-key", 2, 1), ("too-deep", 3, 35)]),
        ("a: \x01", [("binary", 1, 4)]),
        (b"ok: 1\na: \xff", [("encoding", 2, 4)]),
        (b"ok: 1\ra: \xff", [("encoding", 2, 4)]),
        (b"\x7fELF\x00\x01\xff", [("binary", 0, 0)]),
        (b"a\x00b", [("binary", 0, 0)]),
        ("a: 1".encode("utf-16"), [("encoding", 0, 0)]),
        (b"", [("empty", 0, 0)]),
        ("# only a comment\n", [("empty", 0, 0)]),
        ("#" * (1 << 20) + "\n", [("too-large", 0, 0)]),
        (b"#" * (1 << 20) + b"\n", [("too-large", 0, 0)]),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused_at_its_place(
    text: str | bytes, faults: list[tuple[str, int, int]]
) -> None:
    assert places_of(text) == faults


def test_all_that_is_wrong_before_a_syntax_error_is_said_with_it() -> None:
    assert places_of("a: 1\na: 2\nb: [") == [("duplicate-key", 2, 1), ("syntax", 3, 4)]


def test_reading_ends_after_many_faults() -> None:
    codes = [code for code, _, _ in places_of("a: 1\n" * 100_000)]

    assert len(codes) == 201
    assert codes[-1] == "more"


def test_both_places_of_a_duplicate_key_are_named() -> None:
    (problem,) = problems_of("a:\n  b: 1\n  b: 2")

    assert problem.message == "the key 'b' appears twice; first in line 2, column 3"


def test_many_small_aliases_are_refused() -> None:
    text = "a: &a 1\nb: [" + ", ".join(["*a"] * 101) + "]"

    assert [code for code, _, _ in places_of(text)] == ["aliases"]


def test_few_aliases_that_multiply_are_refused() -> None:
    lines = ["l0: &l0 [x, x, x, x, x, x, x, x, x]"]
    lines += [
        f"l{level}: &l{level} [{', '.join([f'*l{level - 1}'] * 9)}]" for level in range(1, 10)
    ]

    assert [code for code, _, _ in places_of("\n".join(lines))] == ["too-large"]


def test_aliases_cannot_nest_deeper_than_text_can() -> None:
    lines = ["l0: &l0 [x]"]
    lines += [f"l{level}: &l{level} [*l{level - 1}]" for level in range(1, 40)]

    assert [code for code, _, _ in places_of("\n".join(lines))] == ["too-deep"]


def test_a_file_is_read_under_its_name(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text("a: 1\n", encoding="utf-8")

    assert read_document(file).name == str(file)
    assert read_document(file, name="missions/m").place_of(()).file == "missions/m"
    assert read_document(str(file)).data == {"a": 1}


def test_what_is_no_readable_file_is_a_problem(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    (tmp_path / "large.yaml").write_bytes(b" " * ((1 << 20) + 1))

    for path, words in [
        (tmp_path / "gone.yaml", "no such file"),
        (tmp_path, "is a directory"),
        (tmp_path / "loop", "cannot be read"),
        (tmp_path / "large.yaml" / "inside", "cannot be read"),
        (tmp_path / "large.yaml", "larger than 1 MiB"),
        (Path("/dev/null"), "not a regular file"),
        (tmp_path / ("x" * 5000), "cannot be read"),
        (Path("nul\0byte"), "cannot be read"),
    ]:
        with pytest.raises(LoadError) as raised:
            read_document(path)
        assert words in str(raised.value)
        assert raised.value.exit_code == 2


PLAIN = st.recursive(
    st.one_of(
        st.none(),
        st.booleans(),
        st.integers(-(10**16), 10**16),
        st.floats(allow_nan=False),
        st.text(max_size=20),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(PLAIN)
def test_plain_data_comes_back_as_it_was_written(data: object) -> None:
    # Quoted and tagged, as what PyYAML leaves bare follows the rules of YAML 1.1.
    text = yaml.safe_dump(data, default_style='"')
    try:
        document = parse_document(text, "f")
    except LoadError as error:
        codes = {found.code for found in error.problems}
    else:
        codes = set()
        assert document.data == data
    assert codes == ({"merge-key"} if _has_merge_key(data) else set())


def _has_merge_key(data: object) -> bool:
    if isinstance(data, list):
        return any(map(_has_merge_key, data))
    return isinstance(data, dict) and ("<<" in data or any(map(_has_merge_key, data.values())))


PIECES = st.sampled_from(
    ["a", "b: ", ": ", "- ", "\n", "\n  ", "\t", "[", "]", "{", "}", ",", "&x ", "*x", "!t ", "'",
     '"', "|", ">", "#", "%", "@", "---", "...", "<<", "? ", "\\", "1", "~", "\x00", "\ud800", "é"]
)  # fmt: skip


@given(
    st.one_of(
        st.text(max_size=60), st.binary(max_size=60), st.lists(PIECES, max_size=20).map("".join)
    )
)
@example("a: \x85b\u2028: [")
def test_no_content_raises_anything_but_a_load_error(text: str | bytes) -> None:
    try:
        places = [parse_document(text, "f").place_of(("a", 0), offset=3)]
    except LoadError as error:
        places = [found.place for found in error.problems]
    assert all(place.line <= len(text) + 1 for place in places)


def test_without_libyaml_the_same_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    examples = (ROOT / "docs/examples").glob("*.yaml")
    files = [*library.robots()[0].glob("*.yaml"), *library.missions(), *examples]
    texts = [each.read_text("utf-8") for each in files]
    fast = [composer.compose(text) for text in texts]

    monkeypatch.setattr(composer, "_Loader", yaml.SafeLoader)

    assert [composer.compose(text) for text in texts] == fast


def test_without_libyaml_a_question_mark_between_brackets_is_refused_not_misread(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(composer, "_Loader", yaml.SafeLoader)

    assert places_of("{ask: Go on?, then: go}") == [("syntax", 1, 12)]
    assert parse_document("ask: Go on?", "f.yaml").data == {"ask": "Go on?"}

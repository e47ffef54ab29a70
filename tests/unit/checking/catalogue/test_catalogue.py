"""Every code that can be raised is explained, and every one that is explained can be raised."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Severity
from pirate_sm.core._loading.yaml.composer import compose

from ..robots import ROOT

PACKAGE = ROOT / "pirate_sm"
SOURCES = [
    *sorted((PACKAGE / "core" / "_loading").rglob("*.py")),
    PACKAGE / "core" / "generated_missions.py",
    *sorted((PACKAGE / "checking").rglob("*.py")),
    PACKAGE / "lab" / "experiments" / "experiment_files.py",
    PACKAGE / "lab" / "gallery" / "scene_file.py",
    PACKAGE / "lab" / "campaign" / "campaign_file.py",
    PACKAGE / "lab" / "campaign" / "named_parts.py",
    *(each for each in (PACKAGE / "core" / "_model").rglob("*.py") if each.name != "faults.py"),
    *sorted((PACKAGE / "robot").glob("*.py")),
    *sorted((PACKAGE / "robot" / "control_panel").glob("*.py")),
    PACKAGE / "robot" / "backends" / "trace_script.py",
    PACKAGE / "cli" / "commands" / "fresh_check.py",
    PACKAGE / "cli" / "commands" / "new.py",
]
ENTRIES = catalogue.entries()
GROUPS = {code.partition(".")[0] for code in ENTRIES if "." in code}
DOTTED = re.compile(rf"({'|'.join(sorted(GROUPS))})\.(?!yaml$)[a-z_]+")
FORM = {
    "add",
    "add_unknown",
    "Problem",
    "YamlFault",
    "_fault",
    "_refusal",
    "Wording",
    "ScalarError",
}
"""What takes the code of a faulty form as one of its first arguments."""

COMPOSED = {
    "robot.{}": {
        f"robot.{kind}" for kind in ("part", "wheel", "joint", "slot", "signal", "board", "roll")
    },
    "robot.fault_{}": {"robot.fault_always", "robot.fault_never"},
    "call.{}starts_in": {"call.starts_in", "call.maybe_starts_in"},
    "step.{}{}": {
        f"step.{maybe}{kind}" for maybe in ("", "maybe_") for kind in ("impossible", "unneeded")
    },
}
"""Codes that are put together when they are raised."""


@cache
def parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text("utf-8"))


@cache
def raised() -> set[str]:
    found = {code for file in SOURCES for code in codes_in(parsed(file))}
    form = {code for file in SOURCES for code in form_codes_in(file)}
    return (found | form).union(*COMPOSED.values())


def codes_in(node: ast.AST) -> Iterator[str]:
    match node:
        case ast.JoinedStr():
            return
        case ast.Constant(value=str(text)) if DOTTED.fullmatch(text):
            yield text
        case ast.keyword(arg="custom_error_type", value=ast.Constant(value=str(text))):
            yield text
    for child in ast.iter_child_nodes(node):
        yield from codes_in(child)


def form_codes_in(file: Path) -> Iterator[str]:
    """Codes without a group, which only loading raises."""
    for node in ast.walk(parsed(file)):
        if "_loading" in file.parts and isinstance(node, ast.Call) and _name(node) in FORM:
            first = (each.value for each in node.args[:3] if isinstance(each, ast.Constant))
            yield from [text for text in first if isinstance(text, str)][:1]


def templates_in(file: Path) -> Iterator[str]:
    for node in ast.walk(parsed(file)):
        if isinstance(node, ast.JoinedStr):
            parts = (str(p.value) if isinstance(p, ast.Constant) else "{}" for p in node.values)
            template = "".join(parts)
            if re.fullmatch(rf"({'|'.join(GROUPS)})\.[a-z_{{}}]*", template):
                yield template


def _name(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")


def test_every_code_that_can_be_raised_is_explained() -> None:
    assert sorted(raised() - ENTRIES.keys()) == []


def test_every_code_that_is_explained_can_be_raised() -> None:
    assert sorted(ENTRIES.keys() - raised()) == []


def test_it_is_known_which_codes_are_put_together() -> None:
    assert {template for file in SOURCES for template in templates_in(file)} == COMPOSED.keys()


@pytest.mark.parametrize("code", ENTRIES)
def test_an_entry_says_all_there_is_to_say_in_few_words(code: str) -> None:
    entry = ENTRIES[code]

    assert Severity[entry.severity.upper()]
    for text in (entry.title, entry.why, entry.fix):
        assert 0 < len(text) <= 105
        assert text == text.strip()
    assert not entry.title.endswith(".")
    assert entry.why.endswith(".")
    assert entry.fix.endswith(".")
    assert entry.wrong.strip() != entry.right.strip()
    assert compose(entry.right)[1] == ()


def test_what_keeps_a_file_from_being_used_cannot_be_allowed() -> None:
    allowable = catalogue.allowable()

    assert {"step.impossible", "chart.trap", "geometry.too_close", "parameter.unused"} <= allowable
    assert not {"syntax", "mission.name", "chart.guard", "allow.reason", "allow.unused"} & allowable


def test_a_misspelt_code_is_understood() -> None:
    assert catalogue.nearest_code("step.imposible") == "step.impossible"
    assert catalogue.nearest_code("no idea at all") is None


def test_a_code_without_an_entry_can_be_shown_all_the_same() -> None:
    assert catalogue.entry_of("no.such_code").title == "no.such_code"

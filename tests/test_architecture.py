"""What must stay true of the source as a whole: no robot in it, and no file that grew too big."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pirate_sm"
SHIPPED_ROBOT = ROOT / "hardware_profiles" / "pirate_ii"
SOURCES = sorted(PACKAGE.rglob("*.py"))
LONGEST_FILE = 400
LONGEST_FUNCTION = 60

# Where a profile or a chart gives names: the keys of these mappings, the names in these lists.
NAMING_SECTIONS = {
    "aliases",
    "boards",
    "channels",
    "commands",
    "joints",
    "modules",
    "sensors",
    "signals",
    "slots",
    "states",
    "wheels",
}
NAMING_KEYS = {"event", "id", "name"}

# Names of the shipped robot that are also plain words or words of the mission language.
PLAIN_WORDS = {
    "Fixed",
    "Free",
    "Off",
    "On",
    "Reset",
    "Straight",
    "detector",
    "diameter",
    "distance",
    "environment",
    "fallen",
    "front",
    "imu",
    "middle",
    "odometry",
    "pitch",
    "rear",
    "robot",
    "roll",
    "rotation",
    "segment",
    "speed",
    "stuck",
    "yaw",
}

# The name of this software: its package, its two commands and its errors.
OUR_NAME = re.compile(r"""\bpirate[_-]sm\b|\bpirate-run\b|\bPirateError\b|\bpirate (?=[a-z])""")
OUR_COMMAND = re.compile(r"""["'`]pirate["'`]""")


def _names(node: object, *, section: str = "") -> Iterator[str]:
    """Every name that the YAML below `node` gives to something."""
    if isinstance(node, list):
        for item in node:
            if isinstance(item, str) and section in NAMING_SECTIONS:
                yield item
            yield from _names(item, section=section)
    elif isinstance(node, dict):
        for key, value in node.items():
            # Lists are told apart by the names within them, mappings by their keys.
            if section in NAMING_SECTIONS:
                yield key
            if key in NAMING_KEYS and isinstance(value, str):
                yield value
            yield from _names(value, section=key)


def _shipped_words() -> set[str]:
    """The words that only the shipped robot's files may use, without the plain ones."""
    words: set[str] = set()
    for file in sorted(SHIPPED_ROBOT.rglob("*.yaml")):
        # BaseLoader leaves every scalar a string: `Off` stays a name.
        document = yaml.load(file.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
        for name in _names(document):
            words.update(part for part in name.split(".") if re.fullmatch(r"[A-Za-z]\w{2,}", part))
    return words - PLAIN_WORDS


def _flat(word: str) -> str:
    return word.replace("_", "").lower()


def _foreign_words(text: str, words: set[str]) -> list[str]:
    """Each `line: word` where `text` uses one of `words`, in any spelling of a compound one."""
    # ClampFront is also clamp_front and CLAMP_FRONT, and part of on_clamp_front.
    compounds = {_flat(word) for word in words if re.search(r"[a-z_][A-Z]|[a-z0-9]_[a-z]", word)}
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        for token in re.findall(r"[A-Za-z]\w*", line):
            flat = _flat(token)
            if token in words or any(compound in flat for compound in compounds):
                found.append(f"{number}: {token}")
    return found


@pytest.fixture(scope="module")
def shipped_words() -> set[str]:
    return _shipped_words()


def test_the_shipped_robot_gives_the_words_that_this_module_looks_for(
    shipped_words: set[str],
) -> None:
    assert {"ClampFront", "BendingState", "DoubleClamped", "AlignedRight"} <= shipped_words


def test_a_compound_name_is_found_in_every_spelling() -> None:
    text = "on_clamp_front = CLAMP_FRONT\nx = 'ClampFront'\nclamp(front)"

    assert _foreign_words(text, {"ClampFront"}) == [
        "1: on_clamp_front",
        "1: CLAMP_FRONT",
        "2: ClampFront",
    ]


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_source_file_names_anything_of_the_shipped_robot(
    source: Path, shipped_words: set[str]
) -> None:
    assert _foreign_words(source.read_text(encoding="utf-8"), shipped_words) == []


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_pirate_is_the_name_of_this_software_only(source: Path) -> None:
    text = OUR_NAME.sub("", source.read_text(encoding="utf-8"))
    if source.is_relative_to(PACKAGE / "cli"):
        text = OUR_COMMAND.sub("", text)

    assert [line for line in text.splitlines() if "pirate" in line.lower()] == []


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_files_and_functions_stay_small(source: Path) -> None:
    text = source.read_text(encoding="utf-8")
    functions = [
        node
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    long_functions = {
        node.name: length
        for node in functions
        if (length := (node.end_lineno or node.lineno) - node.lineno + 1) > LONGEST_FUNCTION
    }

    assert len(text.splitlines()) <= LONGEST_FILE
    assert long_functions == {}

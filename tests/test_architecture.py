"""What must stay true of the source as a whole: no robot in it, and no file that grew too big."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pirate_sm"
SHIPPED_ROBOT = ROOT / "hardware_profiles" / "pirate_ii"
TEXTS = {
    file.relative_to(PACKAGE).as_posix(): file.read_text(encoding="utf-8")
    for file in sorted(PACKAGE.rglob("*.py"))
}
"""The source files by their names in the package."""

FIRMWARE = {
    file.relative_to(ROOT).as_posix(): file.read_text(encoding="utf-8")
    for file in sorted((ROOT / "firmware" / "src").iterdir())
}

_WORD = re.compile(r"[A-Za-z]\w*")
LONGEST_FILE = 500
LONG_FILE, MOST_LONG_FILES = 400, 64
"""Files that are longer than this may only become fewer (decision 122)."""

LONGEST_FUNCTION = 60
# `advance` cuts its arguments up into the arrays that all others take, a line for each.
LONGER_FOR_A_REASON = {
    "simulation/kinematic/kernel.py": 90,
    "simulation/kinematic/space/kernel.py": 110,
}

HANDED_OUT_FOR_RECIPES = {"pirate_sm.core.models.Blockage"}
"""Names that nothing uses yet, but an example of docs/changing.md."""

CORE_HANDS_OUT = {"names": 517, "modules": 27}
"""What the other rooms use of the core; these may only become fewer (decision 121)."""

# Where a chart or a profile gives names: the keys of these mappings and the values of these keys.
NAMING_SECTIONS = {"aliases", "commands", "derived", "not_commands", "signals", "states"}
NAMING_KEYS = {"event", "id", "name", "signal"}

# Names of the shipped robot that are also words of the trade: states and a command, what any
# wheel and any bend of a pipe have, the axes of any inertial unit.
PLAIN_NAMES = {
    *("Fixed", "Free", "Off", "On", "Reset"),
    *("bend_angle", "wheel_angle", "wheel_load", "wheel_velocity"),
    *("acc_x", "acc_y", "acc_z", "mag_x", "mag_y", "mag_z"),
}

# The name of this software: its package, its two commands, its errors, its environment variables.
OUR_NAME = re.compile(
    r"""\bpirate[_-]sm\b|\bPIRATE_SM_[A-Z]+\b|\bpirate-run\b|\bPirateError\b|\bpirate (?=[a-z])"""
    r"""|\bpirate:(?=\[| allow|")|\bpirate\.toml\b"""
)
OUR_COMMAND = re.compile(r"""["'`]pirate["'`]|\bpirate (?=\{hint\})""")


@cache
def parsed(text: str) -> ast.Module:
    return ast.parse(text)


def _names(node: object) -> Iterator[str]:
    """Every name that the YAML below `node` gives to something."""
    if isinstance(node, list):
        for item in node:
            yield from _names(item)
    elif isinstance(node, dict):
        for key, value in node.items():
            if key in NAMING_KEYS and isinstance(value, str):
                yield value
            if key in NAMING_SECTIONS and isinstance(value, dict):
                yield from value
            yield from _names(value)


@cache  # a few thousand words occur half a million times
def _parts(name: str) -> tuple[str, ...]:
    """The words of a name in any spelling: ClampFront, clamp_front and CLAMP_FRONT are the same."""
    return tuple(re.findall(r"[a-z]+|\d+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()))


def _shipped_names() -> set[str]:
    """The names that only the shipped robot's files may use.

    A name of one lower-case word (`speed`, `joint`) is a word before it is a name.
    """
    names: set[str] = set()
    for file in sorted(SHIPPED_ROBOT.rglob("*.yaml")):
        # BaseLoader leaves every scalar a string: `Off` stays a name.
        document = yaml.load(file.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
        names.update(name.rpartition(".")[2] for name in _names(document))
    return {name for name in names - PLAIN_NAMES if len(_parts(name)) > 1 or name[0].isupper()}


def _foreign_words(text: str, names: set[str]) -> list[str]:
    """Each `line: word` of `text` that is one of `names`, or holds a compound one."""
    compounds = {parts for name in names if len(parts := _parts(name)) > 1}

    def is_foreign(word: str) -> bool:
        parts = _parts(word)
        spans = {parts[i:j] for j in range(len(parts) + 1) for i in range(j)}
        return word in names or bool(spans & compounds)

    foreign = {word for word in set(_WORD.findall(text)) if is_foreign(word)}
    return [
        f"{number}: {word}"
        for number, line in enumerate(text.splitlines() if foreign else (), 1)
        for word in _WORD.findall(line)
        if word in foreign
    ]


@pytest.fixture(scope="module")
def shipped_names() -> set[str]:
    return _shipped_names()


def test_the_shipped_robot_gives_the_names_that_this_module_looks_for(
    shipped_names: set[str],
) -> None:
    assert {"ClampFront", "BendingState", "DoubleClamped", "AlignedRight"} <= shipped_names


def test_a_compound_name_is_found_in_every_spelling() -> None:
    text = "on_clamp_front = CLAMP_FRONT\nx = 'ClampFront'\nclamp(front)"

    assert _foreign_words(text, {"ClampFront"}) == [
        "1: on_clamp_front",
        "1: CLAMP_FRONT",
        "2: ClampFront",
    ]


def test_no_source_file_names_anything_of_the_shipped_robot(shipped_names: set[str]) -> None:
    texts = TEXTS | FIRMWARE
    found = {name: _foreign_words(text, shipped_names) for name, text in texts.items()}

    assert {name: words for name, words in found.items() if words} == {}


def test_pirate_is_the_name_of_this_software_only() -> None:
    others = []
    for name, text in (TEXTS | FIRMWARE).items():
        rest = OUR_NAME.sub("", text)
        if name.startswith("cli/"):
            rest = OUR_COMMAND.sub("", rest)
        others += [f"{name}: {line}" for line in rest.splitlines() if "pirate" in line.lower()]

    assert others == []


# The same idea in two forms: as a file has it, and as the program computes with it.
_ONE_IDEA = {"Elbow", "Mitre", "Reducer", "Straight"}


def test_a_class_name_stands_for_one_idea() -> None:
    heads = re.compile(r"^ *class ([A-Za-z]\w*)[:(\[]", re.MULTILINE)
    counts = Counter(name for text in TEXTS.values() for name in heads.findall(text))

    assert {name for name, count in counts.items() if count > 1} == _ONE_IDEA


def test_the_core_hands_out_what_is_used_outside_and_nothing_else() -> None:
    handed, _ = _handed_out()

    assert handed - _used_outside() == HANDED_OUT_FOR_RECIPES


def test_the_border_of_the_core_only_becomes_narrower() -> None:
    _, inner = _handed_out()
    modules = {f"pirate_sm.core.{file.stem}" for file in (PACKAGE / "core").glob("[!_]*.py")}
    sources = modules | inner
    names = {each for each in _used_outside() - sources if each.rpartition(".")[0] in sources}

    found = {"names": len(names), "modules": len(modules)}
    assert found == CORE_HANDS_OUT, "fewer: lower the number; more: decision 121"


def _handed_out() -> tuple[set[str], set[str]]:
    """What modules of the core hand out of its private parts, and which of that are modules."""
    handed, modules = set(), set()
    for name, text in TEXTS.items():
        if name.startswith("core/") and "# mypy: implicit-reexport" in text:
            imports = (each for each in parsed(text).body if isinstance(each, ast.ImportFrom))
            for node in imports:
                if node.module in (None, "__future__"):
                    continue
                folder = PACKAGE.parent / str(node.module).replace(".", "/")
                for each in node.names:
                    handed.add(found := f"pirate_sm.core.{Path(name).stem}.{each.name}")
                    if (folder / f"{each.name}.py").exists():
                        modules.add(found)
    return handed, modules


@cache
def _used_outside() -> set[str]:
    """The names of the core that the other rooms use."""
    trees = (parsed(text) for name, text in TEXTS.items() if not name.startswith("core/"))
    return {each for tree in trees for each in _used(tree) if each.startswith("pirate_sm.core.")}


def _used(tree: ast.Module) -> set[str]:
    """The names that a file imports, and those that it uses by the modules that it imports."""
    used, modules = set(), {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            used |= {f"{node.module}.{each.name}" for each in node.names}
            modules |= {
                each.asname or each.name: f"{node.module}.{each.name}" for each in node.names
            }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            used.add(f"{modules.get(node.value.id)}.{node.attr}")
    return used


def test_files_and_functions_stay_small() -> None:
    too_long = {}
    for name, text in TEXTS.items():
        longest_body = LONGER_FOR_A_REASON.get(name, LONGEST_FUNCTION)
        if (lines := len(text.splitlines())) > LONGEST_FILE:
            too_long[name] = lines
        bodies = ((f"{name}:{function}", lines) for function, lines in _bodies(parsed(text)))
        too_long |= {part: lines for part, lines in bodies if lines > longest_body}

    assert too_long == {}


def test_long_files_only_become_fewer() -> None:
    long = [name for name, text in TEXTS.items() if len(text.splitlines()) > LONG_FILE]

    assert len(long) == MOST_LONG_FILES, "fewer: lower the number; more: divide one by its ideas"


def _bodies(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Each function with the lines of its body; a long signature or docstring does not count."""
    for node in _statements(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            documented = ast.get_docstring(node) is not None and len(node.body) > 1
            first = node.body[1 if documented else 0]
            yield node.name, (node.end_lineno or first.lineno) - first.lineno + 1


def _statements(block: ast.AST) -> Iterator[ast.stmt]:
    """Each statement in a block and in the blocks within it, without their expressions."""
    for branch in ("body", "orelse", "finalbody", "handlers", "cases"):
        for inner in getattr(block, branch, ()):
            if isinstance(inner, ast.stmt):
                yield inner
            yield from _statements(inner)

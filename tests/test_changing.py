"""The recipes of docs/changing.md work as they are written: each is followed in a scratch copy."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from followed_page import Command, Edit, apply, steps

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "docs" / "changing.md", ROOT / "docs" / "architecture.md"]
COMPILED = "pirate_sm/simulation/kinematic"
COPIED = (
    "pirate_sm",
    "benchmarks",
    "tests",
    "docs",
    "hardware_profiles",
    "panels",
    "sequences",
    "schemas",
)

NAMED = re.compile(
    r"(?<![\w./:-])(?:[\w-]+/)+[\w-]+\.(?:py|md|css|html|json|yaml)(?![\w./])"
    r"|(?<=`)(?:[\w-]+/)+(?=`)"
)
"""A file in a folder, or a folder, from the root of the project, of its package or of the docs."""

PROGRAMS = {
    "pirate": ("-c", "from pirate_sm.cli.start import main; main()"),
    "pirate-run": ("-c", "from pirate_sm.cli.start import run_main; run_main()"),
    "python": (),
}


class Recipe(NamedTuple):
    """The blocks of one section."""

    edits: list[Edit]
    commands: list[Command]


def recipes() -> dict[str, Recipe]:
    sections = re.split(r"^## ", PAGES[0].read_text("utf-8"), flags=re.MULTILINE)[1:]
    return {
        title: recipe
        for section in sections
        for title, _, text in [section.partition("\n")]
        if (recipe := read(text)).edits
    }


def read(text: str) -> Recipe:
    found = steps(text)
    return Recipe(
        [each for each in found if isinstance(each, Edit)],
        [each for each in found if isinstance(each, Command)],
    )


def run(line: str, folder: Path, project: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command in a folder, with the package of the project, by default that in it."""
    source = str(project or folder)
    program, *arguments = shlex.split(line)
    start = PROGRAMS.get(program)
    return subprocess.run(
        [program, *arguments] if start is None else [sys.executable, *start, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": source, "PIRATE_SM_RUNS": "", "COLUMNS": "100"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )


def copied(folder: Path) -> Path:
    """Return a copy of the project, with a link where a copy would have to be compiled anew."""
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy2(ROOT / "pyproject.toml", folder)
    shutil.rmtree(folder / COMPILED)
    (folder / COMPILED).symlink_to(ROOT / COMPILED)
    return folder


@pytest.mark.thorough
@pytest.mark.parametrize("name", recipes())
def test_a_recipe_works_as_it_is_written(name: str, tmp_path: Path) -> None:
    recipe, folder = recipes()[name], copied(tmp_path)

    for edit in recipe.edits:
        apply(edit, folder)
    for command in recipe.commands:
        result = run(command.line, folder)
        assert result.returncode == command.exits, f"{command.line}\n{result.stdout}"
        printed = re.sub(r"\s+", " ", result.stdout)
        assert [line for line in command.prints if " ".join(line.split()) not in printed] == [], (
            printed
        )


@pytest.fixture(scope="module")
def changed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy in which all recipes have been followed."""
    folder = copied(tmp_path_factory.mktemp("all"))
    for recipe in recipes().values():
        for edit in recipe.edits:
            apply(edit, folder)
    return folder


def test_all_recipes_together_pass_the_linter(changed: Path) -> None:
    edits = [edit for recipe in recipes().values() for edit in recipe.edits]
    files = " ".join({edit.file for edit in edits if edit.file.endswith(".py")})
    result = run(f"python -m ruff check --no-cache --fix {files}", changed)

    assert result.returncode == 0, result.stdout


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_all_recipes_together_pass_the_type_checker(changed: Path) -> None:
    result = run(f"python -m mypy --cache-dir={changed / 'types'}", changed)

    assert result.returncode == 0, result.stdout


def test_there_is_a_recipe_for_each_everyday_change() -> None:
    assert len(recipes()) == 17


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_path_that_the_page_names_is_there(page: Path) -> None:
    edits = [edit for recipe in recipes().values() for edit in recipe.edits]
    made = {ROOT / edit.file for edit in edits if edit.how == "New file"}
    folders = (ROOT, ROOT / "pirate_sm", ROOT / "docs")
    wrong = [
        path
        for path in sorted(set(NAMED.findall(page.read_text("utf-8"))))
        if not any((folder / path).exists() or folder / path in made for folder in folders)
    ]

    assert wrong == []

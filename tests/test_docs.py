"""What the documents refer to is there."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import pirate_sm
from pirate_sm.cli import start
from website.built_site import near

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
HELP = Path(start.HELP_FOLDER)
_LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
_CODE = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_link_leads_somewhere(page):
    links = _LINK.findall(_CODE.sub("", page.read_text("utf-8")))
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_the_links_of_the_pages_alone_lead_from_the_tutorial_to_every_page():
    """Viewers of repositories show no navigation, and a folder as a list of its files."""
    leads = {
        str(page): {
            str((page.parent / link).resolve())
            for link in _LINK.findall(_CODE.sub("", page.read_text("utf-8")))
        }
        for page in PAGES
    }
    folders = {link for links in leads.values() for link in links if Path(link).is_dir()}
    leads |= {folder: {str(page) for page in Path(folder).glob("*.md")} for folder in folders}

    found = near(leads, str(ROOT / "docs" / "tutorial" / "index.md"))

    docs = {str(page) for page in PAGES if page.is_relative_to(ROOT / "docs")}
    assert sorted(docs - found) == []


def test_the_readme_fits_on_two_screens():
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 100


@pytest.mark.parametrize(
    ("page", "least"),
    [pytest.param("python.md", 15, marks=pytest.mark.thorough), ("learning.md", 7)],
)
def test_the_examples_in_python_run_as_they_are_written(monkeypatch, page, least):
    monkeypatch.chdir(ROOT)
    # A fence is no expected output.
    text = re.sub(r"^```.*$", "", (ROOT / "docs" / page).read_text("utf-8"), flags=re.M)
    test = doctest.DocTestParser().get_doctest(text, {}, page, f"docs/{page}", 0)
    told: list[str] = []

    result = doctest.DocTestRunner(verbose=False).run(test, out=told.append)

    assert result.attempted >= least
    assert result.failed == 0, "".join(told)


def first_cells(heading: str) -> set[str]:
    """The names in code in the first column of the table below a heading of python.md."""
    section = (ROOT / "docs" / "python.md").read_text("utf-8").split(f"## {heading}\n")[1]
    rows = re.findall(r"^\| (`.*?) \|", section.partition("\n## ")[0], re.MULTILINE)
    return {name for row in rows for name in re.findall(r"`(\w+)", row)}


def test_the_page_on_python_has_every_exception_that_can_leave_the_api():
    exported = {
        name
        for name in pirate_sm.__all__
        if isinstance(each := getattr(pirate_sm, name), type) and issubclass(each, Exception)
    }

    assert first_cells("Errors") == exported - {"PirateError"}
    assert "PirateError" in exported


def test_every_error_of_the_package_is_one_that_is_exported():
    for module in pkgutil.walk_packages(pirate_sm.__path__, "pirate_sm."):
        if module.name.split(".")[1] not in {"cli", "testing"}:
            importlib.import_module(module.name)
    below = [pirate_sm.PirateError]
    for each in below:
        below += each.__subclasses__()
    documented = tuple(getattr(pirate_sm, name) for name in first_cells("Errors"))

    of_commands = {"pirate_sm.views.drawing.graph.graph"}  # the API draws nothing
    others = [each for each in below[1:] if not issubclass(each, documented)]
    assert {each.__module__ for each in others} <= of_commands


def test_the_page_on_python_has_every_member_of_a_session():
    session = pirate_sm.session("mitre_bend", "trace")

    members = {name for name in {*dir(pirate_sm.Session), *vars(session)} if name[0] != "_"}
    assert first_cells("Step by step") == members


def test_the_page_on_python_has_every_member_of_a_batch():
    batch = pirate_sm.batch("mitre_bend", seeds=[1])

    members = {name for name in {*dir(batch), *vars(batch)} if name[0] != "_"}
    assert first_cells("Many robots in parallel") == members


def command_lines() -> Iterator[tuple[str, str]]:
    """Yield each line of a page that is a command of this program, in a block or in a line."""
    for page in PAGES:
        text = page.read_text("utf-8")
        lines = re.findall(r"^ *(?:\$ )?((?:pirate-run|pirate) .*)$", text, re.MULTILINE)
        lines += re.findall(r"`((?:pirate-run|pirate) [^`]*)`", text)
        for line in dict.fromkeys(lines):
            yield page.name, " ".join(line.split())


def test_every_command_line_is_one_that_the_program_takes() -> None:
    """Options and commands exist; values such as NAME or RUN.mcap are the reader's."""
    wrong = []
    for page, line in command_lines():
        program, *words = re.split(r" # |[;…]| [|&>]|:$", line)[0].split()
        names = [program]
        while words and words[0].isalpha() and words[0].islower():
            below = ".".join([*names, words[0]])
            if not (HELP / f"{below}.txt").exists():
                break
            names.append(words.pop(0))
        text = (HELP / f"{'.'.join(names)}.txt").read_text("utf-8")
        if names == ["pirate"] and words and words[0][0].islower():
            wrong.append(f"{page}: {line}: no such command")
        for option in (re.match(r"--?[a-z][a-z0-9-]*", word) for word in words):
            if option and not re.search(rf"(?<![\w-]){option[0]}(?![\w-])", text):
                wrong.append(f"{page}: {line}: no option {option[0]}")

    assert wrong == []

"""Nothing is said of what is shipped, nor of sensible changes to it, nor of what the docs show."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml
from representative import MISSIONS, thorough_but

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.core import library

from .odd import Odd, odd_missions
from .seeding import HERE, ROOT, copied, put

SHIPPED = {path.stem: path for path in library.missions()}
NAMES = thorough_but(MISSIONS, SHIPPED)
FEW = thorough_but({"mitre_bend", "take_branch", "level"}, SHIPPED)
HARMLESS = ("{log: Here}", "{command: ToggleLighting, if: detector == close}")
ROBOT = re.compile(r"^robot: pirate_ii\w*\n", re.MULTILINE)
START = re.compile(r"^(start: \{.*?m)(?:, roll: (-?[\d.]+) deg)?\}", re.MULTILINE)
TURNS = re.compile(r"^  - \{mitre: (-?)", re.MULTILINE)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the shipped missions and pipes, as a project of its own."""
    shutil.copytree(ROOT / "sequences", tmp_path / "sequences")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "sequences"


def shown(path: str, wishes: Wishes | None = None) -> list[str]:
    return [f"{e.place} {e.code}: {e.message}" for e in check_paths([path], wishes).open]


def mirror(folder: Path, name: str) -> None:
    """The mission is of the other polarity, and so is every one that says its own."""
    for file in folder.glob("*.yaml"):
        text = file.read_text("utf-8")
        if "\npolarity: mirrored\n" in text:
            file.write_text(text.replace("\npolarity: mirrored\n", "\npolarity: normal\n"), "utf-8")
        elif file.stem == name:
            file.write_text(ROBOT.sub(r"\g<0>polarity: mirrored\n", text), "utf-8")


def turned_over(text: str) -> str:
    """A round pipe in which the robot starts half a turn round."""
    at, roll = START.search(text).groups()
    over = 180 if roll is None else float(roll) - math.copysign(180, float(roll))
    return START.sub(f"{at}, roll: {over:g} deg}}", text)


def test_examples_and_the_second_robot_are_clean(monkeypatch: pytest.MonkeyPatch) -> None:
    """``test_check.py`` says the same of all that is shipped."""
    monkeypatch.chdir(ROOT)

    for path in ("docs/examples", "tests/robots/newt"):
        assert shown(path) == []


@pytest.mark.parametrize("name", FEW)
def test_a_mission_in_the_other_polarity_fits_a_pipe_to_the_other_side(
    name: str, here: Path
) -> None:
    mirror(here, name)
    for pipe in (here / "pipes").glob("*.yaml"):
        if "\nsection: round\n" in pipe.read_text("utf-8"):
            pipe.write_text(turned_over(pipe.read_text("utf-8")), "utf-8")
            continue
        text = TURNS.sub(lambda m: "  - {mitre: " + ("" if m[1] else "-"), pipe.read_text("utf-8"))
        pipe.write_text(re.sub("^uphill: ", "uphill: -", text, flags=re.MULTILINE), "utf-8")

    assert shown(f"sequences/{name}.yaml") == []


@pytest.mark.thorough
@pytest.mark.parametrize("diameter", thorough_but({"95 mm"}, ["95 mm", "113 mm", "121 mm"]))
def test_missions_fit_other_pipes_of_their_kind(diameter: str, here: Path) -> None:
    for file in (here / "pipes").glob("*.yaml"):
        if "diameter: 120 mm" in file.read_text("utf-8"):
            put(file, {"diameter: 120 mm": f"diameter: {diameter}"})

    assert shown("sequences") == []


@pytest.mark.parametrize("limit", thorough_but(["max"], ["min", "max"]))
@pytest.mark.parametrize("name", FEW)
def test_parameters_may_have_any_value_within_their_limits(name: str, limit: str) -> None:
    parameters = yaml.safe_load(SHIPPED[name].read_text("utf-8")).get("parameters", {})
    settings = {key: str(each[limit]) for key, each in parameters.items() if limit in each}

    found = shown(str(SHIPPED[name]), Wishes(settings=settings))
    reasons = "the pipe is", "of the route before"
    beyond = [e for e in found if limit == "max" and any(each in e for each in reasons)]
    assert found == beyond  # a way may be longer than the pipe that the mission names


@pytest.mark.thorough
@pytest.mark.parametrize("step", HARMLESS)
@pytest.mark.parametrize("name", NAMES)
def test_steps_that_change_nothing_may_stand_anywhere(name: str, step: str, here: Path) -> None:
    file = here / f"{name}.yaml"
    lines = file.read_text("utf-8").splitlines(keepends=True)
    file.write_text("".join(_with(step, line) for line in lines), encoding="utf-8")

    assert shown(str(file)) == []


def _with(step: str, line: str) -> str:
    """The line, with the step as the first of those that begin in it."""
    block = re.match(r"( +)do:\n$", line)
    if block:
        return f"{line}{block[1]}  - {step}\n"
    return re.sub(r"\bdo: \[(?!\])", f"do: [{step}, ", line)


@pytest.mark.parametrize("odd", list(odd_missions()), ids=lambda odd: odd.name)
def test_nothing_is_said_of_odd_missions_that_are_right(odd: Odd, here: Path) -> None:
    (here.parent / "newt").mkdir()
    copied("newt", here.parent / "newt")
    for name, text in {"odd.yaml": odd.text, **odd.beside}.items():
        (here / name).write_text(text, encoding="utf-8")

    assert shown("sequences/odd.yaml") == []


def test_there_are_sixty_odd_missions_of_different_names() -> None:
    assert len({odd.name for odd in odd_missions()}) >= 60


@pytest.mark.thorough
def test_bases_of_the_corpus_are_clean_in_one_project(here: Path) -> None:
    for base in sorted(path.name for path in (HERE / "bases").iterdir()):
        (here / base).mkdir()
        copied(base, here / base)
    (here / "newt").mkdir()
    copied("newt", here / "newt")

    assert shown("sequences") == []


def snippets() -> Iterator[tuple[str, str]]:
    """Every whole mission, pipe and robot that a page of the docs shows.

    Files of the tutorial and of the guides need each other, or are wrong on purpose. They are
    checked where they are followed.
    """
    followed = ("how-to", "tutorial")
    pages = [page for page in (ROOT / "docs").rglob("*.md") if page.parent.name not in followed]
    for page in [*sorted(pages), ROOT / "README.md"]:
        text = page.read_text("utf-8")
        for number, match in enumerate(re.finditer(r"^```yaml\n(.*?)^```", text, re.S | re.M)):
            if (
                re.search(r"^(phases|segments|runs|boards):", match[1], re.M)
                and "…" not in match[1]
            ):
                yield f"{page.name}-{number}", match[1]


@pytest.mark.parametrize(("name", "text"), list(snippets()))
def test_what_the_docs_show_is_clean(name: str, text: str, here: Path) -> None:
    (here / f"{name}.yaml").write_text(text, encoding="utf-8")

    assert shown(f"sequences/{name}.yaml") == []


def test_the_docs_show_missions() -> None:
    assert list(snippets())

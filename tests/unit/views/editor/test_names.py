"""Names lead to where they are declared and used, across files; `¦` marks where the editor asks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .client import Client, served
from .test_completions import DRIVE, ROOT, place

CALLER = """format: 1
mission: caller
robot: pirate_ii
pipe: straight_113
on_failure: lost
start: there
phases:
  there: {do: [{call: drive, with: {way: 60 mm}, on_failure: lost}], go: done}
ends:
  done: {succeed: Done}
  lost: {fail: Lost}
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("project")
    (folder / "sequences").mkdir()
    (folder / "sequences" / "drive.yaml").write_text(DRIVE)
    (folder / "sequences" / "caller.yaml").write_text(CALLER)
    return folder


@pytest.fixture(scope="module")
def client(project: Path) -> Iterator[Client]:
    with served() as client:
        client.begin(project)
        yield client


def asked(client: Client, what: str, path: Path, text: str, **more: Any) -> Any:
    plain, position = place(text)
    client.put(path, plain)
    return client.about(what, path, position=position, **more)


def lines(found: Any, path: Path, text: str) -> list[str]:
    """The lines of a file that places are on."""
    rows = [each["range"]["start"]["line"] for each in found if each["uri"] == path.as_uri()]
    return [text.replace("¦", "").splitlines()[row].strip() for row in rows]


@pytest.mark.parametrize(
    ("old", "new", "due"),
    [
        ("go: halt", "go: ha¦lt", "halt: {do: [Brake], go: arrived}"),
        ("go: gave_up", "go: ¦gave_up", 'gave_up: {fail: "Holding, both parts clamped'),
        (">= $way", ">= $w¦ay", "way: {type: length"),
        ("  halt: {do", "  h¦alt: {do", "halt: {do: [Brake]"),
    ],
)
def test_a_name_leads_to_its_declaration(
    client: Client, project: Path, old: str, new: str, due: str
) -> None:
    path, text = project / "sequences" / "drive.yaml", DRIVE.replace(old, new, 1)

    found = asked(client, "definition", path, text)

    assert lines([found], path, text)[0].startswith(due)


@pytest.mark.parametrize(
    ("word", "file"),
    [
        ("robot: pira¦te_ii", "hardware_profiles/pirate_ii/profile.yaml"),
        ("pipe: ¦straight_113", "sequences/pipes/straight_113.yaml"),
        ("do: [Br¦ake]", "hardware_profiles/pirate_ii/"),
        ("change(odo¦metry)", "hardware_profiles/pirate_ii/profile.yaml"),
    ],
)
def test_names_of_files_and_of_the_robot_lead_into_other_files(
    client: Client, project: Path, word: str, file: str
) -> None:
    path = project / "sequences" / "drive.yaml"

    found = asked(client, "definition", path, DRIVE.replace(word.replace("¦", ""), word, 1))

    assert found["uri"].startswith((ROOT / file).as_uri())


def test_words_that_are_no_names_lead_nowhere(client: Client, project: Path) -> None:
    path = project / "sequences" / "drive.yaml"

    for word in ("description: Dri¦ve", "phases:¦", "time_limit: 5¦ min"):
        text = DRIVE.replace(word.replace("¦", ""), word, 1)
        assert asked(client, "definition", path, text) is None, word
        assert asked(client, "rename", path, text, newName="other") is None


def test_uses_are_found_in_all_missions(client: Client, project: Path) -> None:
    path, caller = project / "sequences" / "drive.yaml", project / "sequences" / "caller.yaml"
    text = DRIVE.replace("  way: {", "  wa¦y: {", 1)
    context = {"includeDeclaration": True}

    found = asked(client, "references", path, text, context=context)

    assert [each.partition(":")[0] for each in lines(found, path, text)] == [
        "way",
        "wait",
        "arrived",
    ]
    assert [each.partition(":")[0] for each in lines(found, caller, CALLER)] == ["there"]


def test_a_name_gets_another_spelling_everywhere_or_nowhere(client: Client, project: Path) -> None:
    path, caller = project / "sequences" / "drive.yaml", project / "sequences" / "caller.yaml"
    text = DRIVE.replace(">= $way", ">= $wa¦y", 1)

    changes = asked(client, "rename", path, text, newName="length")["changes"]
    taken = asked(client, "rename", path, text, newName="give_up")
    faulty = asked(client, "rename", path, text, newName="2 way")

    assert {uri: len(edits) for uri, edits in changes.items()} == {
        path.as_uri(): 3,
        caller.as_uri(): 1,
    }
    assert {edit["newText"] for edits in changes.values() for edit in edits} == {"length"}
    assert taken is None
    assert faulty is None

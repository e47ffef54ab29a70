"""Changes of a mission that an editor offers although no finding asks for them."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from .client import Client, Json, served
from .test_language_server import CALLER, DRIVE, applied

CREATES = {"workspace": {"workspaceEdit": {"resourceOperations": ["create"]}}}


def actions(client: Client, path: Path, first: int, last: int) -> list[Json]:
    span = {"start": {"line": first, "character": 0}, "end": {"line": last, "character": 0}}
    found = client.about("codeAction", path, range=span, context={"diagnostics": []})
    return [each for each in found if "Extract" in each["title"] or "within" in each["title"]]


def line_of(text: str, words: str) -> int:
    return text[: text.index(words)].count("\n")


BLOCK = "    within: {time: $give_up, go: regrip}\n"
STEP = "      - wait: [{when: detector == close}]\n"
SHORT = "  rest: {wait: [{when: detector == close, go: halt}]}\n"


@pytest.mark.parametrize(
    ("text", "due"),
    [
        (DRIVE.replace(BLOCK, ""), "    within: {time: 60 s, go: regrip}\n"),
        (
            DRIVE.replace("      - DriveForward\n", f"      - DriveForward\n{STEP}"),
            "        within: {time: 60 s}\n",
        ),
        (
            DRIVE.replace("  regrip:\n", f"{SHORT}  regrip:\n", 1).replace(
                "on_failure: regrip\n", ""
            ),
            "go: halt}], within: {time: 60 s, go: gave_up}}\n",
        ),
    ],
    ids=["phase", "step", "in braces"],
)
def test_a_missing_limit_is_added(text: str, due: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        before = client.write(path, text)
        action, *others = actions(client, path, 0, text.count("\n"))
        changed = applied(path, text, action)

        assert all(each["title"].startswith("Extract ") for each in others)
        assert any("needs `within" in each["message"] for each in before)
        assert due in changed
        assert not any("within" in each["message"] for each in client.write(path, changed))
        after = actions(client, path, 0, changed.count("\n"))
        assert all(each["title"].startswith("Extract ") for each in after)


def test_no_limit_is_offered_where_none_is_missing_or_elsewhere(tmp_path: Path) -> None:
    path, text = tmp_path / "drive.yaml", DRIVE.replace(BLOCK, "")
    with served() as client:
        client.begin(tmp_path)
        client.put(path, text)
        assert actions(client, path, 0, 1) == []
        client.put(path, text.replace("wait: [{", "wait: [{after: 5 s, go: halt}, {"))
        assert not any("within" in each["title"] for each in actions(client, path, 0, 40))


@pytest.mark.parametrize("creates", [True, False], ids=["creates files", "changes only"])
def test_phases_are_extracted_into_a_new_file(creates: bool, tmp_path: Path) -> None:
    path, new = tmp_path / "drive.yaml", tmp_path / "drive_drive.yaml"
    with served() as client:
        client.begin(tmp_path, CREATES if creates else {})
        before = client.write(path, DRIVE)
        first = line_of(DRIVE, "  drive:")
        (action,) = actions(client, path, first, line_of(DRIVE, "  halt:"))
        client.answers["workspace/applyEdit"] = {"applied": True}
        client.ask("workspace/executeCommand", action["command"])
        edit = client.message("workspace/applyEdit")["edit"]
        if creates:
            made, called, caller = edit["documentChanges"]
            assert made == {"kind": "create", "uri": new.as_uri()}
            texts = {each["textDocument"]["uri"]: each["edits"] for each in (called, caller)}
        else:
            texts = edit["changes"]
        (called,), (caller,) = texts[new.as_uri()], texts[path.as_uri()]

        assert yaml.safe_load(called["newText"])["mission"] == "drive_drive"
        assert client.write(new, called["newText"]) == []
        assert client.write(path, caller["newText"]) == before == []


def test_phases_that_cannot_be_extracted_stay_and_the_reason_is_said(tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        client.put(path, DRIVE)
        (action,) = actions(client, path, line_of(DRIVE, "  regrip:"), line_of(DRIVE, "ends:"))
        client.ask("workspace/executeCommand", action["command"])
        said = client.message("window/showMessage")["message"]
        client.ask("workspace/executeCommand", {"command": "pirate_sm.extract", "arguments": ["x"]})
        other = client.message("window/showMessage")["message"]

    assert said == (
        "These phases stay where they are: all failures of this mission lead to 'regrip', "
        "which must stay in it"
    )
    assert other == "Select the phases, then choose this again"


def test_nothing_is_offered_in_a_text_that_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        for text in (
            CALLER[:-3] + "{[",
            "mission: x\nphases: 3\n",
            "mission: [x]\nphases: {a: {wait: 3}}\n",
            "",
        ):
            client.put(path, text)
            assert not [each for each in actions(client, path, 0, 20) if "Extract" in each["title"]]

"""The language server as an editor meets it: it never blocks, and shows nothing of an old text."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from pirate_sm.checking.exploring.explore import explore_mission
from pirate_sm.checking.mission import check_mission
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission

from .client import Client, Json, checks_as_the_command, served

ROOT = Path(__file__).resolve().parents[4]
DRIVE = (ROOT / "tests" / "mistakes" / "bases" / "drive.yaml").read_text("utf-8")
CALLER = """format: 1
mission: caller
robot: pirate_ii
pipe: straight_113
on_failure: lost
start: there
phases:
  there: {do: [{call: drive, on_failure: lost}], go: done}
ends:
  done: {succeed: Done}
  lost: {fail: Lost}
"""


def codes(found: list[Json]) -> list[str]:
    return [each["code"] for each in found]


def applied(path: Path, text: str, action: Json) -> str:
    """The text after an action of an editor, which counts in units of UTF-16."""
    ((uri, edits),) = action["edit"]["changes"].items()
    assert uri == path.as_uri()
    lines = text.split("\n")

    def index(position: Json) -> int:
        before = lines[position["line"]].encode("utf-16-le")[: 2 * position["character"]]
        above = sum(len(each) + 1 for each in lines[: position["line"]])
        return above + len(before.decode("utf-16-le"))

    for edit in edits:
        start, end = index(edit["range"]["start"]), index(edit["range"]["end"])
        text = text[:start] + edit["newText"] + text[end:]
    return text


def test_a_caller_is_checked_with_the_called_mission_as_it_is_in_the_editor(tmp_path: Path) -> None:
    caller, called = tmp_path / "caller.yaml", tmp_path / "drive.yaml"
    called.write_text(DRIVE)
    with served() as client:
        client.begin(tmp_path)
        before = codes(client.write(caller, CALLER))
        client.write(called, DRIVE.replace("mission: drive", "misson: drive"))

        assert "unknown-key" not in before
        assert "unknown-key" in codes(client.shown[called])
        client.close(called)  # as it is on the disk again
        assert codes(client.settle(caller, 1)) == before


def test_what_is_found_in_an_old_text_is_not_shown_and_questions_are_answered_meanwhile(
    tmp_path: Path,
) -> None:
    began, free = Event(), Event()

    def slowly(paths: list[str]) -> CheckReport:
        began.set()
        assert free.wait(30)
        return checks_as_the_command(paths)

    path = tmp_path / "drive.yaml"
    with served(slowly) as client:
        client.begin(tmp_path)
        client.put(path, DRIVE.replace("start: drive", "start: drift"))
        assert began.wait(30)
        outline = client.about("documentSymbol", path)
        version = client.put(path, DRIVE)
        client.about("foldingRange", path)
        assert client.shown == {}
        free.set()

        assert [each["name"] for each in outline][:2] == ["format", "mission"]
        client.settle(path, version)
        assert client.versions_shown == [version]


def test_why_a_mission_cannot_be_loaded_is_shown_until_it_can_be_and_not_until_it_is_explored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = Event()
    free.set()

    def slowly(loaded: LoadedMission) -> Any:
        assert free.wait(30)
        return explore_mission(loaded)

    monkeypatch.setattr(check_mission, "explore_mission", slowly)
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        shown = client.write(path, DRIVE.replace("start: drive", "start: drift"))
        free.clear()
        version = client.put(path, DRIVE.replace("[Brake]", "[Brake, DriveForward, UnclampFront]"))
        client.settle(path, None)
        early = client.shown[path]
        free.set()

        assert shown
        assert early == []
        assert client.settle(path, version)
        assert client.write(path, DRIVE.replace("[Brake]", "[Brake, DriveForward, RelaxFront]"))
        assert client.versions_shown == [1, None, version, version + 1]


def test_a_change_that_leaves_no_choice_is_an_action_and_all_of_them_are_one(
    tmp_path: Path,
) -> None:
    path = tmp_path / "drive.yaml"
    text = DRIVE.replace("{do: [Brake], go: arrived}", "{do: Brake, go: arrived}  # 🤖")
    text = text.replace('"Driven {way}"', '"🤖🤖 {way}", fial: no')
    with served() as client:
        client.begin(tmp_path)
        found = client.write(path, text)
        (do,) = [each for each in found if "[Brake]" in each["message"] or each["code"] == "type"]
        asked = {"range": do["range"], "context": {"diagnostics": [do]}}
        one, every = client.about("codeAction", path, **asked)
        only = {"diagnostics": [], "only": ["source.fixAll"]}
        alone = client.about("codeAction", path, range=do["range"], context=only)
        client.put(path, text + "\n")
        old = client.about("codeAction", path, **asked)

    assert (one["kind"], one["isPreferred"], one["diagnostics"]) == ("quickfix", True, [do])
    assert "{do: [Brake], go: arrived}  # 🤖" in applied(path, text, one)
    assert alone == [every]
    assert applied(path, text, every) == applied(path, text, one)
    assert old == []


def test_columns_are_counted_as_the_editor_does(tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    text = DRIVE.replace('{succeed: "Driven {way}"}', '{succeed: "🤖🤖 {way}", fial: no}')
    for encoding, wider in (("utf-16", 2), ("utf-8", 6), ("utf-32", 0)):
        with served() as client:
            client.begin(tmp_path, {"general": {"positionEncodings": [encoding]}})
            (found,) = (each for each in client.write(path, text) if each["code"] == "unknown-key")
            line = text.split("\n")[found["range"]["start"]["line"]]

            assert found["range"]["start"]["character"] == line.index("fial") + wider


def test_an_outline_stays_while_the_file_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        client.write(path, DRIVE)
        outline = client.about("documentSymbol", path)
        client.write(path, DRIVE.replace("[Brake]", "[Brake"))

        assert client.about("documentSymbol", path) == outline
        (phases,) = (each for each in outline if each["name"] == "phases")
        assert [each["name"] for each in phases["children"]] == ["drive", "halt", "regrip"]


def test_files_of_no_known_kind_and_an_empty_one_are_left_alone(tmp_path: Path) -> None:
    with served() as client:
        client.begin(tmp_path)

        assert client.write(tmp_path / "other.yaml", "services: {web: {image: nginx}}\n") == []
        assert client.write(tmp_path / "new.yaml", "") == []
        assert client.about("documentSymbol", tmp_path / "new.yaml") == []


def test_an_error_of_the_check_is_said_and_the_next_text_is_checked(tmp_path: Path) -> None:
    failing = iter([UsageError("no such robot"), ValueError("a bug")])

    def fails_twice(paths: list[str]) -> CheckReport:
        for error in failing:
            raise error
        return checks_as_the_command(paths)

    path = tmp_path / "drive.yaml"
    with served(fails_twice) as client:
        client.begin(tmp_path)
        said = []
        for text in (DRIVE, DRIVE + "\n"):
            client.put(path, text)
            said.append(client.message("window/showMessage")["message"])
        found = client.write(path, DRIVE.replace("start: drive", "start: drift"))

    assert said == ["no such robot", "an internal error: ValueError: a bug"]
    assert found


def test_whoever_waits_for_findings_is_told_that_none_will_come(tmp_path: Path) -> None:
    def fails(paths: list[str]) -> CheckReport:
        raise ValueError(f"a bug in {len(paths)} file")

    with served(fails) as client:
        client.begin(tmp_path)
        with pytest.raises(AssertionError, match="ValueError: a bug in 1 file"):
            client.write(tmp_path / "drive.yaml", DRIVE)


@pytest.mark.parametrize("uri", ["file:///tmp/a%00b.yaml", "git:{path}", "untitled:Untitled-1"])
def test_a_document_that_is_no_file_keeps_no_other_from_being_checked(
    uri: str, tmp_path: Path
) -> None:
    path = tmp_path / "drive.yaml"
    with served() as client:
        client.begin(tmp_path)
        before = client.write(path, DRIVE.replace("start: drive", "start: drift"))
        other = {"uri": uri.format(path=path), "version": 1, "text": DRIVE, "languageId": "yaml"}
        client.send("textDocument/didOpen", {"textDocument": other})

        assert before
        assert client.settle(path, 1) == before


def test_an_editor_that_watches_files_is_asked_to(tmp_path: Path) -> None:
    watches = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    caller, called = tmp_path / "caller.yaml", tmp_path / "drive.yaml"
    called.write_text(DRIVE)
    with served() as client:
        client.begin(tmp_path, watches)
        asked = client.message("client/registerCapability")
        before = client.write(caller, CALLER)
        called.unlink()
        client.send("workspace/didChangeWatchedFiles", {"changes": []})
        after = client.settle(caller, 1)

    assert asked["registrations"][0]["method"] == "workspace/didChangeWatchedFiles"
    assert "mission.call" in codes(after)
    assert "mission.call" not in codes(before)


def test_the_command_talks_over_standard_input_and_output(tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    code = "from pirate_sm.cli.start import main; main()"
    line = [sys.executable, "-c", code, "lsp", "--stdio"]
    with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        client = Client(process.stdin, process.stdout)
        client.begin(tmp_path)
        found = client.write(tmp_path / "drive.yaml", DRIVE.replace("go: halt", "go: hallt"))
        client.end()

        assert process.wait(30) == 0
        assert codes(found) == ["mission.name"]

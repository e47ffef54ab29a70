"""An editor can run, rehearse and draw the mission of a file, always in the simulator."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from .client import Client, Json, served

ROOT = Path(__file__).resolve().parents[4]
DRIVE = (ROOT / "tests" / "mistakes" / "bases" / "drive.yaml").read_text("utf-8")
SHOWS = {
    "general": {"positionEncodings": ["utf-16"]},
    "window": {"showDocument": {"support": True}},
}
USES = ["Run in the simulator", "Rehearse", "Show the graph"]


def saved(folder: Path) -> Path:
    path = folder / "drive.yaml"
    path.write_text(DRIVE)
    return path


def lenses(client: Client, path: Path) -> list[Json]:
    return [each["command"] for each in client.about("codeLens", path)]


def execute(client: Client, command: Json) -> None:
    about = {"command": command["command"], "arguments": command["arguments"]}
    client.ask("workspace/executeCommand", about)


def shown_file(client: Client) -> Path:
    return Path(unquote(urlsplit(client.message("window/showDocument")["uri"]).path))


def test_what_can_be_done_stands_above_the_mission_and_is_an_action_there(tmp_path: Path) -> None:
    path, pipe = tmp_path / "drive.yaml", tmp_path / "pipe.yaml"
    with served() as client:
        client.begin(tmp_path)
        client.put(path, DRIVE)
        client.put(
            pipe, "format: 1\npipe: straight\nsegments: [{straight: 1 m, diameter: 113 mm}]\n"
        )
        found = client.about("codeLens", path)
        start = {"line": 1, "character": 3}
        asked = {"range": {"start": start, "end": start}, "context": {"diagnostics": []}}
        actions = client.about("codeAction", path, **asked)

        assert [each["command"]["title"] for each in found] == USES
        assert {each["range"]["start"]["line"] for each in found} == {1}
        assert [each["title"] for each in actions if "command" in each] == USES
        assert lenses(client, pipe) == []


def test_the_graph_of_a_saved_mission_is_shown(tmp_path: Path) -> None:
    path = saved(tmp_path)
    with served() as client:
        client.begin(tmp_path, SHOWS)
        client.put(path, DRIVE)
        execute(client, lenses(client, path)[2])
        drawing = shown_file(client)

        assert "<svg" in drawing.read_text("utf-8")
        assert drawing.parent.parent != tmp_path
    assert not drawing.exists()


def test_a_mission_that_is_not_saved_is_left_alone(tmp_path: Path) -> None:
    path = saved(tmp_path)
    with served() as client:
        client.begin(tmp_path, SHOWS)
        client.put(path, DRIVE + "\n")
        for each in lenses(client, path):
            execute(client, each)
            said = client.message("window/showMessage")["message"]
            assert said == "Not saved: drive.yaml; save, then try again"


@pytest.mark.parametrize("arguments", [[], [3], ["nonsense"], ["file:///nowhere/x.yaml"]])
def test_a_command_without_a_file_says_so(arguments: list[object], tmp_path: Path) -> None:
    with served() as client:
        client.begin(tmp_path)
        client.ask(
            "workspace/executeCommand", {"command": "pirate_sm.graph", "arguments": arguments}
        )
        said = client.message("window/showMessage")["message"]
        assert said == "There is no file of a mission to do this with: save it"


def test_what_runs_can_be_stopped_and_then_all_is_possible_again(tmp_path: Path) -> None:
    path = saved(tmp_path)
    with served() as client:
        client.begin(tmp_path)
        client.put(path, DRIVE)
        run, *_ = lenses(client, path)
        execute(client, run)
        (stop,) = lenses(client, path)
        execute(client, run)
        assert client.message("window/showMessage")["message"].startswith("This mission is in use")
        execute(client, stop)
        said = client.message("window/showMessage")["message"]

        assert said == "Run in the simulator: drive has been stopped"
        assert [each["title"] for each in lenses(client, path)] == USES


def test_the_progress_that_the_editor_shows_can_be_cancelled(tmp_path: Path) -> None:
    path = saved(tmp_path)
    with served() as client:
        client.begin(tmp_path, {"window": {"workDoneProgress": True}})
        client.answers["window/workDoneProgress/create"] = None
        client.put(path, DRIVE)
        execute(client, lenses(client, path)[1])
        token = client.message("window/workDoneProgress/create")["token"]
        assert client.message("$/progress")["value"]["title"] == "Rehearse: drive"
        client.send("window/workDoneProgress/cancel", {"token": token})

        said = client.message("window/showMessage")["message"]
        assert said == "Rehearse: drive has been stopped"
        assert client.message("$/progress")["value"]["kind"] == "end"


def test_a_fault_of_the_mission_is_said(tmp_path: Path) -> None:
    path, text = saved(tmp_path), DRIVE.replace("go: halt", "go: hallt")
    path.write_text(text)
    with served() as client:
        client.begin(tmp_path, SHOWS)
        client.put(path, text)
        execute(client, lenses(client, path)[2])

        assert "hallt" in client.message("window/showMessage")["message"]


@pytest.mark.thorough
def test_a_run_uses_the_simulator_even_where_a_real_robot_is_set(tmp_path: Path) -> None:
    path = saved(tmp_path)
    (tmp_path / "pirate.toml").write_text('backend = "serial"\nport = "/dev/null"\n')
    with served() as client:
        client.begin(tmp_path, SHOWS)
        client.put(path, DRIVE)
        execute(client, lenses(client, path)[0])
        report = shown_file(client)

        assert report.suffix == ".html"
        assert "drive" in report.read_text("utf-8")
        assert "Driven 200 mm" in client.message("window/showMessage")["message"]


@pytest.mark.thorough
def test_a_rehearsal_is_shown_as_a_text(tmp_path: Path) -> None:
    path = saved(tmp_path)
    with served() as client:
        client.begin(tmp_path, SHOWS)
        client.put(path, DRIVE)
        execute(client, lenses(client, path)[1])

        assert "rehearsed in the simulator" in shown_file(client).read_text("utf-8")

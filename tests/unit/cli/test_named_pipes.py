"""No command waits for a named pipe where it reads a file."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest
from typer.testing import Result

from pirate_sm.cli.command_line import COMMANDS, found
from pirate_sm.core.errors import UsageError
from pirate_sm.lab.campaign.store import MARK, Store
from pirate_sm.robot.camera import FileSource, ImagesSource
from pirate_sm.robot.vision.captures import open_capture

READING = [
    "run x.yaml",
    "run --resume x.mcap",
    "run mitre_bend --pipe x.yaml",
    "run mitre_bend --robot robot",
    "run mitre_bend --twin x.yaml",
    "run mitre_bend --fitted x.yaml",
    "run mitre_bend --forecast x.yaml",
    "report x.mcap --forecast x.yaml",
    "forecast x.mcap",
    "forecast x.yaml --rehearse 1",
    "run mitre_bend --backend trace --script x.yaml",
    "run mitre_bend --detector vision:x.yaml",
    "run mitre_bend --panel x.yaml",
    "demo x.yaml",
    "list commands --robot robot",
    "schema mission --robot robot",
    "check x.yaml",
    "check robot",
    "explain clamp --robot robot",
    "diff x.yaml mitre_bend",
    "diff mitre_bend x.yaml",
    "graph x.yaml",
    "graph mitre_bend --counterexample x.yaml",
    "import x.scxml",
    "plan robot --to BendingState=Straight",
    "robot robot",
    "campaign x.yaml",
    "margins x.yaml",
    "coverage x.yaml",
    "coverage x.mcap",
    "console x.mcap",
    "console --resume x.mcap",
    "panel x.yaml",
    "doctor --robot robot",
    "calibrate --robot robot",
    "bay --robot robot",
    "firmware robot",
    "replay x.mcap",
    "compare x.mcap x.mcap",
    "compare results results",
    "export x.mcap --csv out",
    "map x.mcap",
    "fit x.mcap",
    "fit x.csv",
    "fit --robot x.mcap",
    "experiment x.yaml",
    "report x.mcap",
    "page x.mcap",
    "report .",
    "report results",
    "repair x.mcap",
    "camera look x.yaml",
    "camera calibrate x.yaml",
    "camera survey x.yaml",
    "new mission mine --robot robot",
    "new mission mine --pipe x.yaml",
    "new campaign mine --mission x.yaml",
    "new robot mine --like robot",
    "new camera mine --like x.yaml",
    "new panel mine --like x.yaml",
    "config",
]
"""Each command with each kind of file that it reads."""

FILES_OF_NONE = {"completion", "camera print", "new pipe"}


@pytest.fixture
def pipes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which every file is a named pipe that nobody writes to."""
    monkeypatch.chdir(tmp_path)
    for name in (
        "x.yaml",
        "x.mcap",
        "x.csv",
        "x.scxml",
        "robot/profile.yaml",
        f"results/{MARK}",
    ):
        Path(name).parent.mkdir(exist_ok=True)
        os.mkfifo(name)
    return tmp_path


@pytest.mark.timeout(60)
@pytest.mark.parametrize("line", READING)
def test_no_command_waits_for_a_named_pipe(
    pirate: Callable[..., Result], pipes: Path, line: str
) -> None:
    if line == "config":
        os.mkfifo("pirate.toml")
    result = pirate(*line.split())

    assert result.exit_code in {1, 2}, result.output
    assert "Traceback" not in result.output
    assert result.exception is None or isinstance(result.exception, SystemExit)


def test_every_command_that_reads_files_is_here() -> None:
    reading = {name for name, (options, _) in COMMANDS.items() if _reads(options)}

    assert {line.split()[0] for line in READING} | FILES_OF_NONE >= {
        name.split()[0] for name in reading
    }


def _reads(options: str) -> bool:
    declared = (each.metadata["parameter"]() for each in fields(found("options", options)))
    return any(each.autocompletion is not None for each in declared)


def test_results_of_a_campaign_that_are_a_named_pipe_are_damaged(tmp_path: Path) -> None:
    (tmp_path / MARK).write_text("{}", "utf-8")
    (tmp_path / "results").mkdir()
    os.mkfifo(tmp_path / "results" / "0-00000001.parquet")
    store = Store(tmp_path)

    assert [*store.read()] == []
    assert "regular file" in str(store.damaged)


@pytest.mark.parametrize(
    "source",
    [
        FileSource(size=(64, 64), file="seen.avi"),
        ImagesSource(size=(64, 64), images="seen.*"),
    ],
)
def test_a_camera_does_not_wait_for_a_named_pipe(
    tmp_path: Path, source: FileSource | ImagesSource
) -> None:
    pytest.importorskip("cv2")
    os.mkfifo(tmp_path / "seen.avi")

    with pytest.raises(UsageError, match=r"seen\.avi"):
        open_capture(source, tmp_path).read()

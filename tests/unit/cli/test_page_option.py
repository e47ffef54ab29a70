"""`--page`: who has the address acts on the run, and its recording says from where."""

from __future__ import annotations

import json
import re
import subprocess
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from typer.testing import Result

from pirate_sm.core.events import Abort, Pause, Resume
from pirate_sm.running.recording.read.reader import read_recording

Run = Callable[..., Result]
Start = Callable[..., "subprocess.Popen[str]"]


class Course:
    """A run in a process of its own, with its page."""

    def __init__(self, start: Start, kept: Path, *options: str) -> None:
        self.process = start("mitre_bend", "--page", *options, "--json", "--record", kept)
        address = re.search(r"http://\S+", self.until("page: open"))
        assert address is not None
        self.page = urlsplit(address[0])

    def until(self, text: str) -> str:
        """Read up to the line that has this text."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if text in line:
                return line
        raise AssertionError(f"{text} never came: {self.process.communicate()[1]}")

    def press(self, button: str) -> int:
        """Press a button as the page does; returns the status of the answer."""
        server = f"http://{self.page.netloc}"
        headers = {"Origin": server, "Authorization": f"Bearer {self.page.fragment}"}
        request = urllib.request.Request(f"{server}/presses", button.encode(), headers)
        return int(urllib.request.urlopen(request, timeout=60).status)


@pytest.mark.thorough
def test_a_run_is_paused_continued_and_stopped_from_its_page(
    start: Start, pirate: Run, tmp_path: Path
) -> None:
    kept = tmp_path / "run.mcap"
    run = Course(start, kept, "--speed", "realtime")

    run.until('"ClampFront", "status": "accepted"')
    assert run.press("pause") == 204
    run.until("paused: wheels stopped")
    assert run.press("continue") == 204
    run.until("resumed")
    assert run.press("stop") == 204
    end: dict[str, Any] = json.loads(run.until('"type": "end"'))
    run.process.communicate(timeout=60)

    assert (end["outcome"], end["message"]) == ("interrupted", "stopped on the page")
    assert run.process.returncode == 130
    asked = [
        step.event
        for step in read_recording(kept).steps()
        if isinstance(step.event, Pause | Resume | Abort)
    ]
    assert asked == [Pause("page"), Resume("page"), Abort("stopped on the page")]
    assert pirate("replay", kept).exit_code == 0


def test_a_page_of_what_is_not_recorded_is_refused(pirate_run: Run) -> None:
    result = pirate_run("mitre_bend", "--page", "--no-record")
    assert result.exit_code == 2
    assert "--page shows what is recorded, and nothing is" in result.output

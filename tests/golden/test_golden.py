"""The trace of every shipped mission, line by line. `make golden` writes the files anew."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path

import pytest

from pirate_sm.cli.output.event_lines import JsonLines, ObservedRun
from pirate_sm.core import library
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
MISSIONS = [path.stem for path in library.missions()]


def trace(mission: str) -> str:
    """The JSON lines of a trace, without what changes with every comment in a file."""
    prepared = prepare(Order(f"sequences/{mission}.yaml", backend="trace"))
    situation = ObservedRun(prepared)
    out = io.StringIO()
    lines = JsonLines(out, situation)
    companions = [*prepared.companions, FirstChoice()]
    situation.run = MissionRun(
        prepared.engine, prepared.backend, observers=[lines], companions=companions
    )
    lines.begin()
    situation.run.execute()
    first, rest = out.getvalue().split("\n", 1)
    start = json.loads(first)
    del start["files"], start["version"]
    return json.dumps(start, ensure_ascii=False) + "\n" + rest


@pytest.mark.parametrize("mission", MISSIONS)
def test_the_trace_is_as_it_was(mission: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    golden = HERE / f"{mission}.jsonl"
    found = trace(mission)
    if os.environ.get("GOLDEN") == "write":
        golden.write_text(found, encoding="utf-8")

    assert golden.exists(), "there is no golden trace yet: make golden"
    assert found == golden.read_text("utf-8")


def test_every_golden_trace_has_its_mission() -> None:
    assert sorted(path.stem for path in HERE.glob("*.jsonl")) == MISSIONS

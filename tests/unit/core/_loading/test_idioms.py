"""What other languages write otherwise is answered by how it is written here."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.mistakes import HERE
from pirate_sm.checking.check_project import check_paths

STEP = "      - DriveForward"


@pytest.mark.parametrize(
    ("here", "written", "hint"),
    [
        (STEP, "      - {sleep: 2 s}", "expected `wait: [{after: 2 s}]`"),
        (STEP, "      - {wait: 2 s}", "expected `wait: [{after: 2 s}]`"),
        (
            STEP,
            "      - {DriveForward: 20 cm}",
            "expected `DriveForward`, and how far in a wait: `when: change(odometry) >= 20 cm`",
        ),
        (
            STEP,
            "      - ClampRear: {timeout: 8 s, retry: 2}",
            "expected `{command: ClampRear, timeout: 8 s, retry: 2}`",
        ),
        (
            STEP,
            "      - {if: detector == close, then: [Brake]}",
            "expected `choose: [{if: detector == close, do: …}]`",
        ),
        (STEP, "      - {goto: halt}", "expected `go: halt` in the phase, next to its `do`"),
        (STEP, "      - {print: Off it goes}", "log"),
        ("halt: {do: [Brake], go:", "halt: {do: [Brake], next:", "go"),
        ("halt: {do: [Brake]", "halt: {actions: [Brake]", "do"),
        ("    wait: [", "    wait_until: [", "wait"),
        (">= $way", ">= 8 inch", "expected mm: 1 inch is 25.4 mm"),
        (">= $way", ">= 2 feet", "expected mm: 1 feet is 304.8 mm"),
        (
            ">= $way",
            ">= $dist",
            "expected a declared one: `parameters: {dist: {type: …, default: …}}`",
        ),
        ("change(odometry) >= $way", "BendingState is DoubleClamped", "expected `==`"),
        (
            ">= $way",
            ">= 0,2 m",
            "expected a point in numbers, as in 0.2 m: inside { } a comma ends",
        ),
        ("default: 200 mm", "default: 8 in", "203.2 mm"),
        ("default: 200 mm", "default: 0.5 foot", "152.4 mm"),
        ("default: 200 mm", "default: 200000 μm", "200000 um"),
        ("time_limit: 5 min", "time_limit: 2,5 min", "2.5 min"),
        ("time_limit: 5 min", "time_limit: 2,500 s", "expected a number with a unit"),  # thousands?
        ("time_limit: 5 min", "time_limit: 5 foot", "expected a number with a unit"),
        (
            "{fault: wheel.dead, then: continue}",
            "{wheel.dead: continue}",
            "expected `{fault: wheel.dead, then: continue}`",
        ),
    ],
)
def test_an_idiom_of_another_language_is_translated(
    here: str, written: str, hint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = (HERE / "bases" / "drive.yaml").read_text("utf-8")
    assert text.count(here) == 1
    Path("drive.yaml").write_text(text.replace(here, written), "utf-8")

    hints = [each.suggestion or each.fix for each in check_paths(["drive.yaml"]).open]

    assert any(each.startswith(hint) for each in hints), hints

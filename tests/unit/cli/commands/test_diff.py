"""`pirate diff` as somebody calls it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from checking.small_missions import MISSION

from pirate_sm.checking.mission_behaviour import abilities_of

from ..conftest import ROOT

SCHEMA = json.loads((ROOT / "docs" / "schemas" / "diff.schema.json").read_text("utf-8"))


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    text = MISSION
    (tmp_path / "old.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "new.yaml").write_text(
        text.replace("[ClampFront]", "[ClampFront, ClampRear]"), encoding="utf-8"
    )
    return tmp_path


@pytest.mark.thorough
def test_a_mission_is_the_same_as_itself(pirate: Any) -> None:
    result = pirate("diff", "mitre_bend", "mitre_bend")

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.endswith(": both can do the same\n")


def test_what_differs_is_told_by_kind(pirate: Any) -> None:
    result = pirate("diff", "old.yaml", "new.yaml")

    assert (result.exit_code, result.stderr) == (1, "")
    assert result.stdout == (
        "old.yaml → new.yaml: 1 gained, 1 changed\n"
        "\n"
        "gained\n"
        "  ClampRear can be given in 'a'; before, nothing gave it\n"
        "\n"
        "changed\n"
        "  success takes at least 2 commands and 5 events; before 1 command and 3 events\n"
    )


def test_for_programs_it_is_json(pirate: Any) -> None:
    result = pirate("diff", "old.yaml", "new.yaml", "--format", "json")

    whole = json.loads(result.stdout)
    jsonschema.validate(whole, SCHEMA)
    assert (result.exit_code, whole["same"], whole["cut_off"]) == (1, False, [])
    assert whole["changes"][0] == {
        "kind": "gained",
        "about": "command",
        "text": "ClampRear can be given in 'a'; before, nothing gave it",
        "name": "ClampRear",
        "phase": "a",
        "before": "",
        "after": "",
    }


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["old.yaml", "nowhere.yaml"], "nowhere.yaml"),
        (["mitre_bnd", "old.yaml"], "did you mean 'mitre_bend'?"),
        (["old.yaml", "new.yaml", "--set", "x=1"], "parameter"),
        (["old.yaml", "new.yaml", "--robot", "nobody"], "nobody"),
    ],
)
def test_what_cannot_be_used_is_said(pirate: Any, arguments: list[str], words: str) -> None:
    result = pirate("diff", *arguments)

    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr


def test_a_version_with_a_fault_is_not_compared(pirate: Any, here: Path) -> None:
    (here / "new.yaml").write_text(MISSION.replace("ClampFront", "ClampFont"), encoding="utf-8")
    result = pirate("diff", "old.yaml", "new.yaml")

    assert (result.exit_code, result.stdout) == (2, "")
    assert "ClampFont" in result.stderr


def test_too_much_to_look_at_is_no_likeness(pirate: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "pirate_sm.cli.commands.diff.abilities_of",
        lambda loaded: replace(abilities_of(loaded), complete=False),
    )
    result = pirate("diff", "old.yaml", "old.yaml")

    assert (result.exit_code, result.stdout) == (2, "")
    assert "too much can happen" in result.stderr

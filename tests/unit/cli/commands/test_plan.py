from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest

from ..conftest import NEWT, ROOT

SCHEMA = json.loads((ROOT / "docs" / "schemas" / "plan.schema.json").read_text("utf-8"))


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


def test_the_commands_are_printed_with_what_they_change(pirate: Any) -> None:
    result = pirate("plan", "pirate_ii", "--to", "RotationState=AlignedLeft, LightingState=On")

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.splitlines() == [
        "from  FrontWheelsState Free, RearWheelsState Free, BendingState Unclamped,",
        "      RotationState Unaligned, LightingState Off",
        "to    RotationState AlignedLeft, LightingState On",
        "",
        "   command         held by  what changes",
        "1  ToggleLighting  –        LightingState On",
        "2  AlignLeft       –        RotationState AlignedLeft",
        "",
        "2 commands, nominally 12.2 s",
    ]


@pytest.mark.parametrize("begin", [[], ["--from", "Grip=BothHeld"], ["--from", "Crawl=Astern"]])
def test_it_fits_80_columns_and_works_for_any_robot(pirate: Any, begin: list[str]) -> None:
    result = pirate(
        "plan", NEWT, *begin, "--to", "Grip == BothHeld", "--to", "Lamp=Lit,Crawl=Ahead"
    )

    assert result.exit_code == 0
    assert max(map(len, result.stdout.splitlines())) <= 80
    assert "GoAhead" in result.stdout


def test_regions_that_the_start_does_not_name_are_as_on_the_way_there(pirate: Any) -> None:
    result = pirate(
        "plan", "pirate_ii", "--from", "BendingState=DoubleClamped", "--to", "LightingState=Off"
    )

    assert "FrontWheelsState Fixed, RearWheelsState Fixed" in result.stdout
    assert "Nothing to do: the robot is in these states already." in result.stdout
    assert result.exit_code == 0


def test_no_command_that_lets_go_is_proposed(pirate: Any) -> None:
    result = pirate(
        "plan", "pirate_ii", "--from", "BendingState=DoubleClamped", "--to",
        "BendingState=Unclamped",
    )  # fmt: skip

    assert result.exit_code == 1
    assert "None: no safe way leads there; the shortest takes Reset: it lets go" in result.stdout


def test_a_phase_of_a_mission_is_where_it_leads(pirate: Any) -> None:
    result = pirate("plan", "pirate_ii", "--to-phase", "mitre_bend:pass", "--json")

    found = json.loads(result.stdout)
    jsonschema.validate(found, SCHEMA)
    assert found["phase"] == "mitre_bend:pass"
    assert [each["command"] for each in found["commands"]][-2:] == ["BendInto", "DriveForward"]
    assert found["commands"][-1]["held_by"] == ["rear"]


@pytest.mark.parametrize(
    ("target", "code"),
    [("BendingState=DoubleClamped", 0), ("BendingState=DoubleClamped,RearWheelsState=Free", 1)],
)
def test_programs_read_json(pirate: Any, target: str, code: int) -> None:
    result = pirate("plan", "pirate_ii", "--to", target, "--json")

    found = json.loads(result.stdout)
    jsonschema.validate(found, SCHEMA)
    assert result.exit_code == code
    assert found["found"] is (code == 0)
    assert bool(found["reason"]) is (code == 1)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["pirate_3", "--to", "LightingState=On"], "did you mean 'pirate_ii'"),
        (["pirate_ii"], "either --to or --to-phase"),
        (["pirate_ii", "--to", "A=B", "--to-phase", "a:b"], "either --to or --to-phase"),
        (["pirate_ii", "--to", ","], "names no state"),
        (["pirate_ii", "--to", "On"], "expected REGION=STATE"),
        (["pirate_ii", "--to", "LightingState=Onn"], "did you mean 'On'?"),
        (["pirate_ii", "--to", "LightinState=On"], "did you mean 'LightingState'?"),
        (["pirate_ii", "--from", "Bendin=Un", "--to", "LightingState=On"], "no region 'Bendin'"),
        (
            ["pirate_ii", "--from", "BendingState=DoubleClamped,RearWheelsState=Free",
             "--to", "LightingState=On"],
            "--from: no commands ever lead to",
        ),
        (["pirate_ii", "--to-phase", "pass"], "expected MISSION:PHASE"),
        (["pirate_ii", "--to-phase", ":"], "--to-phase ':': expected MISSION:PHASE"),
        (["pirate_ii", "--to-phase", "mitre_bnd:pass"], "did you mean 'mitre_bend'"),
        (["pirate_ii", "--to-phase", "mitre_bend:pss"], "did you mean 'pass'?"),
        ([NEWT, "--to-phase", "mitre_bend:pass"], "is a mission for pirate_ii, not newt"),
    ],
)  # fmt: skip
def test_misuse_is_told_in_a_sentence(pirate: Any, arguments: list[Any], says: str) -> None:
    result = pirate("plan", *arguments)

    assert result.exit_code == 2
    assert says in result.stderr
    assert result.stdout == ""


def test_everything_that_is_misspelt_is_told_at_once(pirate: Any) -> None:
    result = pirate("plan", "pirate_ii", "--to", "LightingState=Onn,BendinState=DoubleClamped")

    assert "did you mean 'On'?" in result.stderr
    assert "did you mean 'BendingState'?" in result.stderr


def test_the_page_shows_what_is_printed(pirate: Any) -> None:
    page = (ROOT / "docs" / "plans.md").read_text("utf-8")
    to = "BendingState=DoubleClamped, RotationState=AlignedRight"
    refused = pirate(
        "plan",
        "pirate_ii",
        "--from",
        "BendingState=DoubleClamped",
        "--to",
        "BendingState=Unclamped",
    )

    assert f"```\n{pirate('plan', 'pirate_ii', '--to', to).stdout}```" in page
    assert refused.stdout.partition("\n\n")[2] in page

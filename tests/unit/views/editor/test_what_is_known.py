"""What an editor says of the words of a mission; a `¦` is where the pointer is."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from benchmarks.editor_client import CAPABILITIES
from pirate_sm.checking.exploring import explore

from .client import Client, Json, served
from .test_completions import DRIVE, place

SNIPPETS = {"completion": {"completionItem": {"snippetSupport": True}}}
EVERYTHING = {
    "start": {"line": 0, "character": 0},
    "end": {"line": 10_000, "character": 0},
}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    with served() as client:
        client.begin(tmp_path_factory.mktemp("project"), {**CAPABILITIES, "textDocument": SNIPPETS})
        client.write(Path.cwd() / "drive.yaml", DRIVE)
        yield client


def hover(client: Client, text: str, name: str = "drive.yaml") -> str:
    path = Path.cwd() / name
    plain, position = place(text)
    client.put(path, plain)
    found = client.about("hover", path, position=position)
    return found["contents"]["value"] if found else ""


SAID = {
    "what moves by a command": ("- DriveForward", "- Drive¦Forward", "DrivingForward | "),
    "the guard of a command": ("- DriveForward", "- Drive¦Forward", "**Needs**"),
    "the usual time of a command": ("- ClampFront", "- Clamp¦Front", "usually"),
    "the unit of a signal": ("change(odometry)", "change(odo¦metry)", "a length"),
    "the range of a signal": ("change(odometry) >= $way", "gam¦ma_1 > 0 deg", "rad"),
    "the truth of a condition": ("change(odometry)", "change(odo¦metry)", "it can become true"),
    "a parameter": ("time: $give_up", "time: $give¦_up", "20 s"),
    "the states of a phase": ("go: halt", "go: ha¦lt", "FrontWheelsState"),
    "the time to a phase": ("go: halt", "go: ha¦lt", " s … "),
    "an end": ("go: arrived", "go: arr¦ived", "Driven {way}"),
    "who raises a fault": (
        "fault: wheel.dead",
        "fault: wheel.¦dead",
        "is driven and does not turn: when `",
    ),
}


@pytest.mark.parametrize("what", SAID)
def test_a_word_is_explained(client: Client, what: str) -> None:
    old, new, due = SAID[what]
    assert DRIVE.count(old)
    path = Path.cwd() / "drive.yaml"
    client.write(path, DRIVE.replace(old, new.replace("¦", ""), 1))

    assert due in hover(client, DRIVE.replace(old, new, 1))


def test_a_file_that_was_never_checked_is_explained_too(client: Client) -> None:
    assert "usually" in hover(client, DRIVE.replace("[Brake]", "[Br¦ake]"), "new.yaml")
    assert hover(client, DRIVE.replace("Drive forward", "Drive for¦ward"), "new.yaml") == ""
    assert hover(client, "services: {we¦b: 1}\n", "other.yaml") == ""


@pytest.mark.parametrize(
    ("condition", "due"),
    [
        ("LightingState == Off or LightingState == On", "true already whenever the wait begins"),
        ("LightingState == On", "it never ends this wait"),
    ],
)
def test_a_condition_that_never_changes_is_said_to_be_so(
    client: Client, condition: str, due: str
) -> None:
    text = DRIVE.replace("change(odometry) >= $way", f"'{condition}'")
    path = Path.cwd() / "drive.yaml"
    client.write(path, text)

    assert due in hover(client, text.replace("when:", "wh¦en:"))


def labels_of(hints: list[Json]) -> list[str]:
    return [each["label"] for each in hints]


def test_quantities_have_their_si_value_and_phases_their_times(client: Client) -> None:
    path = Path.cwd() / "drive.yaml"
    client.write(path, DRIVE)

    hints = client.about("inlayHint", path, range=EVERYTHING)

    assert {"= 0.2 m", "= 300 s"} <= {*labels_of(hints)}
    assert "= 20 s" not in labels_of(hints)
    halt = DRIVE[: DRIVE.index("  halt:")].count("\n")
    (times,) = (each["label"] for each in hints if each["position"]["line"] == halt)
    shortest, longest = times.split(" … ")
    assert 0 < float(shortest.removesuffix(" s")) < float(longest.removesuffix(" s")) <= 300


def time_of(client: Client, text: str, phase: str, name: str = "drive.yaml") -> str:
    hints = client.about("inlayHint", Path.cwd() / name, range=EVERYTHING)
    line = text[: text.index(f"  {phase}:")].count("\n")
    (time,) = (each["label"] for each in hints if each["position"]["line"] == line)
    return str(time)


def test_what_nothing_leads_to_is_said_to_be_never_reached(client: Client) -> None:
    alone = "  alone: {do: [Brake], go: other}\n  regrip:\n"
    text = DRIVE.replace("  regrip:\n", alone) + "  other: {fail: Never}\n"
    client.write(Path.cwd() / "drive.yaml", text)

    assert time_of(client, text, "alone") == "never reached"
    assert "end, never reached" in hover(client, text.replace("go: other", "go: oth¦er"))
    assert " s … " in time_of(client, text, "regrip")


def test_a_phase_in_which_nothing_waits_has_the_time_of_the_next_one(client: Client) -> None:
    passed = "  halt: {do: [{log: There}], go: stop}\n  stop: {do: [Brake], go: arrived}\n"
    text = DRIVE.replace("  halt: {do: [Brake], go: arrived}\n", passed)
    client.write(Path.cwd() / "drive.yaml", text)

    assert time_of(client, text, "halt") == time_of(client, text, "stop") == "14.5 s … 90 s"


def test_an_end_before_anything_has_moved_has_its_time_too(client: Client) -> None:
    question = "- {ask: Free?, choices: {free: continue, wait: not_now}, timeout: 9 s}"
    text = DRIVE.replace("- ClampFront", f"{question}\n      - ClampFront", 1)
    text += "  not_now: {fail: Not now}\n"
    client.write(Path.cwd() / "drive.yaml", text)

    assert "end, reached after 0 s … 9 s" in hover(client, text.replace("not_now}", "not_n¦ow}"))


def test_nothing_is_called_impossible_where_the_check_reached_its_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(explore, "MOST_WORK", 8)
    monkeypatch.setattr(explore, "_SHARED", deque())
    with served() as client:
        client.begin(tmp_path)
        found = client.write(tmp_path / "drive.yaml", DRIVE)
        assert [each["code"] for each in found] == ["check.too_large"]

        said = {
            word: hover(client, DRIVE.replace(word, f"{word[:-1]}¦{word[-1]}", 1))
            for word in ("when", "go: halt", "go: arrived")
        }
        times = [time_of(client, DRIVE, phase) for phase in ("drive", "halt", "regrip")]

    assert said["when"].startswith("`change(odometry) >= $way`\n")
    assert "reached after 0 s … " in said["go: halt"]
    assert "State: " not in said["go: halt"]
    assert "reached after 0 s … " in said["go: arrived"]
    assert all(each.startswith("0 s … ") for each in times)


def test_hints_are_only_those_of_the_part_that_is_shown(client: Client) -> None:
    path = Path.cwd() / "drive.yaml"
    client.write(path, DRIVE)
    part = {"start": {"line": 6, "character": 0}, "end": {"line": 6, "character": 200}}

    hints = client.about("inlayHint", path, range=part)

    assert labels_of(hints) == ["= 0.2 m", "= 0.05 m", "= 0.4 m"]


def test_the_editor_can_switch_hints_off(client: Client) -> None:
    path = Path.cwd() / "drive.yaml"
    client.put(path, DRIVE)
    for wanted in (False, True):
        settings = {"settings": {"pirate_sm": {"hints": wanted}}}
        client.send("workspace/didChangeConfiguration", settings)
        assert bool(client.about("inlayHint", path, range=EVERYTHING)) is wanted


def test_the_words_of_a_condition_have_their_kinds(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "coloured.yaml"
    condition = "known(gamma_1) and BendingState in (Unclamped, DoubleClamped) or $way > 20 mm"
    client.put(path, DRIVE.replace("change(odometry) >= $way", f"'{condition}'"))

    data = client.about("semanticTokens/full", path)["data"]

    first = list(coloured(data, DRIVE.replace("change(odometry) >= $way", f"'{condition}'")))
    assert first[:9] == [
        ("known", "function"), ("(", "operator"), ("gamma_1", "variable"), (")", "operator"),
        ("and", "keyword"), ("BendingState", "variable"), ("in", "keyword"), ("(", "operator"),
        ("Unclamped", "enumMember"),
    ]  # fmt: skip
    assert first[-3:] == [("$way", "parameter"), (">", "operator"), ("20 mm", "number")]


def coloured(data: list[int], text: str) -> Iterator[tuple[str, str]]:
    kinds = ["variable", "parameter", "number", "operator", "keyword", "function", "enumMember"]
    lines, line, character = text.split("\n"), 0, 0
    for below, right, length, kind, _ in zip(*[iter(data)] * 5, strict=True):
        character = right if below else character + right
        line += below
        yield lines[line][character : character + length], kinds[kind]


def completed(client: Client, text: str) -> dict[str, Any]:
    path = Path.cwd() / "drive.yaml"
    plain, position = place(text)
    client.put(path, plain)
    return {each["label"]: each for each in client.about("completion", path, position=position)}


def test_commands_that_are_possible_in_the_states_here_come_first(client: Client) -> None:
    first = completed(client, DRIVE.replace("- ClampFront", "- ¦", 1))
    later = completed(client, DRIVE.replace("- DriveForward", "- ¦", 1))

    assert first["ClampFront"]["sortText"] < first["DriveForward"]["sortText"]
    assert "impossible" in first["DriveForward"]["detail"]
    assert later["DriveForward"]["sortText"] < later["ClampFront"]["sortText"]
    assert "unneeded" in later["ClampFront"]["detail"]


def test_the_key_of_a_command_is_completed_by_the_states_here_too(client: Client) -> None:
    found = completed(client, DRIVE.replace("command: ClampRear", "command: ¦", 1))

    assert found["ClampRear"]["sortText"] < found["DriveForward"]["sortText"]


def test_signals_have_their_unit_and_range(client: Client) -> None:
    found = completed(client, DRIVE.replace("change(odometry) >= $way", "¦ > 0 deg"))

    assert found["gamma_1"]["detail"].startswith("signal, an angle, -")


def test_a_step_of_each_kind_has_a_snippet_that_has_all_it_needs(client: Client) -> None:
    found = completed(client, DRIVE.replace("- ClampFront", "- ¦", 1))

    kinds = ("command", "call", "repeat", "choose", "ask", "log", "wait", "control")
    texts = {each: found[each]["textEdit"]["newText"] for each in kinds}
    assert texts["ask"] == "ask: "
    assert texts["wait"] == "{wait: [{when: ${1:when}}], within: {time: ${2:time}}}"
    assert texts["repeat"] == "repeat: {times: ${1:times}, do: [${2:do}]}"
    assert found["choose"]["insertTextFormat"] == 2


def test_keys_come_with_what_they_must_have(client: Client) -> None:
    found = completed(client, DRIVE.replace("    wait: [{name: there", "    ¦wait: [{name: there"))
    phase = completed(client, DRIVE.replace("  halt:", "    ¦\n  halt:"))

    assert "textEdit" in found["wait"]
    assert phase["within"]["textEdit"]["newText"] == "within: {time: ${1:time}, go: ${2:go}}"

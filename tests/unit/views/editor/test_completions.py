"""What an editor offers at a place is what loading takes there; a `¦` is where the user types."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from .client import Client, Json, served

ROOT = Path(__file__).resolve().parents[4]
DRIVE = (ROOT / "tests" / "mistakes" / "bases" / "drive.yaml").read_text("utf-8")


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    with served() as client:
        client.begin(tmp_path_factory.mktemp("project"))
        yield client


def place(text: str) -> tuple[str, Json]:
    """A text without its mark, and the position of that."""
    before, after = text.split("¦")
    line = before.rpartition("\n")[2]
    return before + after, {"line": before.count("\n"), "character": len(line)}


def offered(client: Client, name: str, text: str) -> list[Json]:
    path = Path.cwd() / name
    plain, position = place(text)
    client.put(path, plain)
    found: list[Json] = client.about("completion", path, position=position)
    return found


def labels(found: list[Json]) -> list[str]:
    return [each["label"] for each in found]


PLACES = {
    "a target": ("go: halt", "go: ¦", ["drive", "halt", "regrip", "arrived", "gave_up"]),
    "a word that is begun": ("start: drive", "start: dr¦", ["drive", "halt", "regrip"]),
    "a type": ("type: length", "type: ¦", ["duration", "length", "angle", "speed"]),
    "a parameter": ("time: $give_up", "time: $¦", ["way", "give_up"]),
    "a key on its line": ("start: drive", "st¦", ["starts_in", "start", "phases", "ends"]),
    "a key in braces": ("halt: {do: [Brake], go: arrived}", "halt: {¦, go: x}", ["do", "wait"]),
    "a key with its value": ("within: {time", "within: {ti¦", ["time", "go"]),
    "a step of either kind": ("- DriveForward", "- ¦", ["ClampFront", "command", "call", "wait"]),
    "a command": ("[Brake]", "[Br¦]", ["ClampFront", "DriveBackward", "Brake"]),
    "a signal": ("change(odometry)", "change(od¦)", ["odometry", "gamma_1", "detector"]),
    "a state in a condition": ("change(odometry) >= $way", "BendingState == Un¦", ["Unclamped"]),
    "a state": ("BendingState: Unclamped", "BendingState: ¦", ["Unclamped", "DoubleClamped"]),
    "a fault": ("fault: wheel.dead", "fault: wheel.¦", ["wheel.dead", "robot.stuck", "clamp.lost"]),
    "a robot": ("robot: pirate_ii", "robot: ¦", ["pirate_ii"]),
    "a pipe": ("pipe: straight_113", "pipe: st¦", ["straight_113", "mitre_90"]),
}  # fmt: skip


@pytest.mark.parametrize("what", PLACES)
def test_the_place_says_what_is_possible(client: Client, what: str) -> None:
    old, new, due = PLACES[what]
    assert DRIVE.count(old)

    found = labels(offered(client, "drive.yaml", DRIVE.replace(old, new, 1)))

    assert [each for each in due if each not in found] == []
    assert len(found) == len(set(found))


def test_a_word_is_replaced_and_a_key_gets_its_colon(client: Client) -> None:
    word = offered(client, "drive.yaml", DRIVE.replace("[Brake]", "[Br¦ke]"))
    key = offered(client, "drive.yaml", DRIVE.replace("start: drive", "st¦"))
    value = offered(client, "drive.yaml", DRIVE.replace("start: drive", "st¦art: drive"))

    (brake,) = (each["textEdit"] for each in word if each["label"] == "Brake")
    assert brake["range"]["end"]["character"] - brake["range"]["start"]["character"] == len("Brke")
    assert {each["textEdit"]["newText"] for each in key} >= {"start: ", "phases: "}
    assert {each["textEdit"]["newText"] for each in value} >= {"start", "phases"}


def test_other_files_are_completed_too(client: Client) -> None:
    pipe = "format: 1\npipe: short\ndiameter: 113 mm\nsegments:\n  - {¦}\n"

    assert {"straight", "mitre"} & {*labels(offered(client, "short.yaml", pipe))}


def test_nothing_is_offered_in_free_text(client: Client) -> None:
    text = DRIVE.replace("description: Drive", "description: Dr¦")

    assert offered(client, "drive.yaml", text) == []
    assert offered(client, "other.yaml", "services: {we¦}\n") == []

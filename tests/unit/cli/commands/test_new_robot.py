"""New robots, and others with more wheels that are made of them, go round bends by new missions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from representative import thorough_but


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


PIPE = """\
format: 1
pipe: twice
diameter: 95 mm
segments: [{straight: 1.4 m}, {mitre: A deg}, {straight: 1.6 m}, {mitre: B deg}, {straight: 1.4 m}]
start: {at: 900 mm}
"""


def with_wheels(folder: Path, count: int) -> None:
    """The new robot has so many wheels, the front half of them in its nose."""
    file = folder / "profile.yaml"
    data = yaml.safe_load(file.read_text(encoding="utf-8"))
    body, nose = data["body"], count // 2
    signs = [1 if number % 2 == 0 else -1 for number in range(count)]
    parts = ["nose" if number < nose else "tail" for number in range(count)]
    body["wheels"] = [
        {"name": f"wheel_{n}", "part": part, "direction": sign, "mass": "15 g",
         "angle": f"turn_{n}", "speed": f"spin_{n}"}
        for n, (part, sign) in enumerate(zip(parts, signs, strict=True), start=1)
    ]  # fmt: skip
    body["links"] = [
        {"module": f"link_{n}", "length": "80 mm", "mass": "100 g"} for n in range(1, count)
    ]
    body["joints"] = [
        {"name": f"bend_{n}", "wheel": f"wheel_{n}", "part": parts[n - 1], "end_stop": "130 deg",
         "torque": f"torque_{n}"}
        for n in range(2, count)
    ]  # fmt: skip
    apexes = {"nose": "bend_2", "tail": f"bend_{count - 1}"}
    for part, apex in apexes.items():
        body["parts"][part]["apex"] = apex
    data["boards"] = [_board(n, count) for n in range(1, count + 1)]
    wheels = [each["name"] for each in body["wheels"]]
    data["derived"] = {
        **{f"spin_{n}": {"rate_of": f"turn_{n}"} for n in range(1, count + 1)},
        **{f"rate_{n}": {"rate_of": f"bend_{n}"} for n in range(2, count)},
        "width_nose": {"diameter_of": "nose"},
        "width_tail": {"diameter_of": "tail"},
        "way": {"odometry_of": wheels},
        "pace": {"speed_of": wheels},
    }
    _act(data, parts, signs)
    for part, command in (("nose", "HoldNose"), ("tail", "HoldTail")):
        joints = [each["name"] for each in body["joints"] if each["part"] == part]
        data["commands"][command]["done"] |= {"joints": joints, "loaded": [apexes[part]]}
        data["seen"]["parts"][part]["loaded"] = [apexes[part]]
    data["commands"]["Home"]["done"]["signals"] = [each["name"] for each in body["joints"]]
    data["faults"] = [each for each in data["faults"] if each["code"] == "robot.stuck"]
    data["detector"]["words"]["near"]["backward"]["wheel"] = wheels[-1]
    data["plausibility"] = {"wheel_moved": "4 rad"}
    data["simulation"]["defects"] = {}
    data["rules"] = data["rules"][:1]
    file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")


def _board(number: int, count: int) -> dict[str, Any]:
    """The board of a wheel, and of the joint at it."""
    slots = [{"name": f"drive_{number}", "unit": "duty", "motor": "wheel",
              "wheel": f"wheel_{number}", "mirrors": True}]  # fmt: skip
    channels = [{"name": "wheel", "signal": f"turn_{number}", "convert": "wheel_count",
                 "senses": "angle", "slot": f"drive_{number}"}]  # fmt: skip
    if 1 < number < count:
        slot = f"fold_{number}"
        slots.append({"name": slot, "unit": "duty", "motor": "fold",
                      "joint": f"bend_{number}", "mirrors": True})  # fmt: skip
        channels += [
            {"name": "bend", "signal": f"bend_{number}", "convert": "fold_count",
             "senses": "angle", "slot": slot},
            {"name": "spring", "signal": f"torque_{number}", "convert": "spring_count",
             "senses": "torque", "slot": slot},
        ]  # fmt: skip
    if number == 1:
        slots.append({"name": "lamp", "unit": "duty", "motor": "bulb"})
    return {"id": number, "module": f"link_{min(number, count - 1)}", "slots": slots,
            "channels": channels}  # fmt: skip


def _act(data: dict[str, Any], parts: list[str], signs: list[int]) -> None:
    """What the states write: parts fold in a zigzag, wheels drive towards their sides."""
    joints = range(2, len(parts))
    for state, held in (("Loose", ()), ("NoseHeld", ("nose",)), ("TailHeld", ("tail",)),
                        ("BothHeld", ("nose", "tail"))):  # fmt: skip
        free = "0 deg" if state == "Loose" else "0 %"
        data["actuation"]["Grip"][state] = {
            f"fold_{n}": f"{signs[n - 1] * 50} %" if parts[n - 1] in held else free for n in joints
        }
    for state, way in (("Resting", 0), ("Ahead", 80), ("Astern", -80)):
        data["actuation"]["Crawl"][state] = {
            f"drive_{n}": f"{way * sign} %" for n, sign in enumerate(signs, start=1)
        }
    data["safe_state"]["zero"] = list(data["actuation"]["Crawl"]["Resting"])


def drives(pirate: Any, pirate_run: Any, first: int, second: int) -> str:
    """What a mission along a pipe with two bends says at its end, of a robot that is sound."""
    pipe = PIPE.replace("A deg", f"{first} deg").replace("B deg", f"{second} deg")
    Path("twice.yaml").write_text(pipe, encoding="utf-8")
    made = pirate("new", "mission", "trip", "--robot", "mine", "--pipe", "twice.yaml")
    assert (made.exit_code, made.stderr) == (0, "")
    checked = pirate("check", "mine/profile.yaml", "mine/take_bend.yaml", "trip.yaml")
    assert "no findings" in checked.stdout, checked.stdout
    return str(pirate_run("trip.yaml", "--no-record", "--quiet").output)


@pytest.mark.parametrize(("first", "second"), thorough_but([(45, 30)], [(45, 30), (-30, -45)]))
def test_a_new_robot_goes_round_bends_by_a_new_mission(
    pirate: Any, pirate_run: Any, first: int, second: int
) -> None:
    pirate("new", "robot", "mine")

    assert "At the end of the route" in drives(pirate, pirate_run, first, second)


@pytest.mark.thorough
@pytest.mark.parametrize(("count", "nose_mm", "tail_mm"), [(5, 300, 120), (8, 450, 200)])
def test_a_robot_with_more_wheels_goes_round_bends_by_a_new_mission(
    pirate: Any, pirate_run: Any, count: int, nose_mm: int, tail_mm: int
) -> None:
    pirate("new", "robot", "mine")
    with_wheels(Path("mine"), count)
    mission = Path("mine/take_bend.yaml")
    text = mission.read_text(encoding="utf-8").replace("95 mm, go", f"{tail_mm} mm, go")
    mission.write_text(text.replace("245 mm, go", f"{nose_mm} mm, go"), encoding="utf-8")

    assert "At the end of the route" in drives(pirate, pirate_run, 20, 20)


def test_a_bend_that_is_too_sharp_for_a_new_robot_is_refused(pirate: Any) -> None:
    pirate("new", "robot", "mine")
    Path("p.yaml").write_text(PIPE.replace("A", "60").replace("B", "30"), encoding="utf-8")

    refused = pirate("new", "mission", "trip", "--robot", "mine", "--pipe", "p.yaml")

    assert refused.exit_code == 2
    assert "has no passage for a mitre of 60 deg" in refused.stderr
    assert "p.yaml:4:" in refused.stderr


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("robot", "pirate_ii"),
        ("mission", "take_bend"),
        ("pipe", "straight_113"),
        ("camera", "setup_1"),
    ],
)
def test_a_name_that_would_hide_a_shipped_file_is_refused(
    pirate: Any, kind: str, name: str, tmp_path: Path
) -> None:
    refused = pirate("new", kind, name)

    assert refused.exit_code == 2
    assert f"there is a shipped {kind} '{name}'" in refused.stderr
    assert f"my_{name}" in refused.stderr
    assert list(tmp_path.iterdir()) == []

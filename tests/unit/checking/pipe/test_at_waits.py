"""Words and ways of a mission's waits are held against the route that the robot has come along."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.mission.check_mission import check_mission

from ..robots import PIRATE, changed

GO = "[ClampFront, ClampRear, DriveForward]"
BACK = GO.replace("Forward", "Backward")
INTO = "[Brake, RelaxFront, BendInto, DriveForward]"
ROUND = "[Brake, ClampFront, RelaxRear, BendBack, ClampRear, DriveForward]"


def shown(
    folder: Path, *waits: tuple[str, str], pipe: str = "mitre_90", robot: str = "pirate_ii"
) -> list[str]:
    """The codes and messages about waits, each with the steps before it."""
    phases = "".join(
        f"  p{n}: {{do: {do}, wait: [{{when: {when}, go: p{n + 1}}}],"
        " within: {time: 30 s, go: late}}\n"
        for n, (do, when) in enumerate(waits)
    )
    text = (
        f"format: 1\nmission: m\nrobot: {robot}\npipe: {pipe}\nstart: p0\nphases:\n{phases}"
        f"  p{len(waits)}: {{do: [Brake], go: good}}\n  late: {{do: [Brake], go: bad}}\n"
        "ends: {good: {succeed: Good}, bad: {fail: Bad}}\n"
    )
    file = folder / "m.yaml"
    file.write_text(text, encoding="utf-8")
    return [f"{each.code}: {each.message}" for each in check_mission(file).findings]


CLOSE, IN, PAST = (f"detector == {word}" for word in ("close", "in", "past"))


def test_the_words_of_a_bend_come_one_after_the_other(tmp_path: Path) -> None:
    assert shown(tmp_path, (GO, CLOSE), (INTO, IN), (ROUND, PAST)) == []


@pytest.mark.parametrize("word", [IN, PAST])
def test_no_part_is_round_a_bend_into_which_none_has_bent(tmp_path: Path, word: str) -> None:
    (said,) = shown(tmp_path, (GO, word))

    why = "is said in a bend, and no part of the robot has bent into one before"
    assert said == f"word.route: '{word}' {why}"


def test_the_last_wheel_is_not_round_it_before_its_part_has_bent(tmp_path: Path) -> None:
    (said,) = shown(tmp_path, (GO, CLOSE), (INTO, PAST))

    assert said.endswith("is said after the bend, and only a part of the robot has bent into it")


def test_a_straight_pipe_has_no_joint_between_parts(tmp_path: Path) -> None:
    straight = "{diameter: 120 mm, segments: [{straight: 2 m}], start: {at: 700 mm}}"
    (said,) = shown(tmp_path, (GO, "segment == Joint"), pipe=straight)

    assert said.endswith("waits for a bend, and the pipe has none")
    assert shown(tmp_path, (GO, "segment == Straight"), pipe=straight) == []


def test_behind_the_last_bend_there_is_no_further_word(tmp_path: Path) -> None:
    round_it = (GO, CLOSE), (INTO, IN), (ROUND, PAST)
    (said,) = shown(tmp_path, *round_it, ("[ToggleLighting]", CLOSE))
    assert said.endswith("the route has no other bend in that direction")

    two = "{diameter: 120 mm, segments: [{straight: 1 m}, {mitre: 90 deg}, {straight: 1 m},"
    two += " {mitre: 90 deg}, {straight: 1 m}], start: {at: 700 mm}}"
    assert shown(tmp_path, *round_it, ("[ToggleLighting]", CLOSE), pipe=two) == []


def test_a_robot_that_backs_from_a_bend_hears_nothing_of_it(tmp_path: Path) -> None:
    (said,) = shown(tmp_path, (BACK, CLOSE))
    assert said.endswith("the route has no other bend in that direction")

    assert shown(tmp_path, (BACK, CLOSE), pipe="mitre_90_backward") == []


@pytest.mark.parametrize(
    ("kind", "pipe"), [("elbow", "mitre_90"), ("tee", "mitre_90"), ("mitre", "elbow_90")]
)
def test_a_joint_is_of_a_kind_that_the_pipe_has(tmp_path: Path, kind: str, pipe: str) -> None:
    (said,) = shown(tmp_path, (GO, f"joint == {kind}"), pipe=pipe)

    assert said.startswith("word.never: ")
    assert shown(tmp_path, (GO, f"'joint in ({kind}, end)'"), pipe=pipe) == []


def test_a_detector_whose_words_follow_from_signals_may_say_anything(tmp_path: Path) -> None:
    wait = (GO, "joint == elbow")
    (said,) = shown(tmp_path, wait)
    assert said.startswith("word.never: ")

    felt = "  words:\n    felt: {when: abs(roll) > 30 deg}\n"
    robot = changed(PIRATE, tmp_path, "profile.yaml", ("  words:\n", felt))
    assert shown(tmp_path, wait, robot=str(robot)) == []


@pytest.mark.parametrize(("way", "fits"), [("200 mm", True), ("350 mm", True), ("700 mm", False)])
def test_a_way_ends_at_a_mitre_into_which_nothing_bends(
    tmp_path: Path, way: str, fits: bool
) -> None:
    for signal in ("odometry", "change(odometry)"):
        said = shown(tmp_path, (GO, f"{signal} >= {way}"))

        assert [each.partition(":")[0] for each in said] == ([] if fits else ["condition.beyond"])


def test_round_a_bend_the_way_leads_on_to_the_end(tmp_path: Path) -> None:
    bent = (GO, CLOSE), (INTO, IN)

    assert shown(tmp_path, *bent, (ROUND, "change(odometry) >= 800 mm")) == []


def test_a_way_is_as_long_as_it_is_backward(tmp_path: Path) -> None:
    assert shown(tmp_path, (BACK, "change(odometry) <= -400 mm")) == []


def test_ways_one_after_the_other_are_longer_than_the_pipe(tmp_path: Path) -> None:
    first, again = (GO, "change(odometry) >= 400 mm"), "change(odometry) >= 400 mm"
    back = ("[Brake, DriveBackward]", "change(odometry) <= -400 mm")

    (said,) = shown(tmp_path, first, ("[Brake, DriveForward]", again), pipe="straight_113")

    assert said.startswith("condition.beyond: ")
    assert shown(tmp_path, first, back, ("[Brake, DriveForward]", again), pipe="straight_113") == []


@pytest.mark.parametrize(("patience", "fits"), [("5 s", False), ("1 min", True)])
def test_a_called_mission_has_time_for_its_way(tmp_path: Path, patience: str, fits: bool) -> None:
    call = f"{{call: drive_on, with: {{way: 900 mm, give_up: {patience}}}}}"
    do = f"[ClampFront, ClampRear, {call}, DriveBackward]"

    pipe = "{diameter: 120 mm, segments: [{straight: 2 m}], start: {at: 500 mm}}"
    found = shown(tmp_path, (do, "change(odometry) <= -50 mm"), pipe=pipe)

    assert any(each.startswith("condition.beyond: ") for each in found) is not fits


LATE = "{time: 30 s, go: late}"


def codes(
    folder: Path, other: str, waits: tuple[str, str], more: str = "", pipe: str = "mitre_90"
) -> list[str]:
    """The findings where something else than what `a` waits for leads to `b` too."""
    first, second = waits
    phases = (
        f"  a: {{do: {GO}, wait: [{{when: {first}, go: b}}], within: {other}}}\n"
        f"  b: {{wait: [{{when: {second}, go: c}}, {{operator: on, go: c}}], within: {LATE}}}\n"
    )
    text = (
        f"format: 1\nmission: m\nrobot: pirate_ii\npipe: {pipe}\nstart: a\nphases:\n{phases}{more}"
        "  c: {do: [{command: Brake, unneeded: skip}], go: good}\n"
        "  late: {do: [{command: Brake, unneeded: skip}], go: bad}\n"
        "ends: {good: {succeed: Good}, bad: {fail: Bad}}\n"
    )
    file = folder / "m.yaml"
    file.write_text(text, encoding="utf-8")
    return [each.code for each in check_mission(file).findings]


@pytest.mark.parametrize(
    ("other", "more"),
    [
        ("{time: 20 s, go: b}", ""),
        ("{time: 20 s, go: x}", "  x: {do: [{log: Slow}], go: b}\n"),
        (f"{LATE}, on_failure: x", "  x: {do: [{log: Failed}], go: b}\n"),
        (
            f"{LATE}, on_failure: x",
            "  x: {do: [{ask: On?, choices: {on: continue}, timeout: 9 s}], go: b}\n",
        ),
        (
            "{time: 20 s, go: x}",
            "  x: {do: [{choose: [{if: odometry > 1 mm, do: [{log: Far}]}]}], go: b}\n",
        ),
        (
            "{time: 20 s, go: x}",
            f"  x: {{do: [Brake, DriveBackward], wait: [{{after: 2 s, go: y}}], within: {LATE}}}\n"
            "  y: {do: [Brake, DriveForward], go: b}\n",
        ),
    ],
)
def test_a_way_is_driven_before_a_wait_only_if_nothing_else_leads_there(
    tmp_path: Path, other: str, more: str
) -> None:
    ways = "change(odometry) >= 300 mm", "change(odometry) >= 500 mm"

    assert codes(tmp_path, other, ways, more, "straight_113") == []
    assert codes(tmp_path, LATE, ways, pipe="straight_113") == ["condition.beyond"]


def test_a_word_is_said_where_only_a_time_limit_has_led_into_the_bend(tmp_path: Path) -> None:
    into = INTO.replace("Brake, ", "{command: Brake, unneeded: skip}, ")
    more = f"  x: {{do: {into}, go: b}}\n"

    assert codes(tmp_path, "{time: 20 s, go: x}", (CLOSE, IN), more) == []
    assert codes(tmp_path, LATE, (CLOSE, IN)) == ["word.route"]


def test_the_end_is_not_the_next_joint_before_a_bend(tmp_path: Path) -> None:
    (said,) = shown(tmp_path, (GO, "joint == end"))

    assert said.startswith("word.route: ")
    assert shown(tmp_path, (GO, "joint == mitre")) == []
    assert shown(tmp_path, (GO, CLOSE), (INTO, IN), (ROUND, "joint == end")) == []


def test_a_robot_leaves_a_pipe_through_an_open_end_only(tmp_path: Path) -> None:
    run = "runs: {main: {from: entry, to: way, segments: [{straight: 2 m}]}}, start: {at: 700 mm}"
    for end, fits in (("open", True), ("closed", False)):
        pipe = f"{{diameter: 120 mm, section: round, {run}, ends: {{entry: open, way: {end}}}}}"

        found = shown(tmp_path, (GO, "segment == Out"), pipe=pipe)

        assert [each.partition(":")[0] for each in found] == ([] if fits else ["word.never"])


@pytest.mark.parametrize(("when", "fits"), [("0 mm", False), ("-5 mm", False), ("5 mm", True)])
def test_a_way_that_is_driven_from_the_beginning_is_waited_for(
    tmp_path: Path, when: str, fits: bool
) -> None:
    found = shown(tmp_path, (GO, f"odometry >= {when}"))

    assert [each.partition(":")[0] for each in found] == ([] if fits else ["trigger.at_start"])

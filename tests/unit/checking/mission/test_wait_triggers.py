"""Triggers that nothing can make true, that never get their turn, or that are true already."""

from __future__ import annotations

from pathlib import Path

import pytest

from checking.small_missions import checked, only, told, write
from pirate_sm.checking.check_project import check_paths


def wait(*triggers: str, within: str = "10 s", go: str = "bad") -> str:
    listed = "\n".join(f"      - {trigger}" for trigger in triggers)
    return (
        f"start: p\nphases:\n  p:\n    do: [SwitchLamp]\n    wait:\n{listed}\n"
        f"    within: {{time: {within}, go: {go}}}\n"
    )


FIRES = "{when: way > 50 mm, go: good}"


@pytest.mark.parametrize(
    ("trigger", "code"),
    [
        ("{when: way > 50 mm and way < 20 mm, go: good}", "trigger.never"),
        ("{when: abs(neck) > 3 rad, go: good}", "trigger.never"),  # beyond its end stops
        ("{when: Grip == BothHeld, go: good}", "trigger.never"),  # no state that comes here
        ("{when: pace > 1 mm/s, held: 11 s, go: good}", "trigger.never"),
        ("{after: 11 s, go: good}", "trigger.never"),
        ("{when: way > 60 mm, go: good}", "trigger.shadowed"),
        ("{when: Lamp == Lit, go: good}", "trigger.at_once"),
        ("{when: change(way) <= 100 mm, go: good}", "trigger.at_once"),  # it begins at 0
        ("{when: change(way) == 0 mm, go: good}", "trigger.at_once"),
        ("{when: abs(change(neck) - change(hip)) < 1 deg, go: good}", "trigger.at_once"),
        ("{when: Lamp == Lit and change(way) > -5 mm, go: good}", "trigger.at_once"),
        ("{when: pace > 1 mm/s, held: 10 s, go: good}", ""),
        ("{after: 10 s, go: good}", ""),
        ("{operator: yes, go: good}", ""),
        ("{when: way > 40 mm, go: good}", ""),
        ("{when: change(way) < 0 mm, go: good}", ""),
        ("{when: change(way) <= 100 mm and way > 20 mm, go: good}", ""),  # it need not stand there
        ("{when: change(way) <= 100 mm, held: 2 s, go: good}", ""),
        ("{when: known(change(way)), go: good}", ""),
    ],
)
def test_a_trigger_is_told_if_it_is_of_no_use(tmp_path: Path, trigger: str, code: str) -> None:
    triggers = (trigger, FIRES) if code == "trigger.at_once" else (FIRES, trigger)

    codes = [found for found, _ in told(checked(tmp_path, wait(*triggers)))]

    assert [each for each in codes if each.startswith("trigger.")][:1] == ([code] if code else [])


def test_what_a_change_is_while_its_signal_is_unknown_is_not_said_to_be_true(
    tmp_path: Path,
) -> None:
    trigger = "{when: abs(change(neck) - change(hip)) < 1 deg, go: good}"

    found = only(checked(tmp_path, wait(trigger, FIRES)), "trigger.at_once")

    assert found.message == (
        "'abs(change(neck) - change(hip)) < 1 deg' is true already whenever the wait begins and "
        "neck and hip are known: change(neck) and change(hip) are 0 then"
    )


@pytest.mark.parametrize(
    ("asked", "code"),
    [
        ("not known(way)", "trigger.never"),
        ("known(way)", "trigger.at_once"),
        ("way < 20 mm", "trigger.at_once"),
        ("pace > 1 mm/s", "trigger.at_once"),
    ],
)
def test_a_change_of_a_signal_that_is_unknown_as_the_wait_begins_never_fires(
    tmp_path: Path, asked: str, code: str
) -> None:
    """Three-valued: what it was then is not known later either."""
    body = f"""
start: p
phases:
  p:
    do:
      - SwitchLamp
      - choose:
          - if: {asked}
            do: [{{wait: [{{when: change(way) <= 100 mm}}], within: {{time: 10 s}}}}]
    go: good
"""
    codes = [found for found, _ in told(checked(tmp_path, body))]

    assert [each for each in codes if each.startswith("trigger.")] == [code]


def test_a_change_that_begins_now_known_and_now_not_is_left_alone(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p:
    do: [SwitchLamp, {choose: [{if: not known(way), do: [{log: a}]}], else: [{log: b}]}]
    wait: [{when: change(way) <= 100 mm, go: good}]
    within: {time: 10 s, go: bad}
"""
    codes = [found for found, _ in told(checked(tmp_path, body))]

    assert set(codes) <= {"wait.still"}  # nothing drives


def test_the_effort_for_conditions_to_be_held_does_not_double_with_each(tmp_path: Path) -> None:
    """Two took 30 steps, ten 26,000, and twelve were too much to look at."""
    signals = ["neck", "hip", "way", "pace", "amps_a", "roll_a", "roll_b", "roll_c", "roll_d"]
    signals += ["neck_torque", "hip_torque", "width_nose"]
    triggers = [
        f"{{when: known({name}), held: {number + 1} s, name: t{number}, go: good}}"
        for number, name in enumerate(signals)
    ]

    check = checked(tmp_path, wait(*triggers, within="1 min"))

    (book,) = check.explored
    assert {each.code for each in check.findings} <= {"wait.still"}  # nothing drives
    (waiting,) = book.waits.values()
    assert set(waiting.fired) == {*(f"t{n}" for n in range(12)), "within"}
    assert len(book.found.steps) < 500


@pytest.mark.parametrize(
    ("held", "expected"),
    [
        # Each brings the one before it along, which then fires first.
        ((("way > 10 mm", 1), ("way > 20 mm", 2)), ["trigger.shadowed"]),
        ((("way > 10 mm", 2), ("way > 20 mm", 1)), []),
        # The last one needs both of the others, and comes at once; but nothing drives there.
        (
            (("way > 10 mm", 2), ("pace > 1 mm/s", 2), ("way > 10 mm and pace > 1 mm/s", 0)),
            ["trigger.at_start"],
        ),
    ],
)
def test_conditions_that_bring_others_along_are_seen_together(
    tmp_path: Path, held: tuple[tuple[str, int], ...], expected: list[str]
) -> None:
    triggers = [
        f"{{when: {when}, held: {time_s} s, name: t{number}, go: good}}"
        for number, (when, time_s) in enumerate(held)
    ]

    codes = [code for code, _ in told(checked(tmp_path, wait(*triggers)))]
    assert [code for code in codes if code != "wait.still"] == expected  # nothing drives


def test_what_is_held_may_be_true_together_in_the_next_phase(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p:
    wait: [{when: way > 10 mm, held: 1 s, go: bad}, {when: pace > 1 mm/s, held: 1 s, go: bad},
           {operator: next, go: q}]
    within: {time: 1 min, go: bad}
  q: {do: [{command: HoldNose, if: way > 10 mm and pace > 1 mm/s}], go: good}
"""
    check = checked(tmp_path, body)

    assert {code for code, _ in told(check)} <= {"wait.still"}  # nothing drives
    assert any(each.given for each in check.explored[0].visits.values())


def test_a_condition_that_is_always_the_same_is_reported(tmp_path: Path) -> None:
    body = """
start: p
phases: {p: {do: [{command: HoldNose, if: "abs(neck) > 3 rad"}, SwitchLamp], go: good}}
"""
    assert (
        "'abs(neck) > 3 rad' is always false"
        in only(checked(tmp_path, body), "condition.constant").message
    )


def test_a_wait_lasts_while_sensors_show_now_this_and_now_that(tmp_path: Path) -> None:
    """Neither condition is ever true for 2 s, and one of them always is."""
    body = wait(
        "{when: known(hip), held: 2 s, go: good}",
        "{when: not known(hip), held: 2 s, go: good}",
        within="3 s", go="q",
    ) + "  q: {do: [Rest], go: good}\n"  # fmt: skip

    found = only(checked(tmp_path, body), "step.unneeded")

    assert found.story[-1].startswith("sensors show now this and now that")
    assert not found.course  # no course of single events could show that


def crawl(steps: str, when: str, held: str = "") -> str:
    """A mission that drives at its very beginning, and waits."""
    return f"""
start: p
phases:
  p:
    do: [{steps}]
    wait: [{{when: '{when}'{held}, go: good}}]
    within: {{time: 30 s, go: bad}}
"""


AHEAD, ASTERN = "HoldNose, HoldTail, GoAhead", "HoldNose, HoldTail, GoAstern"
TO_AND_FRO = "HoldNose, HoldTail, GoAhead, Rest, GoAstern"


@pytest.mark.parametrize(
    ("steps", "when", "code"),
    [
        (ASTERN, "way <= 100 mm", "trigger.at_start"),
        (ASTERN, "way != 100 mm", "trigger.at_start"),
        (ASTERN, "way <= 100 mm or pace > 1 mm/s", "trigger.at_start"),
        (AHEAD, "way <= 100 mm", "trigger.at_start"),
        (AHEAD, "abs(way) < 20 mm", "trigger.at_start"),
        (AHEAD, "way >= -20 mm", "trigger.at_start"),
        ("HoldNose", "abs(way) < 20 mm", "trigger.at_start"),
        (AHEAD, "way != 100 mm", "condition.exact"),
        (AHEAD, "way == 100 mm", "condition.exact"),
        (AHEAD, "change(way) == 100 mm", "condition.exact"),
        (AHEAD, "neck == 10 deg and pace > 1 mm/s", "condition.exact"),
        (ASTERN, "way >= 100 mm and pace < 0 mm/s", "trigger.at_start"),
        (ASTERN, "abs(way - 100 mm) < 5 mm", "trigger.at_start"),
        (ASTERN, "way >= 100 mm", "wait.still"),
        (AHEAD, "abs(neck_torque) > 10 Nm", "trigger.never"),
        (ASTERN, "way <= -100 mm", ""),
        (ASTERN, "way <= 100 mm and pace < 0 mm/s", ""),
        (AHEAD, "way < -20 mm or way > 100 mm", ""),
        (AHEAD, "way >= 100 mm and pace > 0 mm/s", ""),
        (AHEAD, "abs(way - 100 mm) < 5 mm", ""),
        (TO_AND_FRO, "way <= 100 mm", ""),  # it may be farther than that
        (AHEAD, "pace == 0 mm/s", ""),  # a robot at rest
        (TO_AND_FRO, "max(way, 100 mm) == 100 mm or pace < 0 mm/s", ""),
    ],
)
def test_what_a_wait_means_at_the_beginning_of_a_run_where_odometry_is_0(
    tmp_path: Path, steps: str, when: str, code: str
) -> None:
    codes = [found for found, _ in told(checked(tmp_path, crawl(steps, when)))]

    assert [each for each in codes if each in CODES] == ([code] if code else [])


CODES = {"trigger.at_start", "trigger.at_once", "trigger.never", "condition.exact", "wait.still"}


def test_what_must_be_held_may_be_true_at_the_beginning(tmp_path: Path) -> None:
    body = crawl(AHEAD, "abs(way) < 5 mm", ", held: 2 s")

    assert told(checked(tmp_path, body)) == []


def test_after_a_wait_in_which_it_drove_odometry_may_be_anything(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p:
    do: [HoldNose, HoldTail, GoAhead]
    wait: [{when: way >= 300 mm, go: q}]
    within: {time: 30 s, go: bad}
  q:
    do: [Rest, GoAstern]
    wait: [{when: way <= 100 mm, go: good}]
    within: {time: 30 s, go: bad}
"""
    assert told(checked(tmp_path, body)) == []


def test_a_mission_that_others_call_begins_wherever_they_have_come_to(tmp_path: Path) -> None:
    part = write(tmp_path, crawl("GoAstern", "way <= 100 mm"), name="part")
    assert "trigger.at_start" in {each.code for each in check_paths([str(part)]).findings}
    write(
        tmp_path,
        """
start: p
phases:
  p:
    do: [HoldNose, HoldTail, GoAhead]
    wait: [{when: way >= 300 mm, go: q}]
    within: {time: 30 s, go: bad}
  q: {do: [Rest, {call: ./part.yaml}], go: good}
""",
    )

    both = check_paths([str(tmp_path)]).findings

    assert "trigger.at_start" not in {each.code for each in both}

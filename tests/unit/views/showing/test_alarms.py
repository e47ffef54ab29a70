from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import pytest

from pirate_sm.core.effects import CommandStatus, Ended, Fault, Log
from pirate_sm.robot.backends.serial.link.health import LinkHealth
from pirate_sm.views.showing import alarms, panels
from pirate_sm.views.showing.snapshot import Memory, Snapshot

from .test_panels import PATROL, after, beginning

FAULT = Fault("firmware.reset", "the controller was reset", "continue")
EVERY = range(1000)


@pytest.fixture(scope="module")
def snapshot() -> Snapshot:
    return beginning(PATROL)


def link(silent_s: float = 2.5, stops_s: float = inf, *, stopped: bool = False) -> LinkHealth:
    nothing = "nothing comes from the robot"
    return LinkHealth(9, 0, 3, 0, 0, nan, silent_s, nothing, 7.6, stopped, switch_stops_s=stops_s)


def said(snapshot: Snapshot, seen: object = ()) -> list[str]:
    return [each.plain for each in alarms.bar(snapshot, seen, 200, keys=False)]  # type: ignore[arg-type]


def story(snapshot: Snapshot, *effects: tuple[float, Fault | Ended | Log]) -> Snapshot:
    memory = Memory(snapshot.scene.robot)
    for now_s, effect in effects:
        memory.see([effect], now_s)
    return replace(snapshot, story=memory.story)


# --- how long an alarm is shown -------------------------------------------------------------------


def test_a_fault_stays_when_its_rule_is_not_true_any_more_as_for_a_dead_wheel_that_is_stopped(
    snapshot: Snapshot,
) -> None:
    code = snapshot.scene.robot.faults[0].code
    shown = after(snapshot, Fault(code, "it is so", "continue"))
    assert shown.state is not None
    assert not shown.state.faults.raised

    assert f"{code}: it is so" in said(shown)[0]
    assert not alarms.alarms(shown, ())[0].over
    assert said(shown, EVERY) == []


def test_a_warning_whose_cause_nobody_follows_stays_until_it_is_acknowledged(
    snapshot: Snapshot,
) -> None:
    shown = after(snapshot, FAULT)

    assert "firmware.reset" in said(shown)[0]
    assert said(shown, EVERY) == []


def test_a_silent_board_is_a_cause_that_may_go(snapshot: Snapshot) -> None:
    shown = after(snapshot, Fault("sensor.silent", "the board says nothing", "continue"))
    assert shown.state is not None
    faults = shown.state.faults._replace(silent=frozenset({0}))

    assert said(replace(shown, state=shown.state._replace(faults=faults)))
    assert said(shown) == []


# --- which alarm is shown -------------------------------------------------------------------------


def test_an_old_end_does_not_hide_a_new_fault(snapshot: Snapshot) -> None:
    shown = story(snapshot, (1.0, Ended("interrupted", "stopped by the operator")), (2.0, FAULT))

    (line,) = said(shown)
    assert line.startswith(" ⚠ 2.0 s  fault: firmware.reset")
    assert "!: 1 more" in str(alarms.bar(shown, (), 200)[0])


def test_a_cascade_keeps_its_first_cause_and_says_how_it_ended(snapshot: Snapshot) -> None:
    shown = story(
        snapshot,
        (1.0, Log("warning", "old news")),
        (30.0, FAULT),
        (30.4, Log("warning", "a consequence")),
        (31.0, Ended("failed", "the command failed")),
    )

    assert [each[:40].strip() for each in said(shown)] == [
        "⚠ 30.0 s  fault: firmware.reset: the co",
        "■ 31.0 s  FAILED: the command failed",
    ]
    assert [each.first for each in alarms.alarms(shown, ())] == [True, True, False, False]


@pytest.mark.parametrize("at_s", [0.5, 1.2, 30.0])
def test_a_warning_hides_no_fault(snapshot: Snapshot, at_s: float) -> None:
    lines = [(1.0, FAULT), (at_s, Log("warning", "gamma_3 is on its end stop"))]
    shown = story(snapshot, *sorted(lines, key=lambda each: each[0]))

    (line,) = said(shown)
    assert "firmware.reset" in line


@pytest.mark.parametrize("ended_s", [1.4, 30.0])
def test_a_fault_that_the_mission_has_handled_stays_and_its_success_is_shown_below(
    snapshot: Snapshot, ended_s: float
) -> None:
    warned = Log("warning", "a consequence")
    shown = story(
        snapshot, (1.0, FAULT), (1.2, warned), (ended_s, Ended("succeeded", "It is there"))
    )

    fault, success = said(shown)
    assert "⚠ 1.0 s  fault: firmware.reset" in fault
    assert "SUCCEEDED: It is there" in success
    assert not alarms.shows_success(shown, ())


def test_a_success_of_an_older_run_is_not_how_a_fault_has_ended(snapshot: Snapshot) -> None:
    succeeded = Ended("succeeded", "It is there")
    shown = story(snapshot, (1.0, succeeded), (1.4, FAULT))
    (line,) = said(shown)
    assert "firmware.reset" in line

    shown = story(snapshot, (1.0, FAULT), (1.4, Ended("failed", "so")), (1.8, succeeded))
    assert "FAILED: so" in said(shown)[1]


@pytest.mark.parametrize("warned_s", [0.5, 1.5, 30.0])
def test_a_warning_hides_no_success(snapshot: Snapshot, warned_s: float) -> None:
    lines = [(1.0, Ended("succeeded", "It is there")), (warned_s, Log("warning", "a warning"))]
    shown = story(snapshot, *sorted(lines, key=lambda each: each[0]))

    assert "SUCCEEDED: It is there" in said(shown)[-1]


def test_an_end_that_says_its_cause_is_enough(snapshot: Snapshot) -> None:
    ended = Ended("fault", "firmware.reset: the controller was reset")
    (line,) = said(story(snapshot, (1.0, FAULT), (1.5, ended)))

    assert "FAULT: firmware.reset: the controller was reset" in line


def test_what_is_acknowledged_makes_room_for_the_next_one_and_stays_in_the_list(
    snapshot: Snapshot,
) -> None:
    both = story(snapshot, (1.0, FAULT), (1.5, Log("warning", "a consequence")))
    shown = {each.entry.number for each in alarms.pending(both, ())}

    assert "a consequence" in said(both, shown)[0]
    assert [each.seen for each in alarms.alarms(both, shown)] == [True, False]


@pytest.mark.parametrize(("times", "cut"), [(18, False), (60, True)])
def test_an_alarm_is_shown_in_full_unless_it_is_very_long_and_the_keys_always(
    snapshot: Snapshot, times: int, cut: bool
) -> None:
    shown = story(snapshot, (1.0, Log("warning", "very long " * times)))
    lines = [each.plain for each in alarms.bar(shown, (), 80)]

    assert max(map(len, lines)) <= 80
    assert ("…" in "".join(lines)) == cut
    assert cut or " ".join(lines).split().count("long") == times
    assert "(Esc: seen, !: all)" in lines[-1]
    assert len(lines) <= 4
    assert alarms.alarms(shown, ())[0].text == "warning: " + "very long " * times


# --- what the robot may be doing while nothing is heard -------------------------------------------


@pytest.mark.parametrize(
    ("health", "words"),
    [
        (link(), "no word for 2.5 s; wheels may be turning: cut power"),
        (
            link(stops_s=4.0),
            "wheels may be turning, for 1.5 s until its dead man's switch stops it",
        ),
        (link(stops_s=1.0), "its dead man's switch has stopped the wheels, unless its controller"),
        (link(stopped=True), "a joint may be moving: cut power"),  # a command is under way
    ],
)
def test_a_silence_says_what_the_robot_may_be_doing(
    snapshot: Snapshot, health: LinkHealth, words: str
) -> None:
    text = " ".join(each.strip() for each in said(replace(snapshot, link=health)))

    assert words in text
    assert "nothing comes from the robot" in text


def test_a_silence_in_which_nothing_was_asked_for_is_no_danger(snapshot: Snapshot) -> None:
    assert snapshot.state is not None
    resting = snapshot.state._replace(robot=snapshot.state.robot._replace(motion=None))
    silent = replace(snapshot, state=resting, link=link(stopped=True))

    assert "no word for 2.5 s; its wheels stood when it was last heard" in said(silent)[0]


def test_a_stop_says_for_how_long_it_waits_for_a_link_that_is_away(snapshot: Snapshot) -> None:
    running = replace(snapshot, link=link())
    assert running.state is not None
    mission = running.state.mission._replace(ending=Ended("interrupted", "Ctrl-C"))
    stopping = replace(running, state=running.state._replace(mission=mission))

    assert "a stop waits for it" not in said(running)[0]
    assert "a stop waits for it, given up in 8 s" in said(stopping)[0]


def test_a_run_that_does_not_answer_is_no_present_moment(snapshot: Snapshot) -> None:
    held = replace(snapshot, held_s=2.0)

    assert said(held) == [
        " ⚠ this program has not looked at the robot for 2.0 s; wheels may be turning: cut power "
    ]
    assert panels.header(held, 80).plain.startswith(" ? ")


# --- once a stop was applied ----------------------------------------------------------------------


def test_the_header_says_that_a_stop_was_applied_until_a_command_is_sent(
    snapshot: Snapshot,
) -> None:
    assert snapshot.state is not None
    paused = snapshot.state.mission._replace(paused_s=0.0)
    memory = Memory(snapshot.scene.robot)
    memory.see([Ended("interrupted", "stopped by the operator")], 1.0)
    memory.begin(snapshot.scene.robot)
    stood = replace(snapshot, state=snapshot.state._replace(mission=paused), story=memory.story)
    memory.see([CommandStatus("Any", "sent")], 2.0)

    assert panels.header(stood, 80).plain.startswith(" ■ STOPPED, PAUSED ")
    assert panels.header(replace(stood, story=memory.story), 80).plain.startswith(" ‖ PAUSED ")
    memory.see([Ended("fault", "link.silent: nothing comes")], 3.0)
    memory.begin(snapshot.scene.robot)
    failed = replace(stood, story=memory.story)
    assert panels.header(failed, 80).plain.startswith(" ■ STOPPED (FAULT), PAUSED ")


def test_a_link_that_is_closed_is_not_called_good(snapshot: Snapshot) -> None:
    healthy = replace(snapshot, link=link()._replace(trouble=""))

    assert panels.link(healthy)[0].plain == "● good"
    assert panels.link(replace(healthy, over=True))[0].plain == "■ closed"

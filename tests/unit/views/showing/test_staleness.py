"""What was so once is never shown as what is so now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isnan, nan

import pytest
from rich.text import Text

from pirate_sm.core._engine.robot.robot_state import DENIED
from pirate_sm.core.effects import Fault
from pirate_sm.core.robot import STOPPED, Mark
from pirate_sm.robot.backends.serial.link.health import LinkHealth
from pirate_sm.views.console.availability import UNHEARD, command_reason, controls, drive_doubt
from pirate_sm.views.showing import body_panel, panels
from pirate_sm.views.showing.picture import draw, pose_of
from pirate_sm.views.showing.snapshot import Snapshot, Trends
from pirate_sm.views.showing.text_styles import MUTED, STALE, ago

from .test_panels import after, beginning

SILENT_S = 3.2


@pytest.fixture(scope="module")
def live() -> Snapshot:
    return beginning("mitre_bend", "sim")


@pytest.fixture(scope="module")
def silent(live: Snapshot) -> Snapshot:
    health = LinkHealth(9, 0, 3, 0, 0, nan, SILENT_S, "nothing comes", 7.6, stopped=False)
    return replace(live, link=health)


def words(lines: list[Text]) -> str:
    return "\n".join(each.plain for each in lines)


VIEWS: dict[str, Callable[[Snapshot], list[Text]]] = {
    "states": lambda it: panels.states(it, 44),
    "motors": lambda it: body_panel.body(it, 90),
    "angles": lambda it: body_panel.briefly(it, 90),
    "speed": body_panel.travelled,
}


@pytest.mark.parametrize("name", VIEWS)
def test_nothing_is_marked_while_the_robot_reports(live: Snapshot, name: str) -> None:
    assert STALE not in words(VIEWS[name](live))


@pytest.mark.parametrize("name", VIEWS)
def test_every_value_of_a_robot_that_is_silent_is_grey_and_marked_with_its_age(
    silent: Snapshot, name: str
) -> None:
    for shown in VIEWS[name](silent):
        if "at wall" in shown.plain or not any(map(str.isdigit, shown.plain)):
            continue
        assert STALE in shown.plain
        assert "3s" in shown.plain
        assert {str(span.style) for span in shown.spans} == {MUTED}


def test_a_state_becomes_a_question(live: Snapshot, silent: Snapshot) -> None:
    count = len(live.scene.robot.regions)

    assert "?" not in words(panels.states(live, 44))
    assert all(each.plain.startswith("? ") for each in panels.states(silent, 44)[:count])
    assert panels.header(silent, 80).plain.startswith(" ? RUNNING ")


def test_a_state_of_an_earlier_connection_is_a_question(live: Snapshot) -> None:
    assert live.state is not None
    sensing = live.state.sensing._replace(connection=live.state.sensing.connection + 1)
    again = replace(live, state=live.state._replace(sensing=sensing))

    assert panels.states(again, 44)[0].plain.startswith("? ")


def test_a_state_that_a_fault_speaks_against_is_a_question_until_it_is_shown_again(
    live: Snapshot,
) -> None:
    rules = live.scene.robot.faults
    dead = next(rule for rule in rules if rule.code == "wheel.dead")
    faulty = after(live, Fault(dead.code, dead.message, "continue", dead.of))

    narrow = words(panels.states(faulty, 40))
    assert narrow.startswith("? FrontWheels Free ")
    assert f"{dead.code}: {dead.message}" in " ".join(narrow.split())
    assert max(map(len, narrow.splitlines())) <= 40
    assert dead.message in words(panels.states(faulty, 200))
    assert "Bending" not in "".join(faulty.doubts)
    assert drive_doubt(faulty, "DriveForward") == f"{dead.code}: {dead.message}"
    assert drive_doubt(faulty, "Brake") == ""
    assert drive_doubt(replace(faulty, ahead_s=-9.0), "DriveForward") == ""  # shown since


def test_a_clamp_that_is_denied_is_not_confirmed(live: Snapshot) -> None:
    assert live.state is not None
    body, robot = live.state.robot, live.scene.robot
    held = next(at for at, parts in enumerate(robot.held) if parts)
    (part, *_) = robot.held[held]
    mark = frozenset({Mark("part", part, DENIED)})
    denied = body._replace(configuration=held, marks=mark)
    shown = words(panels.states(replace(live, state=live.state._replace(robot=denied)), 44))

    for region in robot.part_regions[part]:
        assert shown.splitlines()[region].startswith("○")


def test_the_robot_is_drawn_as_last_heard_and_touches_nothing(
    live: Snapshot, silent: Snapshot
) -> None:
    assert pose_of(silent).origin == "as last heard 3s ago"
    assert set(pose_of(silent).touching) == {-1}
    assert "?" in panels.states(silent, 44)[len(live.scene.robot.regions)].plain
    assert dots(silent) < dots(live)


def dots(snapshot: Snapshot) -> int:
    letters = "".join(each.plain for each in draw(snapshot, 60, 12).rows())
    return sum(bin(ord(each) - 0x2800).count("1") for each in letters if ord(each) >= 0x2800)


def test_a_silent_board_makes_its_values_old_and_leaves_the_others(live: Snapshot) -> None:
    assert live.state is not None
    robot, sensing = live.scene.robot, live.state.sensing
    late_s = live.engine_s + 10 * robot.link.stale_after_s
    heard_s = (sensing.heard_s[0], *(late_s for _ in sensing.heard_s[1:]))
    state = live.state._replace(sensing=sensing._replace(heard_s=heard_s))
    one = replace(live, state=state, now_s=late_s)
    first, *others = body_panel.body(one, 90)[: len(live.scene.anatomy.joints)]

    assert "no report for 5s" in first.plain
    assert STALE not in words(others)


def test_nothing_can_be_asked_for_while_the_robot_is_silent(
    live: Snapshot, silent: Snapshot
) -> None:
    command = live.scene.robot.commands[0].name

    assert command_reason(silent, command) == UNHEARD
    assert command_reason(live, command) != UNHEARD
    reasons = {each.name: each.reason for each in controls(silent, None)}
    assert reasons["pause"] == ""  # the wheels are stopped as soon as it is heard again


def test_what_was_stopped_is_commanded_and_not_sent(live: Snapshot) -> None:
    assert live.state is not None
    body = live.state.robot._replace(marks=frozenset({Mark("region", 0, STOPPED)}))
    stopped = replace(live, state=live.state._replace(robot=body))
    first = panels.states(stopped, 60)[0].plain

    assert first.startswith("■ ")
    assert "commanded: " in first
    assert "; sent: 0" in first


@pytest.mark.parametrize(
    ("age_s", "text"), [(0.4, "0s"), (59.9, "59s"), (61, "1m"), (7200, "2h"), (nan, "")]
)
def test_an_age_has_its_largest_unit(age_s: float, text: str) -> None:
    assert ago(age_s) == text


def test_a_signal_that_was_not_known_is_a_gap_in_its_trend(live: Snapshot) -> None:
    assert live.state is not None
    trends = Trends()
    trends.look(live.scene, live.state, 0.0)
    blind = live.state.sensing._replace(numbers=(nan,) * len(live.state.sensing.numbers))
    trends.look(live.scene, live.state._replace(sensing=blind), 1.0)
    motor = live.scene.anatomy.motors[0]
    before, after = trends.latest[motor.current or motor.value]

    assert not isnan(before)
    assert isnan(after)


def test_after_the_end_nothing_is_live_and_nobody_knows_how_old_it_is(silent: Snapshot) -> None:
    assert silent.link is not None
    over = replace(silent, link=silent.link._replace(trouble=""), over=True)

    assert panels.states(over, 44)[0].plain.startswith("? ")
    assert "as last reported" in body_panel.body(over, 90)[0].plain
    assert pose_of(over).origin == "as last heard"

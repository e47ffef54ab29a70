"""Safety rules: the command that would break one is not sent; what breaks one ends the mission."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from driving import Driver, changed_newt, command, driver_of, write_mission

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.consequences import watch_rules
from pirate_sm.core._engine.moment import Moment

OLD_RULES = """\
  - rule: never_let_go
    after: clamps > 0
    never: clamps == 0
    waived_by: allow_unclamp
"""

Ruled = Callable[..., Driver]


@pytest.fixture
def ruled(tmp_path: Path) -> Ruled:
    """A driver of the small robot with one rule, and a mission of these commands."""

    def start(rule: str, *commands: str, head: str = "", nominal: bool = True) -> Driver:
        robot = changed_newt(tmp_path, (OLD_RULES, f"  - {{rule: one, {rule}}}\n"))
        body = (
            f"{head}start: p\nphases: {{p: {{do: [{', '.join(commands)}], go: good}}}}\n"
            "ends: {good: {succeed: Good}}\n"
        )
        return driver_of(write_mission(tmp_path, body, robot), nominal=nominal)

    return start


def finish(driver: Driver) -> list[str]:
    """The commands that were done until the mission ended."""
    for _ in range(60):
        if driver.ended:
            break
        if driver.in_flight:
            driver.accept()
        else:
            driver.tick(driver.wake_at)
    assert driver.ended
    return [name for name, status in driver.statuses if status == "done"]


@pytest.mark.parametrize(
    ("rule", "commands", "done"),
    [
        ("never: clamps == 2", ["HoldNose", "HoldTail"], ["HoldNose"]),
        ("always: clamps < 2", ["HoldNose", "HoldTail"], ["HoldNose"]),
        ("after: Lamp == Lit, never: clamps == 1", ["HoldNose", "SwitchLamp"], ["HoldNose"]),
        (
            "never: command == HoldTail",
            ["HoldNose", "SwitchLamp", "HoldTail"],
            ["HoldNose", "SwitchLamp"],
        ),
        (
            "always: 'command in (HoldNose, SwitchLamp)'",
            ["HoldNose", "SwitchLamp", "HoldTail"],
            ["HoldNose", "SwitchLamp"],
        ),
        (
            "after: clamps == 1, expect: clamps == 2, within_steps: 2",
            ["HoldNose", "SwitchLamp", "SwitchLamp"],
            ["HoldNose", "SwitchLamp"],
        ),
    ],
)
def test_the_command_that_would_break_a_rule_is_not_sent(
    ruled: Ruled, rule: str, commands: list[str], done: list[str]
) -> None:
    driver = ruled(rule, *commands)

    assert finish(driver) == done
    assert driver.faults == [("rule.violated", "stop")]
    assert driver.ended is not None
    assert f"{commands[len(done)]} (" in driver.ended.message
    assert [name for name, status in driver.statuses if status == "sent"] == done


@pytest.mark.parametrize(
    ("rule", "commands"),
    [
        ("after: Lamp == Lit, never: clamps == 1", ["HoldNose", "HoldTail", "SwitchLamp"]),
        ("never: command == Home", ["HoldNose", "SwitchLamp"]),
        (
            "after: clamps == 1, expect: clamps == 2, within_steps: 2",
            ["HoldNose", "SwitchLamp", "HoldTail"],
        ),
    ],
)
def test_what_keeps_the_rule_runs_to_its_end(ruled: Ruled, rule: str, commands: list[str]) -> None:
    driver = ruled(rule, *commands)

    assert finish(driver) == commands
    assert driver.faults == []


def test_a_rule_counts_a_command_that_is_done_as_it_is_accepted(ruled: Ruled) -> None:
    """With sensors SwitchLamp is done at once: the next command knows that it has been."""
    rule = "after: Lamp == Lit, expect: Lamp == Dark, within_steps: 1"
    driver = ruled(rule, "SwitchLamp", "HoldNose", nominal=False)
    driver.accept()

    assert ("HoldNose", "sent") not in driver.statuses
    assert driver.faults == [("rule.violated", "stop")]


def test_no_clamp_is_waited_for_that_would_not_keep_the_rule(ruled: Ruled) -> None:
    driver = ruled("never: command == HoldTail", "HoldNose", nominal=False)
    robot, body = driver.robot, driver.state.robot
    assert body.motion is not None
    index = robot.table.command_index["HoldTail"]
    target = robot.table.follow(body.configuration, index)
    assert target is not None
    motion = body.motion._replace(command=index)
    accepted = body._replace(configuration=target, motion=motion)
    moment = Moment(robot, driver.engine.program, False, driver.now)

    state = watch_rules(moment, driver.state, driver.state._replace(robot=accepted))

    assert [each.code for each in moment.effects if isinstance(each, fx.Fault)] == ["rule.violated"]
    assert not state.mission.pause_wanted


def test_a_mission_that_says_why_may_break_the_rule(ruled: Ruled) -> None:
    rule = "after: clamps > 0, never: clamps == 0, waived_by: allow_unclamp"
    driver = ruled(rule, "HoldNose", "Home", head="allow_unclamp: on a table\n")

    assert finish(driver) == ["HoldNose", "Home"]


def test_what_the_operator_commands_is_told_and_the_mission_goes_on(
    tmp_path: Path,
) -> None:
    robot = changed_newt(tmp_path, (OLD_RULES, "  - {rule: one, never: clamps == 1}\n"))
    body = (
        "start: p\nphases: {p: {wait: [{operator: stop, go: good}], "
        "within: {time: 1 h, go: good}}}\nends: {good: {succeed: Good}}\n"
    )
    driver = driver_of(write_mission(tmp_path, body, robot), nominal=True)
    command(driver, "HoldNose")
    driver.accept()
    assert any("by hand, violates rule one" in each.message for each in driver.of(fx.Log))
    assert driver.ended is None

    driver.tick(driver.wake_at)
    assert ("HoldNose", "done") in driver.statuses
    told = len(driver.of(fx.Log))
    command(driver, "SwitchLamp")
    assert len(driver.of(fx.Log)) == told, "it is another command that has broken it"

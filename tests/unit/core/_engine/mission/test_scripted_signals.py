"""What a script says in the place of sensors, in a run where commands take their nominal time."""

from __future__ import annotations

from collections.abc import Callable
from math import isnan

import pytest
from driving import NEWT, Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._model.events import CommandFailed, SignalReport

WAITING = """\
start: look
phases:
  look:
    do: [HoldNose]
    wait:
      - {when: way > 50 mm, go: far}
      - {when: detector == near, held: 1 s, go: near}
    within: {time: 10 s, go: never}
ends: {far: {succeed: Far}, near: {succeed: Near}, never: {fail: Never}}
"""

Drive = Callable[..., Driver]


@pytest.fixture
def waiting(drive: Drive) -> Driver:
    driver = drive(WAITING, NEWT, nominal=True)
    driver.accept()
    driver.tick(driver.wake_at)
    assert driver.statuses[-1] == ("HoldNose", "done")
    return driver


def test_a_report_counts_with_the_next_event(waiting: Driver) -> None:
    assert waiting.give(SignalReport((("way", 0.06),))) == []
    assert waiting.fired == []

    waiting.tick(waiting.now)
    assert waiting.fired == ["far"]


def test_what_is_not_reported_stays_as_it_was(waiting: Driver) -> None:
    waiting.give(SignalReport((("way", 0.02),), (("detector", "near"),)))
    waiting.tick(waiting.now)
    waiting.give(SignalReport((("hip", 0.5),)))
    waiting.tick(waiting.now + 1.0)

    assert waiting.fired == ["near"]
    assert waiting.engine.signals(waiting.state)["way"] == 0.02


def test_unknown_can_be_reported(waiting: Driver) -> None:
    waiting.give(SignalReport((("way", 0.06), ("way", float("nan")))))

    assert isnan(waiting.engine.signals(waiting.state)["way"])


def test_position_loops_do_not_go_by_what_a_script_says(drive: Drive) -> None:
    """Nothing moves: the array is the same whatever conditions see."""
    body = "allow_unclamp: on a table\nstart: p\nphases: {p: {do: [HoldNose, Home], go: good}}\n"
    arrays = []
    for shown in ((), (("neck", 1.0), ("hip", -1.0))):
        driver = drive(f"{body}ends: {{good: {{succeed: ok}}}}\n", NEWT, nominal=True)
        driver.give(SignalReport(shown))
        driver.accept()
        driver.tick(driver.wake_at)
        arrays.append(driver.setpoints)

    assert driver.statuses[-1] == ("Home", "sent")
    assert arrays[0] == arrays[1]


@pytest.mark.parametrize(
    ("report", "said"),
    [
        (SignalReport((("wy", 1.0),)), "'wy', an unknown signal"),
        (SignalReport((), (("Grip", "Loose"),)), "'Grip', which no script can set"),
    ],
)
def test_what_a_script_cannot_say_is_reported(
    waiting: Driver, report: SignalReport, said: str
) -> None:
    (line,) = waiting.give(report)

    assert isinstance(line, fx.Log)
    assert said in line.message


def test_where_sensors_speak_they_alone_are_believed(drive: Drive) -> None:
    driver = drive(WAITING, NEWT)

    (line,) = driver.give(SignalReport((("way", 0.06),)))

    assert isinstance(line, fx.Log)
    assert driver.engine.signals(driver.state)["way"] == 0


def test_a_command_under_way_fails_when_the_script_says_so(drive: Drive) -> None:
    driver = drive(WAITING, NEWT, nominal=True)
    driver.accept()
    driver.give(CommandFailed("because"))

    assert driver.statuses[-1] == ("HoldNose", "failed")
    assert "Grip" in driver.unconfirmed


SWITCHING = """\
start: p
phases:
  p: {do: [{control: exp_3a, on_failure: bad}], go: good}
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
ends: {good: {succeed: ok}, bad: {fail: "{cause}"}}
"""


def test_a_control_fails_when_the_script_says_so(drive: Drive) -> None:
    driver = drive(SWITCHING, nominal=True)
    assert driver.give(CommandFailed("because")) == []

    driver.accept()

    assert driver.state.mission.ending.end == "bad"
    assert "did not bear the torque within 10 s" in driver.state.mission.ending.message


def test_nothing_fails_while_its_array_is_in_flight(drive: Drive) -> None:
    driver = drive(WAITING, NEWT, nominal=True)

    (line,) = driver.give(CommandFailed("because"))

    assert isinstance(line, fx.Log)
    assert driver.statuses == [("HoldNose", "sent")]

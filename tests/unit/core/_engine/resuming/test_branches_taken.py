"""Which branches a resumed run takes, as the engine notes them."""

from __future__ import annotations

import pytest
from cut_off import GRIPPING, CutOff
from driving import BOTH_CLAMPED, Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.mission.program import BranchKey
from pirate_sm.core._model import events as ev
from pirate_sm.core.branches import branches

MISSION = """\
start: approach
on_failure: unclear
phases:
  approach: {do: [{ask: "Near?"}], go: measure}
  measure:
    resume: approach
    do: [DriveForward, {ask: "Go on?"}]
    go: done
  unclear: {do: [{command: Brake, unneeded: skip}], go: unsure}
ends:
  done: {succeed: There}
  unsure: {fail: "{cause}"}
"""


def asked(drive, questions: int) -> Driver:
    """The mission has asked so many questions, and waits for the answer to the last one."""
    driver = drive(MISSION, states=BOTH_CLAMPED)
    driver.signals |= GRIPPING
    driver.run(0.4)
    for number in range(1, questions + 1):
        driver.until(lambda seen, number=number: len(seen.of(fx.Ask)) >= number)
        if number < questions:
            driver.give(ev.Answer("yes"))
    return driver


def declared(driver: Driver) -> dict[BranchKey, str]:
    commands = tuple(each.name for each in driver.robot.commands)
    return {key: it.leads for key, it in branches(driver.engine.program, commands).items()}


def kinds(driver: Driver) -> list[str]:
    return [each.kind for each in driver.taken]


def test_resume_is_taken_where_the_interrupted_phase_says_so(drive) -> None:
    driver = CutOff(asked(drive, 2)).go_on()
    driver.accept()
    driver.run(4.0)

    assert driver.phases[0] == "approach"
    assert kinds(driver) == ["resume"]
    assert set(driver.taken) <= declared(driver).keys()


@pytest.mark.parametrize(
    ("questions", "at"), [(1, "here"), (1, "approach"), (2, "approach"), (2, "failure")]
)
def test_resume_is_not_taken_in_the_same_phase_or_where_a_person_says(
    drive, questions: int, at: str
) -> None:
    driver = CutOff(asked(drive, questions)).go_on(at)
    driver.accept()
    driver.run(4.0)

    assert driver.phases
    assert "resume" not in kinds(driver)


def regripping(drive) -> Driver:
    """The resumed run closes a clamp again that is not seen to hold, before it continues."""
    loose = {name: 0.3 * nm / abs(nm) for name, nm in GRIPPING.items() if "torque" in name}
    driver = CutOff(asked(drive, 1)).go_on(**loose)
    driver.accept()
    driver.run(4.0)
    assert driver.statuses == [("ClampFront", "sent")]
    return driver


def test_a_resumed_run_has_the_branches_of_its_mission_and_no_others(drive) -> None:
    driver = regripping(drive)

    assert declared(driver) == declared(drive(MISSION, states=BOTH_CLAMPED))


def test_a_failure_of_a_command_that_a_resumed_run_gives_first_is_no_branch(drive) -> None:
    driver = regripping(drive)
    driver.accept("rejected", "said by a test")
    driver.until(lambda seen: "unclear" in seen.phases)

    assert kinds(driver) == []

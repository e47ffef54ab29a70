"""What a mission that goes on depends on and nobody knows."""

from __future__ import annotations

from dataclasses import replace
from math import nan, radians
from types import SimpleNamespace

import pytest
from cut_off import GRIPPING, CutOff
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, REAR_CLAMPED, Driver

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.mission.program import Program, Wait
from pirate_sm.core._engine.resuming.resumption import (
    Resumption,
    position_read,
    resumption,
    unknowns,
)
from pirate_sm.core._model import events as ev

READING = """\
start: ask
phases:
  ask:
    do: [{ask: "Go on?", choices: {"on": continue}}]
    go: work
  work:
    do: [DO]
    wait: [{when: WHEN, go: done}]
    within: {time: 60 s, go: done}
  aside:
    wait: [{when: odometry >= 2 m, go: done}]
    within: {time: 60 s, go: done}
ends: {done: {succeed: There}}
"""


def asking(drive, when: str, do: str = "") -> Driver:
    driver = drive(READING.replace("WHEN", when).replace("DO", do), states=BOTH_CLAMPED)
    driver.signals |= GRIPPING
    driver.run(0.4)
    assert driver.of(fx.Ask)
    return driver


def found(driver: Driver, driven_s: float = 0.4, **signals: float) -> tuple[Resumption, list[str]]:
    """With what the mission goes on, and what nobody knows, up to the first bracket."""
    cut = CutOff(driver, driven_s)
    seen = cut.look(**signals)
    way = seen.way
    if driven_s:
        way = way._replace(low_m=-0.1, high_m=0.1, exact=False)
    it = resumption(cut.robot, cut.program, cut.last, cut.last_s, cut.recorded, way)
    assert isinstance(it, Resumption)
    program = it.program(cut.program)
    position = it.unknown_position(cut.robot, program)
    told = (*unknowns(cut.robot, program, seen.tables[0]), *([position] if position else []))
    return it, [each.partition(" (")[0] for each in told]


POSITION = "the position: the mission reads it"


@pytest.mark.parametrize(
    ("when", "do", "read"),
    [
        ("odometry >= 1 m", "", True),
        ("change(odometry) >= 1 m", "", False),
        ("theta_1 >= 1 rad", "", False),
        ("theta_1 >= 1 rad", "{command: ToggleLighting, if: odometry >= 1 m}", True),
        ("theta_1 >= 1 rad", "{command: ToggleLighting, if: theta_1 >= 1 rad}", False),
    ],
)
def test_an_unknown_position_counts_where_the_rest_of_the_mission_reads_it(
    drive, when: str, do: str, read: bool
) -> None:
    driver = asking(drive, when, do)

    assert (POSITION in found(driver)[1]) == read
    assert POSITION not in found(driver, driven_s=0.0)[1]


def test_the_place_of_what_reads_it_is_reported(drive) -> None:
    driver = asking(drive, "odometry >= 1 m")
    it, _ = found(driver)
    program = it.program(driver.engine.program)

    places = [place for _, place in position_read(driver.robot, program, ())]

    assert places
    assert {place.rpartition("/")[2] for place in places} == {"m.yaml:11:12"}
    assert list(position_read(replace(driver.robot, odometry=-1), program, ())) == []


@pytest.mark.parametrize(("driven_s", "read"), [(0.4, True), (0.0, False)])
def test_a_change_that_counts_on_from_an_unknown_position_reads_it(
    drive, driven_s: float, read: bool
) -> None:
    driver = asking(drive, "change(odometry) >= 1 m")
    driver.give(ev.Answer("on"))
    driver.until_waiting("work")
    driver.run(driver.now + 1.0)
    assert driver.state.mission.origin

    assert (POSITION in found(driver, driven_s)[1]) == read


def test_a_later_change_counts_from_where_its_own_wait_begins(drive) -> None:
    driver = asking(drive, "change(odometry) >= 1 m")
    instructions = driver.engine.program.instructions
    origin = (nan,) * len(driver.state.sensing.numbers)

    def read(counts_on: bool, origin: tuple[float, ...]) -> bool:
        counted = tuple(
            each._replace(counts_on=counts_on) if isinstance(each, Wait) else each
            for each in instructions
        )
        program = replace(driver.engine.program, instructions=counted)
        return bool(list(position_read(driver.robot, program, origin)))

    assert read(True, origin)
    assert not read(False, origin)
    assert not read(True, ())
    assert not read(True, (0.0,) * len(origin))


def test_a_wait_for_something_else_does_not_read_the_position(drive) -> None:
    driver = asking(drive, "theta_1 >= 1 rad")
    program = driver.engine.program
    counting = tuple(
        each._replace(counts_on=True) if isinstance(each, Wait) else each
        for each in program.instructions
    )
    origin = (nan,) * len(driver.state.sensing.numbers)

    assert not list(position_read(driver.robot, replace(program, instructions=counting), origin))


def test_a_mission_that_begins_again_is_read_once(drive) -> None:
    again = READING.replace("DO", "").replace("WHEN, go: done", "theta_1 >= 1 rad, go: ask")
    again = again.replace(
        '    do: [{ask: "Go on?", choices: {"on": continue}}]\n    go: work\n',
        "    wait: [{when: odometry >= 1 m, go: work}]\n    within: {time: 9 s, go: work}\n",
    )
    driver = drive(again, states=BOTH_CLAMPED)
    program = driver.engine.program
    work = next(at for at, phase in enumerate(program.phase_of) if phase == "work")

    assert len(list(position_read(driver.robot, replace(program, start=work), ()))) == 1


@pytest.mark.parametrize("index", [0, 1])
def test_an_odometry_of_any_place_is_read(drive, index: int) -> None:
    driver = asking(drive, "odometry >= 1 m")
    program = driver.engine.program
    name = driver.robot.vocabulary.numbers[index]

    def reading(*names: str) -> Program:
        """The program whose waits have no place of their own and read these signals."""
        condition = SimpleNamespace(names=frozenset(names))
        instructions = tuple(
            each._replace(
                place="m.yaml:9:9",
                triggers=tuple(t._replace(condition=condition, place="") for t in each.triggers),
            )
            if isinstance(each, Wait)
            else each
            for each in program.instructions
        )
        return replace(program, instructions=instructions)

    robot = replace(driver.robot, odometry=index)
    assert {place for _, place in position_read(robot, reading(name), ())} == {"m.yaml:9:9"}
    without, last = replace(robot, odometry=-1), robot.vocabulary.numbers[-1]
    assert list(position_read(without, reading(last), ())) == []


def test_a_part_that_is_not_seen_to_hold_is_unknown_and_a_light_is_not(drive) -> None:
    driver = asking(drive, "theta_1 >= 1 rad")

    assert found(driver, driven_s=0.0)[1] == []
    _, told = found(driver, driven_s=0.0, bend_torque_1=-0.3)
    assert [each.partition(":")[0] for each in told] == ["front holds"]


def test_an_angle_that_is_not_seen_is_unknown(drive) -> None:
    states = REAR_CLAMPED | {"BendingState": "RearClampedFrontBending"}
    driver = drive(IDLE, states=states)
    driver.signals |= GRIPPING | {"gamma_1": radians(-45), "gamma_2": radians(-45)}
    driver.run(0.4)

    assert found(driver, driven_s=0.0)[1] == []
    _, told = found(driver, driven_s=0.0, gamma_2=nan)
    assert [each.partition(":")[0] for each in told] == ["BendingState RearClampedFrontBending"]


def test_what_the_command_under_way_brings_about_is_not_unknown(drive) -> None:
    driver = drive(
        IDLE.replace("    wait:", "    do: [ClampRear]\n    wait:"), states=FRONT_CLAMPED
    )
    driver.signals |= GRIPPING | {"bend_torque_4": 0.0}
    driver.run(0.4)
    driver.accept()
    assert driver.statuses == [("ClampRear", "sent"), ("ClampRear", "accepted")]

    assert found(driver, driven_s=0.0)[1] == []

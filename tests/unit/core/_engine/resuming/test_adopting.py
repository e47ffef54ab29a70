"""In which states a robot is adopted that nobody has recorded."""

from __future__ import annotations

from math import inf

import pytest
from driving import IDLE, Driver

from pirate_sm.core._engine.resuming.hypotheses import Hypothesis
from pirate_sm.core._engine.resuming.reconciling import (
    Reconciled,
    StateVerdict,
    VerdictTable,
    Word,
    adoptable,
)
from pirate_sm.core._engine.robot.declared_states import declared_in
from pirate_sm.core._engine.robot.robot_state import DECLARED, Mark
from pirate_sm.core._engine.unwatched import DarkWay

NEWT = "tests/robots/newt"
DECLARED_STATES = ("Loose", "Resting", "Dark")


@pytest.fixture
def robot(drive):
    driver: Driver = drive(IDLE, NEWT)
    assert tuple(driver.robot.regions) == ("Grip", "Crawl", "Lamp")
    return driver.robot


def table(robot, states: tuple[str, ...], words: dict[str, Word], *refusals: str) -> VerdictTable:
    """What the sensors are taken to show of these states."""
    at = robot.table.configurations.index(states)
    verdicts = tuple(
        StateVerdict(Mark("region", which, DECLARED), name, states[which], words[name], "", ())
        for which, name in enumerate(robot.regions)
        if name in words
    )
    return VerdictTable(Hypothesis("adopted", declared_in(robot, at)), verdicts, refusals)


def seen(*tables: VerdictTable, turning: bool = False) -> Reconciled:
    way = DarkWay(-inf, inf, False, "")
    return Reconciled(tables, None, (), (), (), turning, way, ())


def states_of(robot, found: tuple[VerdictTable, ...]) -> list[tuple[str, ...]]:
    return [robot.table.configurations[each.hypothesis.body.configuration] for each in found]


@pytest.fixture
def declared(robot) -> VerdictTable:
    return table(robot, DECLARED_STATES, {"Grip": "contradicted", "Crawl": "confirmed"})


def test_a_robot_may_stand_in_every_configuration_that_drives_no_wheel(robot):
    at = robot.table.configurations.index(("NoseHeld", "Resting", "Lit"))

    found = adoptable(robot, at)

    assert {each.name for each in found} == {"adopted"}
    numbers = [each.body.configuration for each in found]
    standing = {n for n in range(len(robot.table.configurations)) if not robot.driven[n]}
    assert numbers[0] == at
    assert sorted(numbers) == sorted(standing)
    assert 0 < len(standing) < len(robot.table.configurations)
    assert all(mark.command == DECLARED for each in found for mark in each.body.marks)


def test_what_is_declared_is_looked_at_first_although_it_drives_wheels(robot):
    driven = next(n for n in range(len(robot.table.configurations)) if robot.driven[n])

    first, *others = adoptable(robot, driven)

    assert first.body.configuration == driven
    assert not any(robot.driven[each.body.configuration] for each in others)


def test_what_nothing_contradicts_stays_declared(robot):
    declared = table(robot, DECLARED_STATES, {"Grip": "unknown"})
    other = table(robot, ("NoseHeld", "Resting", "Dark"), {"Grip": "confirmed"})

    assert seen(declared, other).shown_instead(robot) == ()


def test_while_a_wheel_turns_nothing_is_adopted(robot, declared):
    other = table(robot, ("NoseHeld", "Resting", "Dark"), {"Grip": "confirmed"})

    assert seen(declared, other).shown_instead(robot) == (other,)
    assert seen(declared, other, turning=True).shown_instead(robot) == ()


def test_the_configuration_counts_of_which_most_is_confirmed(robot, declared):
    less = table(robot, ("NoseHeld", "Resting", "Dark"), {"Crawl": "confirmed"})
    most = table(robot, ("TailHeld", "Resting", "Lit"), {"Crawl": "confirmed", "Grip": "confirmed"})

    assert seen(declared, less, most).shown_instead(robot) == (most,)
    assert seen(declared, most, less).shown_instead(robot) == (most,)


def test_where_neither_confirms_all_that_the_other_does_a_person_chooses(robot, declared):
    grip = table(robot, ("NoseHeld", "Resting", "Dark"), {"Grip": "confirmed"})
    crawl = table(robot, ("TailHeld", "Resting", "Lit"), {"Crawl": "confirmed"})

    assert seen(declared, grip, crawl).shown_instead(robot) == (grip, crawl)


def test_what_sensors_cannot_tell_apart_is_taken_as_declared(robot, declared):
    dark = table(robot, ("NoseHeld", "Resting", "Dark"), {"Grip": "confirmed"})
    lit = table(robot, ("NoseHeld", "Resting", "Lit"), {"Grip": "confirmed"})
    tail = table(robot, ("TailHeld", "Resting", "Dark"), {"Grip": "confirmed"})

    found = seen(declared, lit, dark, tail).shown_instead(robot)

    assert states_of(robot, found) == [
        ("NoseHeld", "Resting", "Dark"),
        ("TailHeld", "Resting", "Dark"),
    ]


@pytest.mark.parametrize(
    ("words", "refusals"),
    [
        ({"Grip": "confirmed", "Crawl": "contradicted"}, ()),
        ({"Grip": "confirmed", "Crawl": "confirmed"}, ("robot.fallen: it falls",)),
    ],
)
def test_what_is_contradicted_or_refused_is_not_adopted(robot, declared, words, refusals):
    bad = table(robot, ("NoseHeld", "Resting", "Dark"), words, *refusals)
    good = table(robot, ("TailHeld", "Resting", "Dark"), {"Crawl": "confirmed"})

    assert seen(declared, bad, good).shown_instead(robot) == (good,)
    assert seen(declared, bad).shown_instead(robot) == ()

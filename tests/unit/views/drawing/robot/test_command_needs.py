"""What is said of a command holds in every configuration, and says no more than it must."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core._engine.robot.command_outcome import refusal
from pirate_sm.core._engine.robot.robot_state import at_rest_in
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.views.drawing import command_needs
from pirate_sm.views.drawing.command_needs import changes, needs, taken_in

ROOT = Path(__file__).resolve().parents[5]


@pytest.fixture(scope="module", params=["hardware_profiles/pirate_ii", "tests/robots/newt"])
def robot(request):
    return load_robot(ROOT / request.param).normal


@pytest.fixture(scope="module")
def pirate():
    return load_robot(ROOT / "hardware_profiles" / "pirate_ii").normal


def index(robot, name):
    return robot.table.command_index[name]


def fits(states, need):
    return all(states[region] in names for region, names in need.items())


def said(robot, need):
    return {robot.regions[region]: names for region, names in need.items()}


def test_what_it_needs_is_where_the_engine_takes_it_and_nowhere_else(robot):
    for command in range(len(robot.commands)):
        found = needs(robot, command)
        for number, states in enumerate(robot.table.configurations):
            taken = any(fits(states, need) for need in found.any_of)
            if found.unless is not None:
                taken = not fits(states, found.unless)
            assert taken is not bool(refusal(robot, at_rest_in(robot, number), command))
        assert not found.partly


def test_each_change_is_one_that_the_chart_makes_and_none_is_left_out(robot):
    table = robot.table
    for command in range(len(robot.commands)):
        told = {
            (change.region, before, change.after)
            for change in changes(robot, command)
            for before in change.before
        }
        made = {
            (region, before, after)
            for number in taken_in(robot, command)
            for region, (before, after) in enumerate(
                zip(
                    table.configurations[number],
                    table.configurations[table.follow(number, command)],
                    strict=True,
                )
            )
            if before != after
        }
        assert told == made


def test_regions_that_do_not_matter_are_not_named(pirate):
    found = needs(pirate, index(pirate, "ClampFront"))

    assert set(said(pirate, *found.any_of)) == {
        "FrontWheelsState",
        "RearWheelsState",
        "BendingState",
    }
    assert needs(pirate, index(pirate, "ToggleLighting")).any_of == ({},)


def test_what_is_taken_nearly_everywhere_is_told_by_its_exception(pirate):
    found = needs(pirate, index(pirate, "Brake"))

    assert said(pirate, found.unless) == {
        "FrontWheelsState": ("Free", "Fixed"),
        "RearWheelsState": ("Free", "Fixed"),
    }


def test_a_region_that_decides_splits_what_is_needed():
    newt = load_robot(ROOT / "tests" / "robots" / "newt").normal
    found = needs(newt, index(newt, "GoAhead"))

    assert [said(newt, need) for need in found.any_of] == [
        {"Grip": ("NoseHeld", "TailHeld", "BothHeld"), "Crawl": ("Resting",)}
    ]


def test_a_command_moves_what_it_gives_another_value(pirate):
    def slots(command, after):
        return {
            pirate.slots[slot].name
            for change in changes(pirate, index(pirate, command))
            if change.after == after
            for slot in change.slots
        }

    assert slots("ClampFront", "DoubleClamped") == {"bend_1", "bend_2"}
    assert slots("BendInto", "FrontClampedRearBending") == {"bend_3", "bend_4"}
    assert slots("ClampFront", "Fixed") == set()  # both states leave the wheels at zero
    assert slots("Brake", "Fixed") == {f"wheel_{number}" for number in range(1, 7)}


def test_what_only_happens_to_some_is_told_so(pirate):
    forward = changes(pirate, index(pirate, "DriveForward"))

    assert {(each.before, each.sometimes) for each in forward} == {
        (("DrivingBackward",), False),
        (("Fixed",), True),
    }


def test_groups_of_states_that_make_no_box_are_told_one_by_one(monkeypatch):
    newt = load_robot(ROOT / "tests" / "robots" / "newt").normal
    grip, lamp = newt.regions.index("Grip"), newt.regions.index("Lamp")
    groups = {("NoseHeld", "Lit"), ("TailHeld", "Dark")}
    taken = tuple(
        number
        for number, states in enumerate(newt.table.configurations)
        if (states[grip], states[lamp]) in groups
    )
    monkeypatch.setattr(command_needs, "taken_in", lambda *_: taken)

    found = needs(newt, 0)

    assert (len(found.any_of), found.unless, found.partly) == (2, None, False)
    for number, states in enumerate(newt.table.configurations):
        assert any(fits(states, need) for need in found.any_of) is (number in taken)

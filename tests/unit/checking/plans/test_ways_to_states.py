"""The way to named states; where there is none, why."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pirate_sm.checking.plans import way_to
from pirate_sm.core.generated_missions import by_hand
from pirate_sm.core.loading import load_robot, read_states
from pirate_sm.core.robot import at_rest_in, states_of

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture(scope="module")
def robot():
    return load_robot(ROOT / "hardware_profiles" / "pirate_ii")


def way(loaded, begin, **wanted):
    body = at_rest_in(loaded.normal, loaded.table.index_of(begin))
    program = replace(by_hand(loaded).program, rules=loaded.rules)
    return way_to(loaded.normal, program, body, read_states(loaded.table, wanted))


LYING = ("Free", "Free", "Unclamped", "Unaligned", "Off")
HELD = ("Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off")


def test_regions_that_are_not_named_do_not_matter(robot):
    found = way(robot, LYING, BendingState="DoubleClamped")

    assert states_of(robot.normal, found.plan.body)[2] == "DoubleClamped"
    assert len(found.plan.steps) == 2
    assert found.reason == ""


def test_nothing_is_needed_where_it_is_so_already(robot):
    assert way(robot, HELD, BendingState="DoubleClamped").plan.steps == ()


def test_what_only_a_reset_brings_about_is_not_proposed(robot):
    found = way(robot, HELD, BendingState="Unclamped")

    assert found.plan is None
    assert "Reset: it lets go of front and rear" in found.reason


def test_states_that_exclude_each_other_are_named_and_no_others(robot):
    found = way(
        robot, LYING, LightingState="On", BendingState="DoubleClamped", FrontWheelsState="Free"
    )

    assert found.plan is None
    assert found.reason == (
        "no commands ever lead to BendingState DoubleClamped and FrontWheelsState Free: "
        "with BendingState DoubleClamped, FrontWheelsState is Fixed, DrivingForward or "
        "DrivingBackward"
    )


@pytest.fixture
def one_way(tmp_path):
    """The newt without its only way back to a loose grip."""
    newt = ROOT / "tests" / "robots" / "newt"
    chart = (newt / "chart.yaml").read_text("utf-8")
    assert chart.count("              - {event: Home, target: Grip.Loose}\n") == 3
    chart = chart.replace("              - {event: Home, target: Grip.Loose}\n", "")
    (tmp_path / "chart.yaml").write_text(chart, "utf-8")
    (tmp_path / "profile.yaml").write_text((newt / "profile.yaml").read_text("utf-8"), "utf-8")
    return load_robot(tmp_path)


def test_a_state_that_nothing_leads_back_to_is_named(one_way):
    found = way(one_way, ("NoseHeld", "Resting", "Dark"), Grip="Loose", Lamp="Lit")

    assert found.plan is None
    assert found.reason == "no commands lead from here to Grip Loose"
